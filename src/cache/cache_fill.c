// SPDX-License-Identifier: Apache-2.0
// Filling the caches. Sites are taken in their order; a batch holds sites that no record covers and
// that lie apart; it is gathered on all threads against the frozen cache and inserted in order. So
// the records depend on the sites alone, not on the threads.
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "cache/cache_records.h"

enum {
    ATTEMPTS = 3,  // at a record that is not finite; then its site has none
    BATCH = 128,   // fixed: the records depend on it; large enough to keep 32 threads busy
    WINDOW = 1024  // sites that are judged together before some of them are chosen
};

// One record in the making.
struct job {
    const struct cache_site *site;
    struct gather_irradiance irradiance;
    struct gather_radiance radiance;
    struct cache_residual residual;
    struct gather_around around;
    int refused;  // attempts that were
    bool valid;   // the last one
};

struct batch {
    struct cache *cache;
    const struct cache_fill *fill;
    enum cache_kind kind;
    struct job job[BATCH];
    int count;
    float *coefficients;  // of radiance jobs: 10 * order^2 each
    const struct cache_site **window;
    bool covered[WINDOW];  // of the sites from `window` on
};

// A record that hangs on a few of its rays, as where one of them has met something small and
// bright, is gathered again by all the rays that the options say; what both have found counts by
// their rays. Of calm records the deviation is below .1 to .2 at 50 rays.
static const float UNSURE = 0.4f;

static rgb mix(rgb a, rgb b, float t) { return rgb_add(rgb_scale(a, 1.0f - t), rgb_scale(b, t)); }

static void gather_more(const struct batch *b, struct job *job, struct gather_site site,
                        struct gather_scratch *scratch, bool bends) {
    const struct cache *c = b->cache;
    struct gather_irradiance more, *first = &job->irradiance;
    site.stream = rng_mix(site.stream ^ 0x9e3779b97f4a7c15ull);
    const struct gather_hemisphere hemisphere =
        gather_hemisphere_trace(c->g, c->irradiance_whole, &site, scratch);
    gather_hemisphere_irradiance(c->g, &hemisphere, &more);
    gather_around_make(&hemisphere, bends, &job->around);
    const float t = (float)more.rays / (float)(more.rays + first->rays);
    first->E = mix(first->E, more.E, t);
    for (int k = 0; k < 3; k++) {
        first->grad_t[k] = v3_mad(v3_mul(first->grad_t[k], 1.0f - t), t, more.grad_t[k]);
        first->grad_r[k] = v3_mad(v3_mul(first->grad_r[k], 1.0f - t), t, more.grad_r[k]);
    }
    first->rays += more.rays;
}

// What the harmonics leave out of what the eye sees at the site.
static struct cache_residual residual_of(const struct batch *b, const struct job *job,
                                         const struct gather_hemisphere *hemisphere) {
    const struct cache_site *s = job->site;
    if (!s->view.table || !s->view.name) return (struct cache_residual){.name = 0};
    const rgb whole =
        gather_hemisphere_reflected(hemisphere, &s->view.brdf, s->view.wo, BRDF_GLOSSY);
    return cache_residual_make(&job->radiance, b->cache->order, &s->frame, &s->view, whole);
}

// One attempt at a record; false if it is not finite or out of range.
static bool gather_record(const struct batch *b, struct job *job, uint64_t stream,
                          struct gather_scratch *scratch) {
    const struct cache *c = b->cache;
    const struct cache_site *s = job->site;
    const struct gather_site site = {s->p, s->ng, s->frame, stream};
    const bool irradiance = b->kind == CACHE_IRRADIANCE;
    const bool bends = c->g->options->irradiance_radius == SATIN_RADIUS_HESSIAN;
    const float a = irradiance ? b->fill->a_irradiance : b->fill->a_radiance;
    const struct gather_layout *layout = cache_rays_layout(c, b->kind, s, a * b->fill->widest);
    const struct gather_hemisphere hemisphere =
        gather_hemisphere_trace(c->g, layout, &site, scratch);
    gather_around_make(&hemisphere, bends, &job->around);
    if (irradiance) {
        gather_hemisphere_irradiance(c->g, &hemisphere, &job->irradiance);
        if (job->around.deviation > UNSURE) gather_more(b, job, site, scratch, bends);
        return cache_valid_irradiance(&job->irradiance, &job->around);
    }
    gather_hemisphere_radiance(c->g, &hemisphere, &job->radiance);
    job->residual = residual_of(b, job, &hemisphere);
    return cache_valid_radiance(&job->radiance, c->order, &job->around) &&
           rgb_finite(job->residual.L);
}

