// SPDX-License-Identifier: Apache-2.0
// Budgets of records (render_budget.h): the rounds with a time limit, how many gather rays the
// records of each level of the first round get, so that it covers the image in its time, and the
// records of indirect bounces and of adaptive caching.
#include <string.h>

#include "render/render_budget.h"

// The first rounds have these factors of a, so that the image is covered whenever the time is over.
// Then a and the least radius fall by FINER from round to round, because records soon become as
// dense as their least radius allows, until they are FLOOR_PIXELS wide.
static const float GIVEN_FACTORS[] = {2.5f, 1.6f, 1.0f, 0.75f, 0.55f};
static const float FINER = 0.75f, FLOOR_PIXELS = 0.5f;
enum { GIVEN_ROUNDS = sizeof GIVEN_FACTORS / sizeof *GIVEN_FACTORS };

// The largest fraction of the remaining time of the first round for the search for a level's sites.
static const double SEARCH_FRACTION = 0.25;
// The least number of gather rays of an irradiance record. For a radiance record it is larger in
// the ratio of the options' numbers of rays. Most records of fewer are so unsure that they are
// gathered again, by all rays: in living-room (320x180, 15 CPU seconds, three seeds, without the
// worst .5 % of the pixels) the error was .0196, .0179, .0180, .0188 and .0222 with 32, 64, 100,
// 200 and 400, and that of 5x5 means of diffuse indirect light .0031, .0019, .0018, .0016, .0020.
static const float RAYS_LEAST = 100.0f;

// Rounds after the first one do not count records of less than this fraction of their rays, and
// make others there. That and the weights of records by their rays (cache_find.c): relMSE x 10^4 of
// cornell-metal at 10 CPU seconds (200x200, three seeds) 1.00 instead of 1.18, of its diffuse
// indirect light .39 instead of .56; with the weights alone 1.08 and .50, with .25 instead of half
// 1.07 and .41. At 5 seconds 1.66 instead of 1.89; cornell-glossy, vase, indirect-room and
// living-room within their noise.
static const float RAYS_COUNT = 0.5f;

// The factors by which each finer level makes more records than the one before it: geometric means
// of four furnished rooms, which had 2.1, 3.2, 2.2, 1.8, 1.3; 2.0, 3.2, 2.0, 1.6, 1.1; 1.8, 2.7,
// 1.5, 1.4, 1.0; 3.1, 2.2, 1.7, 1.9, 1.7. Empty rooms have less, so all are scaled by what the
// level that is planned has of its own, within these limits.
static const double GROWTH[RENDER_LEVELS - 1] = {2.2, 2.8, 1.8, 1.7, 1.2};
static const double GROWTH_LEAST = 0.5, GROWTH_MOST = 1.0;
// That of the second level before its sites are known: that of empty rooms, .1 to .3; in furnished
// rooms, it then gets less rays than the first, which has few records.
static const double GROWTH_UNKNOWN = 0.25;
// The fraction of the uncovered sites that get a record; it covers others too. It was .5 to 1, in
// the mean .7, at all levels but the first of ten rooms.
static const double RECORDS_PER_SITE = 0.7;
// The weight of earlier records in the speed, beside 1 of the last ones: rays of finer levels,
// whose records are at edges and ornaments, take up to three times as long.
static const double SPEED_FADES = 0.25;
enum { RAYS_STEPS = 30 };  // steps of the search for their number, to the precision of a float

// Records that one gather ray among hundreds reads may be coarser than those that the image reads,
// and more so with every bounce: per bounce, the accuracy a is multiplied by the first factor and
// the number of rays by the second.
static const float COARSER = 1.25f, FEWER = 0.6f;
static const float BOUNCE_RAYS_LEAST = 64.0f;

enum {
    // The largest number of points of the image that adaptive caching compares: their sites are 88
    // MB. A larger image has them at a larger distance.
    ADAPTIVE_MOST = 1 << 18,
    ADAPTIVE_STRIDE = 2
};

// ---- Rounds of records --------------------------------------------------------------------------

float render_budget_largest_factor(const satin_options *o) {
    const float factor = fmaxf(o->irradiance_widen, o->radiance_widen);
    return o->time > 0.0 ? fmaxf(factor, GIVEN_FACTORS[0]) : factor;
}

// The finest factor w of a for a least radius of `min_pixels` at a: the least radius falls as w,
// and so the least width of a record as w^2.
static float finest_factor(float min_pixels) {
    const float last = GIVEN_FACTORS[GIVEN_ROUNDS - 1];
    return fminf(sqrtf(FLOOR_PIXELS * last / fmaxf(min_pixels, FLOOR_PIXELS)), last);
}

struct render_factors render_budget_round(const satin_options *o, int round) {
    const int finer = round - (GIVEN_ROUNDS - 1);
    const float factor = finer <= 0 ? GIVEN_FACTORS[round]
                                    : GIVEN_FACTORS[GIVEN_ROUNDS - 1] * powf(FINER, (float)finer);
    return (struct render_factors){{fmaxf(factor, finest_factor(o->irradiance_min_pixels)),
                                    fmaxf(factor, finest_factor(o->radiance_min_pixels))}};
}

