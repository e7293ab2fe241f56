// SPDX-License-Identifier: Apache-2.0
// The first round of records with a time limit: how many gather rays the records of each level get,
// so that the round covers the image in its time.
#include "render/render_covering.h"

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

// Rays are allocated so that the noise of all pixels is least: in proportion to the square root of
// the area in which a record is used, that is to the stride of its level.
float render_covering_rays(const satin_options *o, const struct render_covering *c, int stride) {
    return fminf(fmaxf(c->rays * (float)stride / RENDER_COARSEST, render_budget_least_rays(o)),
                 1.0f);
}

double render_covering_search(const struct render_covering *c, double pixels) {
    return c->pixels > 0.0 ? pixels * c->search / c->pixels : 0.0;
}

bool render_covering_pays(const struct render_covering *c, double pixels, double left) {
    return !(render_covering_search(c, pixels) > render_budget_search(left));
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
    c->seconds = SPEED_FADES * c->seconds + seconds;
    c->full = SPEED_FADES * c->full + made * (double)render_covering_rays(o, c, stride);
}

void render_covering_next(struct render_covering *c) {
    c->last = c->made;
    c->made = 0.0;
}

// Nothing is decided by the coarsest level, whose growth is not known. Measured at 320x180:
// in a furnished room the second level shows that the rest takes 15 times the time that is left,
// and the denoised image has .6 of the error without records; in a room with one table and in
// closed ones all rays fit three times or more.
bool render_covering_without_records(const satin_options *o, const struct render_covering *c,
                                     int stride) {
    return o->denoise && stride < RENDER_COARSEST && c->rays < RENDER_COARSEST;
}
