// SPDX-License-Identifier: Apache-2.0
// First pass `recursive` [K05 2.1]: records for each indirect bounce beyond the first, from the
// deepest level up. Level i is gathered with i edges less than the longest path; its gather rays
// read level i + 1, which is finished then. Sites are the ends of random walks from the image, so
// the records depend on these alone, and where rays ask later and no record is near, they go on.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_state.h"

enum {
    WALKS = 32768,  // per level
    FIRST = 512     // that are filled before the others, in blocks that double
};

// What is read by one gather ray among hundreds may be coarser than what is seen, more so with
// every bounce: a grows, rays fall by these factors per level.
static const float COARSER = 1.25f, FEWER = 0.6f;
static const float RAYS_LEAST = 64.0f;

// Sites of a batch lie apart by so many least radii.
static const float SPACING = 2.0f;

// Records of one indirect bounce, and what made them.
struct render_level {
    satin_options options;
    struct gather gather;
    struct shade shade;
    struct cache *cache;
};

struct walks {
    const struct shade *shade;
    const satin_options *image;
    int level;
    struct cache_site *site;
    bool *found;
};

static int fewer(int rays, int level) {
    return (int)fmaxf(fminf(RAYS_LEAST, (float)rays), (float)rays * powf(FEWER, (float)level));
}

static satin_options level_options(const satin_options *image, int level) {
    satin_options o = *image;
    if (o.max_depth >= 0) o.max_depth -= level;
    o.irradiance_rays = fewer(o.irradiance_rays, level);
    o.radiance_rays = fewer(o.radiance_rays, level);
    const float coarser = powf(COARSER, (float)level);
    o.irradiance_a *= coarser;
    o.radiance_a *= coarser;
    // Sites come with their least radius in place of a pixel's width.
    o.irradiance_min_pixels = o.radiance_min_pixels = 1.0f;
    o.irradiance_max_pixels = o.radiance_max_pixels = INFINITY;
    return o;
}

static void follow_walks(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    const struct walks *w = ctx;
    const uint64_t width = (uint64_t)w->image->width, height = (uint64_t)w->image->height;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(w->image->seed, RNG_LEVEL, (uint64_t)w->level << 32 | i);
        int x = (int)(rng_u32(&rng) * width >> 32), y = (int)(rng_u32(&rng) * height >> 32);
        w->found[i] = shade_walk(w->shade, x, y, w->level, &w->site[i]);
    }
}

static satin_status fill_from_walks(struct render *r, struct render_level *level,
                                    struct walks *walks) {
    if (!parallel_for(r->pool, WALKS, 64, follow_walks, walks)) return SATIN_CANCELLED;
    const satin_options *o = &level->options;
    const float a[CACHE_KINDS] = {o->irradiance_a, o->radiance_a};
    struct cache_fill fill = {.widest = fmaxf(o->irradiance_widen, o->radiance_widen),
                              .spacing = SPACING};
    satin_status status = SATIN_OK;
    for (size_t i = 0, next = FIRST; i < WALKS && status == SATIN_OK; i = next, next = 2 * i) {
        struct cache_site *site = walks->site + i;
        size_t count = 0;
        for (size_t k = i; k < next; k++)
            if (walks->found[k]) site[count++] = walks->site[k];
        fill.site = site;
        fill.count = count;
        for (enum cache_kind kind = CACHE_IRRADIANCE; kind < CACHE_KINDS && status == SATIN_OK;
             kind++) {
            fill.a = a[kind];
            status = cache_fill(level->cache, kind, &fill);
        }
    }
    return status;
}

static satin_status make_level(struct render *r, int index, struct walks *walks) {
    struct render_level *level = &r->second_pass.levels[index - 1];
    level->options = level_options(&r->options, index);
    level->gather = r->second_pass.gather;  // with the records of the level below
    level->gather.options = &level->options;
    level->cache = cache_new(&level->gather, r->second_pass.tables.order, r->pool);
    if (!level->cache) return SATIN_ERROR_MEMORY;
    level->shade = (struct shade){
        .g = &level->gather,
        .tables = &r->second_pass.tables,
        .cache = level->cache,
        .a_irradiance = level->options.irradiance_a * level->options.irradiance_widen,
        .a_radiance = level->options.radiance_a * level->options.radiance_widen};
    film_filter_make(&r->scene.film, &level->shade.filter);
    walks->shade = &level->shade;
    walks->level = index;
    satin_status status = fill_from_walks(r, level, walks);
    r->second_pass.gather.next = (struct gather_level){shade_known, &level->shade, &level->gather};
    return status;
}

// Levels that the longest path reaches: four edges lead from the eye to a light that lights what a
// record of level 1 sees.
static int levels_wanted(const satin_options *o) {
    if (o->first_pass != SATIN_FIRST_RECURSIVE) return 0;
    const int longest = o->max_depth - 3;
    return o->max_depth >= 0 && longest < o->recursive_levels ? longest : o->recursive_levels;
}

satin_status render_levels(struct render *r) {
    const int count = levels_wanted(&r->options);
    if (count <= 0) return SATIN_OK;
    render_stage_begin(r, STAGE_LEVELS, 0.0);
    struct walks walks = {.image = &r->options};
    walks.site = array_new(WALKS, sizeof *walks.site);
    walks.found = array_new(WALKS, sizeof *walks.found);
    r->second_pass.levels = calloc((size_t)count, sizeof *r->second_pass.levels);
    satin_status status = SATIN_ERROR_MEMORY;
    if (walks.site && walks.found && r->second_pass.levels) status = SATIN_OK;
    r->second_pass.level_count = r->second_pass.levels ? count : 0;
    const double start = render_elapsed(r);
    for (int i = count; i > 0 && status == SATIN_OK; i--) {
        double done = (double)(count - i) / count;
        render_stage_part(r, done, 1.0 / count);
        render_limit_levels(r, start, done + 1.0 / count);
        status = render_limit_end(r, make_level(r, i, &walks));
    }
    size_t records = 0;
    for (int i = 0; i < r->second_pass.level_count && r->second_pass.levels[i].cache; i++)
        records += cache_count(r->second_pass.levels[i].cache, CACHE_IRRADIANCE) +
                   cache_count(r->second_pass.levels[i].cache, CACHE_RADIANCE);
    stats_set(&r->stats, "records.deeper", (double)records);
    free(walks.site);
    free(walks.found);
    return status;
}

void render_levels_free(struct render *r) {
    for (int i = 0; i < r->second_pass.level_count; i++) cache_free(r->second_pass.levels[i].cache);
    free(r->second_pass.levels);
}
