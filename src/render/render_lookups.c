// SPDX-License-Identifier: Apache-2.0
// The cost and the noise of the first pass by itself, as statistics first_pass.*: what a few gather
// rays read, from surfaces that the image shows. If hardly any of them read photons, as outdoors,
// where light comes from the sky and most photons return to it, none is looked up.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_state.h"

// Gather rays, at most one for each pixel. They find the noise of most first passes to some 5 %, in
// a hundredth of a second.
enum { LOOKUPS_MOST = 1024 };

struct lookup_rays {
    const struct shade *shade;
    const satin_options *image;
    struct ray *ray;
    bool *found;
};

static void draw_lookups(void *ctx, size_t begin, size_t end, int worker) {
    const struct lookup_rays *rays = ctx;
    const uint64_t width = (uint64_t)rays->image->width, height = (uint64_t)rays->image->height;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(rays->image->seed, RNG_LOOKUP, i);
        const int x = (int)(rng_u32(&rng) * width >> 32), y = (int)(rng_u32(&rng) * height >> 32);
        struct shade shade = *rays->shade;
        shade.camera = scene_camera_sample(shade.g->scene, (uint32_t)i);
        rays->found[i] = shade_walk_ray(&shade, x, y, &rays->ray[i]);
    }
}

static void set_noise(struct stats *stats, const struct gather_noise *noise) {
    stats_set(stats, "first_pass.lookups", (double)noise->lookups);
    stats_set(stats, "first_pass.read", noise->read);
    stats_set(stats, "first_pass.error", noise->error);
    stats_set(stats, "first_pass.error_sampled", noise->sampled);
    stats_set(stats, "first_pass.error_stored", noise->stored);
    stats_set(stats, "first_pass.lookup_cpu_s", noise->cpu_s);
}

// The least fraction of gather rays that read photons. A lookup that is not reliable takes longer
// than the path that replaces it. In 52 rooms and data scenes at 4 seconds the fraction is .58 or
// more, in three outdoor scenes at most .05, where without lookups .57 and .77 times the relMSE
// are left.
static const double READ_LEAST = 0.25;

// Whether lookups may be ended: where the user has chosen how many photons there are, they are
// read.
static bool may_end_lookups(const struct render *r) {
    const satin_options *o = &r->options;
    return !r->first_pass.photons_chosen &&
           (photon_precomputes(o) || o->first_pass == SATIN_FIRST_PHOTONS);
}

// Measures the noise by these rays. If too few read photons, ends their lookups and measures that.
static satin_status measure_lookups(struct render *r, const struct ray *ray, size_t count,
                                    struct gather_noise *noise) {
    struct gather *g = &r->second_pass.gather;
    const satin_status status = gather_noise_measure(g, ray, count, r->pool, noise);
    const double read = noise->read;
    if (status != SATIN_OK || !may_end_lookups(r) || !(noise->lookups > 0 && read < READ_LEAST))
        return status;
    log_message(r->log, SATIN_LOG_INFO,
                "%.0f %% of gather rays find photons that are near enough: all go on as paths",
                100.0 * read);
    gather_end_lookups(g);
    const satin_status again = gather_noise_measure(g, ray, count, r->pool, noise);
    noise->read = read;
    return again;
}

satin_status render_lookup_noise(struct render *r) {
    const satin_options *o = &r->options;
    if (!gather_indirect(o, 1)) return SATIN_OK;
    const size_t pixels = (size_t)o->width * (size_t)o->height;
    const size_t count = pixels < LOOKUPS_MOST ? pixels : LOOKUPS_MOST;
    struct lookup_rays rays = {&r->second_pass.shade, o, array_new(count, sizeof *rays.ray),
                               array_new(count, sizeof *rays.found)};
    satin_status status = rays.ray && rays.found ? SATIN_OK : SATIN_ERROR_MEMORY;
    struct gather_noise noise = {0};
    const char *part = parallel_begin_part(r->pool, "lookups");
    if (status == SATIN_OK) {
        size_t found = 0;
        parallel_for_all(r->pool, count, 64, draw_lookups, &rays);
        for (size_t i = 0; i < count; i++)
            if (rays.found[i]) rays.ray[found++] = rays.ray[i];
        status = measure_lookups(r, rays.ray, found, &noise);
    }
    parallel_begin_part(r->pool, part);
    if (status == SATIN_OK) set_noise(&r->stats, &noise);
    free(rays.ray);
    free(rays.found);
    return status;
}
