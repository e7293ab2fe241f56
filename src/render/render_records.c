// SPDX-License-Identifier: Apache-2.0
// Fills the caches over the image's shading points, coarse to fine: every 32nd pixel in both
// directions, then those between, down to every pixel. The pixels of a level come in a scrambled
// order, so that a batch is spread over the image.
#include <stdlib.h>
#include <string.h>

#include "render/render_state.h"

enum {
    LEVELS = 6,
    RECORDS_COARSEST = 1 << (LEVELS - 1),  // pixels; the last level has every one
    BLOCK_PIXELS = 65536,                  // whose sites are held at a time
};

// A level makes more records than the one before it, by a factor that falls towards 1: 2.1, 3.1,
// 2.3, 1.8, 1.2 in a furnished room, 1.4, 1.0, 1.6, 1.3, .9 in a closed one.
static const float GROWTH_LEAST = 1.5f;
static const double GROWTH_FADES = 0.8;
// Gather rays of an irradiance record at least; a radiance record has as many times more as the
// options say.
static const float RAYS_LEAST = 32.0f;

// With a time limit: factors of a in rounds that follow each other, so that the image is covered
// whenever the time is over. Then a and the least radius fall by TIMED_FINER from round to round,
// as records are soon as dense as their least radius lets them be, until they are FLOOR_PIXELS
// wide.
static const float TIMED_WIDEN[] = {2.5f, 1.6f, 1.0f, 0.75f, 0.55f};
static const float TIMED_FINER = 0.75f, FLOOR_PIXELS = 0.5f;
enum { TIMED_GIVEN = sizeof TIMED_WIDEN / sizeof *TIMED_WIDEN };

// The filling under way.
struct filling {
    struct render *r;
    int stride;      // pixels between the sites of the level under way
    float rays;      // fraction of the options' gather rays that records of the coarsest level get
    double records;  // that the last level made
    double full, seconds;  // of all levels: records, each weighed by its fraction of the rays; time
    struct render_sites sites;
};

float render_widest(const struct render *r) {
    float w = fmaxf(r->options.irradiance_widen, r->options.radiance_widen);
    return r->options.time > 0.0 ? fmaxf(w, TIMED_WIDEN[0]) : w;
}

static double count_records(const struct render *r) {
    return (double)(cache_count(r->second_pass.cache, CACHE_IRRADIANCE) +
                    cache_count(r->second_pass.cache, CACHE_RADIANCE));
}

// With a time limit the image is to be covered by the first round, in a part of the time that
// records have, however many that takes: in furnished rooms some thousand. Rays are allocated so
// that the noise of all pixels is least, in proportion to the root of the area that a record
// serves: to the stride of its level.
static float fraction_of_rays(const struct filling *f, int stride) {
    const float least = RAYS_LEAST / (float)f->r->options.irradiance_rays;
    return fminf(fmaxf(f->rays * (float)stride / RECORDS_COARSEST, least), 1.0f);
}

// After a level that made `made` records in `seconds`, `left` levels before the last.
static void pace(struct filling *f, int left, double made, double seconds) {
    const struct render *r = f->r;
    double growth = clampf((float)(made / fmax(f->records, 1.0)), GROWTH_LEAST, 4.0f);
    double next[LEVELS], lo = 0.0, hi = RECORDS_COARSEST;
    f->records = made;
    f->seconds += seconds;
    f->full += made * (double)fraction_of_rays(f, f->stride);
    if (left == 0) return;  // the finer rounds go on as this one did
    for (int i = 0; i < left; i++) {
        growth = 1.0 + GROWTH_FADES * (growth - 1.0);
        next[i] = made *= growth;
    }
    const double budget = render_budget_first_round(r) * f->full / f->seconds;
    for (int step = 0; step < 30; step++) {
        double need = 0.0;
        f->rays = (float)(0.5 * (lo + hi));
        for (int i = 0; i < left; i++)
            need += next[i] * (double)fraction_of_rays(f, f->stride >> (i + 1));
        if (need < budget)
            lo = (double)f->rays;
        else
            hi = (double)f->rays;
    }
    f->rays = (float)lo;
}

// The factors of a for either kind of records.
struct widths {
    float of[CACHE_KINDS];
};