struct render_factors render_budget_search(const satin_options *o, int round) {
    const float most = render_budget_largest_factor(o);
    if (!(o->time > 0.0)) return (struct render_factors){{most, most}};
    if (round < 2) return (struct render_factors){{CACHE_WIDER * most, CACHE_WIDER * most}};
    const struct render_factors before = render_budget_round(o, round - 1);
    return (struct render_factors){{fminf(before.of[CACHE_IRRADIANCE] * o->irradiance_widen, most),
                                    fminf(before.of[CACHE_RADIANCE] * o->radiance_widen, most)}};
}

int render_budget_rounds(const satin_options *o) {
    for (int rounds = GIVEN_ROUNDS;; rounds++) {
        const struct render_factors last = render_budget_round(o, rounds - 1);
        const struct render_factors next = render_budget_round(o, rounds);
        if (memcmp(&last, &next, sizeof last) == 0) return rounds;
    }
}

float render_budget_least_radius(float factor) {
    return fminf(factor / GIVEN_FACTORS[GIVEN_ROUNDS - 1], 1.0f);
}

float render_budget_rays_least(bool covering) { return covering ? 0.0f : RAYS_COUNT; }

// ---- The first round ----------------------------------------------------------------------------

// Rays are allocated so that the noise of all pixels is least: in proportion to the square root of
// the area in which a record is used, that is to the stride of its level.
float render_covering_rays(const satin_options *o, const struct render_covering *c, int stride) {
    const float least = RAYS_LEAST / (float)o->irradiance_rays;
    return fminf(fmaxf(c->rays * (float)stride / RENDER_COARSEST, least), 1.0f);
}

double render_covering_search(const struct render_covering *c, double pixels) {
    return c->pixels > 0.0 ? pixels * c->search / c->pixels : 0.0;
}

bool render_covering_pays(const struct render_covering *c, double pixels, double left) {
    return !(render_covering_search(c, pixels) > SEARCH_FRACTION * left);
}

// The typical growth of the level of a stride below RENDER_COARSEST.
static double growth_at(int stride) {
    int level = 0;  // of the factor
    for (int s = RENDER_COARSEST / 2; s > stride; s /= 2) level++;
    return GROWTH[level];
}

// What the level of this stride, of `records` records, has of its typical growth.
static double growth_scale(const struct render_covering *c, int stride, double records) {
    if (stride == RENDER_COARSEST) return GROWTH_LEAST;
    const double typical = c->last * growth_at(stride);
    return fmin(fmax(records / fmax(typical, 1.0), GROWTH_LEAST), GROWTH_MOST);
}

void render_covering_plan(const satin_options *o, struct render_covering *c, int stride,
                          double pixels, double needed, double left) {
    c->rays = RENDER_COARSEST;
    if (!(c->full > 0.0)) return;
    double records[RENDER_LEVELS];  // of this level and of the finer ones
    int levels = 0;
    records[levels++] = RECORDS_PER_SITE * needed;
    double made = c->made + records[0];  // by the level

    const double scale = growth_scale(c, stride, made);
    for (int s = stride / 2; s > 0; s /= 2) {
        pixels *= 4.0;
        if (!render_covering_pays(c, pixels, left)) break;
        left -= render_covering_search(c, pixels);
        made *= growth_at(s) * (s == RENDER_COARSEST / 2 ? GROWTH_UNKNOWN : scale);
        records[levels++] = made;
    }
    const double budget = left * c->full / c->seconds;
    double lo = 0.0, hi = RENDER_COARSEST;
    for (int step = 0; step < RAYS_STEPS; step++) {
        double need = 0.0;
        c->rays = (float)(0.5 * (lo + hi));
        for (int i = 0; i < levels; i++)
            need += records[i] * (double)render_covering_rays(o, c, stride >> i);
        if (need < budget)
            lo = (double)c->rays;
        else
            hi = (double)c->rays;
    }
    c->rays = (float)lo;
}

void render_covering_filled(const satin_options *o, struct render_covering *c, int stride,
                            double made, double seconds) {
    c->made += made;
    c->all += made;
    c->all_full += made * (double)render_covering_rays(o, c, stride);
    c->seconds = SPEED_FADES * c->seconds + seconds;
    c->full = SPEED_FADES * c->full + made * (double)render_covering_rays(o, c, stride);
}

double render_covering_by_all_rays(const struct render_covering *c, double seconds) {
    return c->all_full > 0.0 ? seconds * c->all / c->all_full : seconds;
}

void render_covering_next(struct render_covering *c) {
    c->last = c->made;
    c->made = 0.0;
}

// ---- Views after the first one ------------------------------------------------------------------

bool render_budget_view_pays(double made, double pixels) {
    return !(made * RENDER_VIEW_PIXELS < pixels);
}

// ---- Records of indirect bounces ----------------------------------------------------------------

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