// Other random numbers for each further attempt.
static void gather_jobs(void *ctx, size_t begin, size_t end, int worker) {
    struct batch *b = ctx;
    for (size_t i = begin; i < end; i++) {
        struct job *job = &b->job[i];
        uint64_t stream = job->site->stream;
        for (int attempt = 0; attempt < ATTEMPTS && !job->valid; attempt++) {
            job->valid = gather_record(b, job, stream, b->cache->scratch[worker]);
            if (!job->valid) job->refused++;
            stream = rng_mix(stream + 0x9e3779b97f4a7c15ull);
        }
    }
}

// Of a new record among ones that were adapted: 1.4 times that of the nearest one [K05 6.3.2].
static float first_scale(const struct cache_tree *tree, const struct cache_site *s, float reach) {
    static const float GROWTH = 1.4f;
    int64_t nearest = cache_tree_nearest(tree, s->p, s->frame.n, reach);
    return nearest < 0 ? 1.0f : fminf(1.0f, GROWTH * tree->head[nearest].scale);
}

// Puts a record's area into the tree; its value must stand at the next index.
static bool insert_head(struct cache_tree *tree, const struct job *job, struct cache_extent x,
                        float a, const struct cache_fill *fill) {
    const struct cache_site *s = job->site;
    const float reach = a * fill->widest * x.R;
    float ratio = x.R / x.across;
    float clear;
    const uint32_t walls = cache_leak_walls(&job->around, reach, &clear);
    struct cache_head head = {
        .p = s->p,
        .R = x.R,
        .n = s->frame.n,
        .reach = reach,
        .squeeze = v3_mul(x.axis, sqrtf(fmaxf(ratio * ratio - 1.0f, 0.0f))),
        .scale = fill->adapted ? first_scale(tree, s, reach) : 1.0f,
        .u = s->frame.u,
        .walls = walls,
        .clear = clear,
    };
    return cache_tree_insert(tree, &head);
}

static bool insert_irradiance(struct batch *b, struct job *job) {
    struct cache *c = b->cache;
    struct cache_tree *tree = &c->irradiance_tree;
    const struct cache_site *s = job->site;
    if (!array_reserve((void **)&c->irradiance, &c->irradiance_capacity, tree->head_count + 1,
                       sizeof *c->irradiance))
        return false;
    const satin_options *o = c->g->options;
    struct cache_extent x = cache_extent_irradiance(c, s, &job->around, &job->irradiance);
    if (o->irradiance_neighbours) {
        x.R = cache_clamp_neighbours(tree, s->p, s->frame.n, x.R);
        x.R = fmaxf(x.R, cache_least_radius(c, CACHE_IRRADIANCE, s->pixel));
        x.across = fminf(x.across, x.R);
    }
    c->irradiance[tree->head_count] =
        (struct cache_irradiance_record){job->irradiance, job->around.deviation, x.room};
    c->rays += job->irradiance.rays;
    return insert_head(tree, job, x, o->irradiance_a, b->fill);
}

// Into the layout of products, see cache_records.h.
static void interleave(const struct gather_radiance *from, int n2, float *value) {
    const float *part[3] = {from->lambda, from->dx, from->dy};
    for (int k = 0; k < n2; k++)
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < 3; c++) value[k * CACHE_LANES + 4 * i + c] = part[i][c * n2 + k];
    for (int k = 0; k < n2; k++) value[k * CACHE_LANES + 3] = from->noise[k];
}

static bool insert_radiance(struct batch *b, struct job *job) {
    struct cache *c = b->cache;
    struct cache_tree *tree = &c->radiance_tree;
    const struct cache_site *s = job->site;
    const int n2 = c->order * c->order;
    float *value = arena_array(&c->radiance_arena, (size_t)(n2 * CACHE_LANES), sizeof *value);
    if (!value || !array_reserve((void **)&c->radiance, &c->radiance_capacity, tree->head_count + 1,
                                 sizeof *c->radiance))
        return false;
    const satin_options *o = c->g->options;
    struct cache_extent x = cache_extent_radiance(c, s, &job->around, &job->radiance);
    if (o->radiance_neighbours) {
        x.R = cache_clamp_neighbours(tree, s->p, s->frame.n, x.R);
        x.R = fmaxf(x.R, cache_least_radius(c, CACHE_RADIANCE, s->pixel));
        x.across = fminf(x.across, x.R);
    }
    interleave(&job->radiance, n2, value);
    c->radiance[tree->head_count] =
        (struct cache_radiance_record){s->frame, value, x.room, job->radiance.rays, job->residual};
    c->rays += job->radiance.rays;
    return insert_head(tree, job, x, o->radiance_a, b->fill);
}

