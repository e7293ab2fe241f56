// SPDX-License-Identifier: Apache-2.0
// How many rays find emission at rims, and whether a time limit that is over leaves them out.
#include "render/render_budget.h"

#include "render/render_image.h"

enum {
    // Rays of one pixel at a rim, a power of two: whole nets. Just beyond the edge of a lamp the
    // filter's tail sees some thousandths of it, which light the pixel as much as all else: with
    // 128 rays, means of 5x5 pixels of metal-room were up to 7 % off there.
    RIM_RAYS_LEAST = 128,
    // In metal-room at 640x640, 512, 1024 and 2048 leave 8.0, 2.5 and 1.0e-6 of emission's relMSE
    // for .5, .9 and 1.8 CPU seconds, of 180 at production; at 1000x1000 5.9, 2.4 and .8e-6 for .8,
    // 1.4 and 2.8. Up to 400x400, RIM_RAYS_MEAN allows no more than 1024 there.
    RIM_RAYS_MOST = 1024,
    RIM_RAYS_SAMPLE = 32,  // for each sample of the pixel; 1024 at production
    // For each core second of a time limit: 1 % of 6.5 core seconds at 200x200, and .3 of 16 at
    // 400x400. With 32, half of the error of all pixels was that of the lamp's edges in
    // cornell-glossy (200x200): relMSE x 10^4 of .88 instead of .62 in these 6.5 seconds.
    RIM_RAYS_CORE_SECOND = 128
};
// The number of rays at rims per pixel of the whole image, if it is more than twice that of the
// rays of each. Where one pixel in twelve is at a rim, as in a room with many windows, 16 leave
// .0007 of emission's relMSE instead of .0020 with 2, for 2 % of 12 CPU seconds at 320x180. The
// time of drafts of the data scenes, which have few such pixels, changes by less than the
// difference between runs.
static const double RIM_RAYS_MEAN = 16.0;
// That after a time limit, which they exceed. With 16, in a room with many windows at 640x360, a
// limit of 12 CPU seconds ended after 13.5.
static const double RIM_RAYS_MEAN_LATE = 2.0;
// The largest fraction of a time limit for rays at rims. RIM_RAYS_MEAN alone takes 11 and 17 % of
// 10 s in two furnished rooms at 640x360, where this leaves .76 and .8 of the error.
static const double RIMS_FRACTION = 0.05;
// The time of emission that is sampled after a limit, at one pixel of the film [core s], until it
// is measured by first rays. It is .05 to .9e-6 in most scenes and 2 to 5e-6 where all is seen
// through glass. With that of rays at rims, which is half of it in the mean, a room that is seen
// through a glass sphere had 1.5 times the error.
static const double RIMS_SECONDS = 0.7e-6;
// The largest fraction of the limit for it: 4000x2250 pixels take 12 s, whatever the limit.
static const double RIMS_LATE = 0.5;

// The time of emission after the limit, if it is not sampled before.
static double late_rims_seconds(const struct render *r) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    const double measured = r->progress.rim_pixel_seconds;
    if (!render_has_rims(r) || (r->image && r->image->rims_taken)) return 0.0;
    return (measured > 0.0 ? measured : RIMS_SECONDS) * pixels / parallel_cores_had(r->pool);
}

double render_budget_late_rims(const struct render *r) {
    const double seconds = render_agreed(r, late_rims_seconds(r));
    return seconds <= RIMS_LATE * r->options.time ? seconds : 0.0;
}

void render_budget_time_rims(struct render *r) {
    if (r->options.time > 0.0 && render_has_rims(r))
        r->progress.rim_pixel_seconds = render_rims_ray_seconds(r);
}

uint32_t render_budget_rim_rays(const satin_options *o, double core_seconds,
                                const struct render_rim_rays *rims) {
    const bool timed = o->time > 0.0;
    const double wanted =
        timed ? RIM_RAYS_CORE_SECOND * core_seconds : (double)(RIM_RAYS_SAMPLE * (uint64_t)o->spp);
    const double mean = rims->late ? RIM_RAYS_MEAN_LATE : fmax(RIM_RAYS_MEAN, 2.0 * rims->first);
    const double fit =
        timed && rims->seconds > 0.0 ? RIMS_FRACTION * core_seconds / rims->seconds : INFINITY;
    const double most = fmin(mean / rims->fraction, fit);
    uint32_t rays = RIM_RAYS_MOST;
    while (rays > RIM_RAYS_LEAST && rays > wanted) rays /= 2;
    while (rays > most) rays /= 2;
    return rays;
}
