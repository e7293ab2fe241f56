// SPDX-License-Identifier: Apache-2.0
// How much work records are: the rounds of a render with a time limit, the gather rays of its first
// round, from the costs measured so far, the rays of indirect bounces, and the points at which
// records are compared.
#include <string.h>

#include "render/render_budget.h"

// The first rounds have these factors of a, so that the image is covered whenever the time is over.
// Then a and the least radius fall by FINER from round to round, because records soon become as
// dense as their least radius allows, until they are FLOOR_PIXELS wide.
static const float GIVEN_WIDTHS[] = {2.5f, 1.6f, 1.0f, 0.75f, 0.55f};
static const float FINER = 0.75f, FLOOR_PIXELS = 0.5f;
enum { GIVEN_ROUNDS = sizeof GIVEN_WIDTHS / sizeof *GIVEN_WIDTHS };

// Limits of the factor by which a level makes more records than the one before it. The factor falls
// towards 1: 2.1, 3.1, 2.3, 1.8, 1.2 in a furnished room, 1.4, 1.0, 1.6, 1.3, .9 in a closed one.
static const float GROWTH_LEAST = 1.5f, GROWTH_MOST = 4.0f;
static const double GROWTH_FADES = 0.8;
// The least number of gather rays of an irradiance record. For a radiance record it is larger in
// the ratio of the options' numbers of rays.
static const float RAYS_LEAST = 32.0f;
// Records that one gather ray among hundreds reads may be coarser than those that the image reads,
// and more so with every bounce: per bounce, the accuracy a is multiplied by the first factor and
// the number of rays by the second.
static const float COARSER = 1.25f, FEWER = 0.6f;
static const float BOUNCE_RAYS_LEAST = 64.0f;
enum { RAYS_STEPS = 30 };  // steps of the search for their number, to the precision of a float

enum {
    // The largest number of points of the image that adaptive caching compares: their sites are 88
    // MB. A larger image has them at a larger distance.
    ADAPTIVE_MOST = 1 << 18,
    ADAPTIVE_STRIDE = 2
};

// ---- Rounds -------------------------------------------------------------------------------------

float render_budget_widest(const satin_options *o) {
    const float width = fmaxf(o->irradiance_widen, o->radiance_widen);
    return o->time > 0.0 ? fmaxf(width, GIVEN_WIDTHS[0]) : width;
}

// The finest factor w of a for a least radius of `min_pixels` at a: the least radius falls as w,
// and so the least width of a record as w^2.
static float finest_width(float min_pixels) {
    const float last = GIVEN_WIDTHS[GIVEN_ROUNDS - 1];
    return fminf(sqrtf(FLOOR_PIXELS * last / fmaxf(min_pixels, FLOOR_PIXELS)), last);
}

struct render_widths render_budget_round(const satin_options *o, int round) {
    const int finer = round - (GIVEN_ROUNDS - 1);
    const float width = finer <= 0 ? GIVEN_WIDTHS[round]
                                   : GIVEN_WIDTHS[GIVEN_ROUNDS - 1] * powf(FINER, (float)finer);
    return (struct render_widths){{fmaxf(width, finest_width(o->irradiance_min_pixels)),
                                   fmaxf(width, finest_width(o->radiance_min_pixels))}};
}

int render_budget_rounds(const satin_options *o) {
    for (int rounds = GIVEN_ROUNDS;; rounds++) {
        const struct render_widths last = render_budget_round(o, rounds - 1);
        const struct render_widths next = render_budget_round(o, rounds);
        if (memcmp(&last, &next, sizeof last) == 0) return rounds;
    }
}

float render_budget_least_radius(float width) {
    return fminf(width / GIVEN_WIDTHS[GIVEN_ROUNDS - 1], 1.0f);
}

// ---- Rays of the first round --------------------------------------------------------------------

// The first round must cover the image in a fraction of the time of records, whatever their number:
// in furnished rooms it is some thousand. Rays are allocated so that the noise of all pixels is
// least: in proportion to the square root of the area in which a record is used, that is to the
// stride of its level.
float render_budget_rays(const satin_options *o, const struct render_covering *covering,
                         int stride) {
    const float least = RAYS_LEAST / (float)o->irradiance_rays;
    return fminf(fmaxf(covering->rays * (float)stride / RENDER_COARSEST, least), 1.0f);
}

void render_budget_level(const satin_options *o, struct render_covering *covering, int stride,
                         double made, double seconds, double left) {
    struct render_covering *c = covering;
    double growth =
        (double)clampf((float)(made / fmax(c->records, 1.0)), GROWTH_LEAST, GROWTH_MOST);
    double lo = 0.0, hi = RENDER_COARSEST;
    c->seconds += seconds;
    c->full += made * (double)render_budget_rays(o, c, stride);
    c->records = made;
    if (stride == 1) return;  // the finer rounds have the same speed
    const double budget = left * c->full / c->seconds;
    double next[RENDER_LEVELS];  // records of the finer levels
    int levels = 0;
    for (int s = stride / 2; s > 0; s /= 2) {
        growth = 1.0 + GROWTH_FADES * (growth - 1.0);
        next[levels++] = made *= growth;
    }
    for (int step = 0; step < RAYS_STEPS; step++) {
        double need = 0.0;
        c->rays = (float)(0.5 * (lo + hi));
        for (int i = 0; i < levels; i++)
            need += next[i] * (double)render_budget_rays(o, c, stride >> (i + 1));
        if (need < budget)
            lo = (double)c->rays;
        else
            hi = (double)c->rays;
    }
    c->rays = (float)lo;
}

// ---- Indirect bounces ---------------------------------------------------------------------------

static int bounce_rays(int rays, int bounce) {
    return (int)fmaxf(fminf(BOUNCE_RAYS_LEAST, (float)rays),
                      (float)rays * powf(FEWER, (float)bounce));
}

void render_budget_bounce(satin_options *o, int bounce) {
    const float coarser = powf(COARSER, (float)bounce);
    o->irradiance_rays = bounce_rays(o->irradiance_rays, bounce);
    o->radiance_rays = bounce_rays(o->radiance_rays, bounce);
    o->irradiance_a *= coarser;
    o->radiance_a *= coarser;
}

// ---- Points of adaptive caching -----------------------------------------------------------------

int render_budget_adaptive_stride(int width, int height) {
    int stride = ADAPTIVE_STRIDE;
    while ((int64_t)width * height / stride / stride > ADAPTIVE_MOST) stride++;
    return stride;
}