// False without memory. A record that stayed invalid is left out: its site is sampled instead.
static bool insert_job(struct batch *b, struct job *job) {
    b->cache->refused += (uint64_t)job->refused;
    assert(job->refused == 0);
    if (!job->valid) return true;
    return b->kind == CACHE_IRRADIANCE ? insert_irradiance(b, job) : insert_radiance(b, job);
}

static void start_job(struct batch *b, const struct cache_site *site) {
    const size_t n2 = (size_t)(b->cache->order * b->cache->order), n = 3 * n2;
    float *block = b->coefficients + 10 * n2 * (size_t)b->count;
    struct job *job = &b->job[b->count++];
    *job = (struct job){.site = site};
    job->radiance = (struct gather_radiance){
        .lambda = block, .dx = block + n, .dy = block + 2 * n, .noise = block + 3 * n};
}

// Whether a site lies apart from all members of the batch.
static bool apart(const struct batch *b, const struct cache_site *site) {
    float least = b->fill->spacing * site->pixel;
    for (int i = 0; i < b->count; i++) {
        const struct cache_site *other = b->job[i].site;
        if (v3_dist2(other->p, site->p) < least * least &&
            v3_dot(other->frame.n, site->frame.n) > 0.5f)
            return false;
    }
    return true;
}

static void judge_sites(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct batch *b = ctx;
    const bool irradiance = b->kind == CACHE_IRRADIANCE;
    const struct cache_tree *tree =
        irradiance ? &b->cache->irradiance_tree : &b->cache->radiance_tree;
    const float a = irradiance ? b->fill->a_irradiance : b->fill->a_radiance;
    struct cache_near near[CACHE_NEAR_MAX];
    for (size_t i = begin; i < end; i++)
        b->covered[i] =
            cache_find(b->cache, tree, b->window[i]->p, b->window[i]->frame.n, a, near) > 0;
}

// Takes the next members from waiting[*head .. count). Covered sites are dropped; those that lie
// too close to a member wait at the front of what remains. False if cancelled.
static bool choose(struct batch *b, const struct cache_site **waiting, size_t *head, size_t count) {
    size_t start = *head, kept = 0, i = start;
    b->count = 0;
    while (i < count && b->count < BATCH) {
        size_t n = count - i < WINDOW ? count - i : WINDOW;
        b->window = waiting + i;
        if (!parallel_for(b->cache->pool, n, 64, judge_sites, b)) return false;
        for (size_t j = 0; j < n && b->count < BATCH; j++, i++) {
            const struct cache_site *site = waiting[i];
            if (b->covered[j]) continue;
            if (!apart(b, site))
                waiting[start + kept++] = site;
            else
                start_job(b, site);
        }
    }
    *head = i - kept;
    memmove(&waiting[*head], &waiting[start], kept * sizeof *waiting);
    return true;
}

static satin_status fill_kind(struct batch *b, const struct cache_site **waiting) {
    size_t count = 0, head = 0;
    for (size_t i = 0; i < b->fill->count; i++)
        if (b->fill->site[i].wants & b->kind) waiting[count++] = &b->fill->site[i];
    while (head < count) {
        if (!choose(b, waiting, &head, count) ||
            !parallel_for(b->cache->pool, (size_t)b->count, 1, gather_jobs, b))
            return SATIN_CANCELLED;
        for (int i = 0; i < b->count; i++)
            if (!insert_job(b, &b->job[i])) return SATIN_ERROR_MEMORY;
    }
    return SATIN_OK;
}

satin_status cache_fill(struct cache *cache, const struct cache_fill *fill) {
    satin_status status = SATIN_ERROR_MEMORY;
    const struct cache_site **waiting = array_new(fill->count, sizeof *waiting);
    struct batch *b = calloc(1, sizeof *b);
    if (b)
        b->coefficients =
            array_new((size_t)(BATCH * 10 * cache->order * cache->order), sizeof(float));
    if (waiting && b && b->coefficients) {
        b->cache = cache;
        b->fill = fill;
        b->kind = CACHE_IRRADIANCE;
        status = fill_kind(b, waiting);
        b->kind = CACHE_RADIANCE;
        if (status == SATIN_OK && cache->order) status = fill_kind(b, waiting);
    }
    free(waiting);
    if (b) free(b->coefficients);
    free(b);
    return status;
}