// Fills all levels at `widen` times a; the loops are the part [done, done + span] of the stage.
// `covering`: the numbers of rays are such that the image is covered in time.
static satin_status fill_levels(struct filling *f, struct widths widen, bool covering, double done,
                                double span) {
    struct render *r = f->r;
    struct cache *cache = r->second_pass.cache;
    const float a[CACHE_KINDS] = {r->options.irradiance_a, r->options.radiance_a};
    satin_status status = SATIN_OK;
    f->stride = RECORDS_COARSEST;
    for (int level = 0; level < LEVELS && status == SATIN_OK; level++, f->stride /= 2) {
        const double start = stats_wall(), before = count_records(r);
        render_stage_part(r, done + span * level / LEVELS, span / LEVELS);
        status = cache_limit_rays(cache, fraction_of_rays(f, f->stride));
        size_t count;
        uint32_t *pixel = render_grid(r, f->stride, level > 0, &count);
        if (!pixel) status = SATIN_ERROR_MEMORY;
        for (size_t i = 0; i < count && status == SATIN_OK; i += BLOCK_PIXELS) {
            const size_t block = count - i < BLOCK_PIXELS ? count - i : BLOCK_PIXELS;
            status = render_find_sites(r, pixel + i, block, false, &f->sites);
            for (enum cache_kind kind = CACHE_IRRADIANCE; kind < CACHE_KINDS && status == SATIN_OK;
                 kind++) {
                const struct cache_fill fill = {.site = f->sites.site,
                                                .count = f->sites.count,
                                                .a = a[kind] * widen.of[kind],
                                                .widest = render_widest(r),
                                                .spacing = 1.5f * (float)f->stride};
                status = cache_fill(cache, kind, &fill);
            }
        }
        free(pixel);
        if (covering) pace(f, LEVELS - 1 - level, count_records(r) - before, stats_wall() - start);
    }
    return status;
}

// The image reads the records at these factors of a.
static void read_at(struct render *r, float irradiance, float radiance) {
    r->second_pass.shade.a_irradiance = r->options.irradiance_a * irradiance;
    r->second_pass.shade.a_radiance = r->options.radiance_a * radiance;
}

// The finest factor w of a where the least radius is so many pixels at a: it falls as w does, and
// so a record's least width as w^2.
static float finest_width(float min_pixels) {
    const float last = TIMED_WIDEN[TIMED_GIVEN - 1];
    return fminf(sqrtf(FLOOR_PIXELS * last / fmaxf(min_pixels, FLOOR_PIXELS)), last);
}

static struct widths round_widths(const satin_options *o, int round) {
    const int finer = round - (TIMED_GIVEN - 1);
    const float width = finer <= 0 ? TIMED_WIDEN[round]
                                   : TIMED_WIDEN[TIMED_GIVEN - 1] * powf(TIMED_FINER, (float)finer);
    return (struct widths){{fmaxf(width, finest_width(o->irradiance_min_pixels)),
                            fmaxf(width, finest_width(o->radiance_min_pixels))}};
}

// Rounds until one would be as fine as the one before it.
static int count_rounds(const satin_options *o) {
    int rounds = TIMED_GIVEN;
    for (;; rounds++) {
        const struct widths last = round_widths(o, rounds - 1), next = round_widths(o, rounds);
        if (memcmp(&last, &next, sizeof last) == 0) return rounds;
    }
}

// With a time limit: rounds of ever finer records. The image reads them at the finest accuracy that
// was finished.
static satin_status fill_timed(struct filling *f) {
    struct render *r = f->r;
    satin_status status = SATIN_OK;
    struct widths finished = round_widths(&r->options, 0);
    const int rounds = count_rounds(&r->options);
    render_limit_records(r, NULL);
    read_at(r, TIMED_WIDEN[0], TIMED_WIDEN[0]);
    double start = stats_wall();
    for (int i = 0; i < rounds && status == SATIN_OK; i++) {
        const struct widths widen = round_widths(&r->options, i);
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
            cache_limit_radius(r->second_pass.cache, k,
                               fminf(widen.of[k] / TIMED_WIDEN[TIMED_GIVEN - 1], 1.0f));
        status = fill_levels(f, widen, i == 0, (double)i / rounds, 1.0 / rounds);
        if (!render_time_remains(r)) break;
        finished = widen;
        stats_set(&r->stats, "records.rounds", i + 1.0);
        if (i > 0) continue;
        struct render_pace pace = {.rays = (double)cache_rays(r->second_pass.cache) /
                                           fmax(stats_wall() - start, 1e-9)};
        status = render_pilot(r, &pace);
        if (status == SATIN_OK) render_limit_records(r, &pace);
    }
    status = render_limit_end(r, status);
    const float E = finished.of[CACHE_IRRADIANCE], L = finished.of[CACHE_RADIANCE];
    read_at(r, fmaxf(E, fminf(E, 1.0f) * r->options.irradiance_widen),
            fmaxf(L, fminf(L, 1.0f) * r->options.radiance_widen));
    return status;
}

satin_status render_records(struct render *r) {
    struct filling f = {.r = r, .rays = RECORDS_COARSEST};
    const bool timed = r->options.time > 0.0;
    bool whole;
    render_stage_begin(r, STAGE_RECORDS, 0.0);
    satin_status status = render_cache_load(r, &whole);
    if (status == SATIN_OK && !whole && timed) status = fill_timed(&f);
    if (status == SATIN_OK && !whole && !timed)
        status = fill_levels(&f, (struct widths){{1.0f, 1.0f}}, false, 0.0, 1.0);
    if (status == SATIN_OK && !whole && !timed && r->options.adaptive_cache)
        status = render_adaptive_cache(r);
    if (status == SATIN_OK) r->outcome.saved = render_cache_save(r);
    render_sites_free(&f.sites);
    cache_statistics(r->second_pass.cache, &r->stats);
    return status;
}
