// SPDX-License-Identifier: Apache-2.0
// First pass `recursive` [K05 2.1]: records for each indirect bounce. Bounce 1 is at the surfaces
// that gather rays from the image hit; the records of the last bounce are made first. Those of
// bounce i are gathered with i segments fewer than max_depth; their gather rays read the records of
// bounce i + 1, which are complete by then. Sites are the ends of random walks from the image, and
// the records depend on these alone. If a gather ray finds no record near its hit, its path
// continues instead.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_state.h"

// The distance of the sites of a batch, in least radii.
static const float SPACING = 2.0f;

// The records of one indirect bounce, and the constants with which they are gathered.
struct render_bounce {
    satin_options options;
    struct gather gather;
    struct shade shade;
    struct cache *cache;
};

struct walks {
    const struct shade *shade;
    const satin_options *image;
    int bounce;
    struct fill_site *site;
    bool *found;
};

static satin_options bounce_options(const satin_options *image, int bounce) {
    satin_options o = *image;
    if (o.max_depth >= 0) o.max_depth -= bounce;
    render_budget_bounce(&o, bounce);
    // The sites hold their least radius instead of a pixel's width.
    o.irradiance_min_pixels = o.radiance_min_pixels = 1.0f;
    o.irradiance_max_pixels = o.radiance_max_pixels = INFINITY;
    return o;
}

static void follow_walks(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    const struct walks *w = ctx;
    const uint64_t width = (uint64_t)w->image->width, height = (uint64_t)w->image->height;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(w->image->seed, RNG_BOUNCE, (uint64_t)w->bounce << 32 | i);
        int x = (int)(rng_u32(&rng) * width >> 32), y = (int)(rng_u32(&rng) * height >> 32);
        struct shade shade = *w->shade;
        shade.camera = scene_camera_sample(shade.g->scene, (uint32_t)i);
        w->found[i] = shade_walk(&shade, x, y, w->bounce, &w->site[i]);
    }
}

static satin_status make_walk_records(struct render *r, struct fill *fill, struct walks *walks) {
    if (!parallel_for(r->pool, RENDER_WALKS, 64, follow_walks, walks)) return SATIN_CANCELLED;
    const satin_options *o = walks->shade->g->options;
    struct cache_options options[CACHE_KINDS];
    cache_options_of(o, options);
    struct fill_sites sites = {.factor_max = fmaxf(o->irradiance_widen, o->radiance_widen),
                               .spacing = SPACING};
    satin_status status = SATIN_OK;
    for (size_t i = 0, next = RENDER_WALKS_FIRST; i < RENDER_WALKS && status == SATIN_OK;
         i = next, next = 2 * i) {
        struct fill_site *site = walks->site + i;
        size_t count = 0;
        for (size_t k = i; k < next; k++)
            if (walks->found[k]) site[count++] = walks->site[k];
        sites.site = site;
        sites.count = count;
        for (enum cache_kind kind = CACHE_IRRADIANCE; kind < CACHE_KINDS && status == SATIN_OK;
             kind++) {
            sites.a = options[kind].a;
            status = fill_records(fill, kind, &sites);
        }
    }
    return status;
}

static satin_status make_bounce(struct render *r, int index, struct walks *walks) {
    struct render_bounce *bounce = &r->second_pass.bounces[index - 1];
    bounce->options = bounce_options(&r->options, index);
    bounce->gather = r->second_pass.gather;  // reads the records of the next bounce
    bounce->gather.options = &bounce->options;
    bounce->cache = cache_new(&r->scene, &bounce->options, r->second_pass.tables.order);
    struct fill *fill = bounce->cache ? fill_new(bounce->cache, &bounce->gather, r->pool) : NULL;
    if (!fill) return SATIN_ERROR_MEMORY;
    render_memory_limit_cache(r, bounce->cache, r->second_pass.bounce_count + 1);
    bounce->shade = (struct shade){
        .g = &bounce->gather,
        .camera = &r->scene.camera,
        .records = cache_reader_make(bounce->cache, &r->second_pass.tables, &bounce->options)};
    scene_film_filter_make(&r->scene.film, &bounce->shade.filter);
    walks->shade = &bounce->shade;
    walks->bounce = index;
    satin_status status = make_walk_records(r, fill, walks);
    fill_free(fill);
    r->second_pass.gather.next = (struct gather_records){&bounce->shade.records, &bounce->gather};
    return status;
}

// The number of bounces that paths can have: the shortest path that uses a record of bounce 1 has
// two segments after it, to the light.
static int bounces_wanted(const satin_options *o) {
    if (o->first_pass != SATIN_FIRST_RECURSIVE) return 0;
    const int longest = o->max_depth - photon_hit_depth(o) - 1;
    return o->max_depth >= 0 && longest < o->recursive_bounces ? longest : o->recursive_bounces;
}

satin_status render_recursive_bounces(struct render *r) {
    const int count = bounces_wanted(&r->options);
    if (count <= 0) return SATIN_OK;
    render_stage_begin(r, STAGE_BOUNCES, 0.0);
    struct walks walks = {.image = &r->options};
    walks.site = array_new(RENDER_WALKS, sizeof *walks.site);
    walks.found = array_new(RENDER_WALKS, sizeof *walks.found);
    r->second_pass.bounces = calloc((size_t)count, sizeof *r->second_pass.bounces);
    satin_status status = SATIN_ERROR_MEMORY;
    if (walks.site && walks.found && r->second_pass.bounces) status = SATIN_OK;
    r->second_pass.bounce_count = r->second_pass.bounces ? count : 0;
    const double start = render_elapsed(r);
    for (int i = count; i > 0 && status == SATIN_OK; i--) {
        double done = (double)(count - i) / count;
        render_stage_range(r, done, 1.0 / count);
        render_limit_bounces(r, start, done + 1.0 / count);
        status = render_limit_end(r, make_bounce(r, i, &walks));
    }
    size_t records = 0;
    for (int i = 0; i < r->second_pass.bounce_count && r->second_pass.bounces[i].cache; i++)
        records += cache_count_all(r->second_pass.bounces[i].cache);
    stats_set(&r->stats, "records.bounces", (double)records);
    free(walks.site);
    free(walks.found);
    return status;
}

void render_recursive_bounces_free(struct render *r) {
    for (int i = 0; i < r->second_pass.bounce_count; i++)
        cache_free(r->second_pass.bounces[i].cache);
    free(r->second_pass.bounces);
}
