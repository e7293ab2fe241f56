// SPDX-License-Identifier: Apache-2.0
// Fills the cache with one kind of records. Sites are processed in their order. A batch consists of
// sites that no record covers and that are far apart; it is gathered on all threads while the cache
// does not change, and inserted in order. So the records depend on the sites alone, not on the
// threads.
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "fill/fill_record.h"

enum {
    ATTEMPTS = 3,        // at a record that is not finite; after them its site has none
    TESTED_MOST = 1024,  // sites that are tested together before batch members are selected
    BATCH_SITES = 128,   // these three are explained at batch_size
    BATCH_LEAST = 128,
    BATCH_MOST = 1024
};

// What gathering has found, and inserting the record reads.
struct gathered {
    struct cache_irradiance_value irradiance;
    uint32_t radiance_rays;
    struct cache_residual residual;
    struct gather_surroundings around;
    float most;                 // R of a radiance record is at most this
    struct fill_extent extent;  // before it is limited by other records
    int refused;                // number of attempts that were not valid
    bool valid;                 // whether the last attempt was valid
};

// A record that is being made.
struct batch_member {
    const struct fill_site *site;
    struct gather_radiance radiance;
    struct gathered found;
    float *value;  // of a radiance record, in the cache's arena
};

struct batch;

// Functions for one kind of records.
struct record_functions {
    // Adds rays to a record that depends too much on a few of them, if it is of such a kind.
    void (*add_rays)(const struct batch *batch, struct batch_member *member,
                     const struct gather_site *site, const struct gather_worker *worker);
    // Computes the record and its surroundings from a gathered hemisphere.
    void (*find)(const struct batch *batch, struct batch_member *member,
                 const struct gather_hemisphere *hemisphere);
    // Sets the extent of the record that was found. False if the record is not valid.
    bool (*make)(const struct batch *batch, struct batch_member *member);
    bool (*insert)(struct batch *batch,
                   struct batch_member *member);  // false if there is no memory
};

struct batch {
    struct fill *fill;
    struct cache *cache;  // of it
    const struct fill_sites *sites;
    enum cache_kind kind;
    struct cache_store *store;               // of that kind
    const struct record_functions *records;  // functions of that kind
    struct batch_member *member;
    int count, size;      // number of members, at most `size`
    float *coefficients;  // of radiance members: 10 * order^2 for each
    // Sites from `next` to `last` are not covered, or not tested yet.
    const struct fill_site **waiting;
    size_t next, last;
    const struct fill_site **tested;  // the sites that are tested
    bool covered[TESTED_MOST];        // results of the tests
};

// If a few of its rays make up most of an irradiance record, as when one of them has hit a small
// bright surface, it is gathered again with all the rays of the options, and both results are
// averaged by their numbers of rays. This is the deviation above which that is done: other records
// have less than .1 to .2 at 50 rays.
static const float UNSURE = 0.4f;

// ---- Choosing the sites of a batch --------------------------------------------------------------

// The number of members of a batch. Large batches use many threads, but members are chosen without
// each other's records, so more records are made. The size is one site in BATCH_SITES, independent
// of the threads, as the records depend on it. Compared to batches of BATCH_LEAST it made .5 to 3 %
// more records at 200x200 (draft and preview of cornell-glossy, indirect-room and vase, three seeds
// each), whose images had .96 to 1.01 times the relative squared error, and 11 % more at 400x400
// (draft, indirect-room). 512 at all levels made up to 30 % more. One thread tests all pairs of
// members, which limits their number to BATCH_MOST: with it, this takes .1 % of the time of 64
// cores (indirect-room, production, 400x400, by the model of bench/scaling.py), and grows as its
// square.
static int batch_size(size_t sites) {
    const size_t size = sites / BATCH_SITES;
    if (size < BATCH_LEAST) return BATCH_LEAST;
    return size > BATCH_MOST ? BATCH_MOST : (int)size;
}

static void test_coverage(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct batch *b = ctx;
    for (size_t i = begin; i < end; i++)
        b->covered[i] = fill_is_covered(b->fill, b->kind, b->tested[i], b->sites->a);
}

// Whether a site is far enough from all members of the batch.
static bool lies_apart(const struct batch *b, const struct fill_site *site) {
    const float least = b->sites->spacing * site->pixel;
    for (int i = 0; i < b->count; i++) {
        const struct fill_site *other = b->member[i].site;
        if (v3_dist2(other->p, site->p) < least * least &&
            v3_dot(other->frame.n, site->frame.n) > 0.5f)
            return false;
    }
    return true;
}

static void add_member(struct batch *b, const struct fill_site *site) {
    const size_t n2 = (size_t)(b->store->order * b->store->order), n = 3 * n2;
    float *block = b->coefficients + 10 * n2 * (size_t)b->count;
    struct batch_member *member = &b->member[b->count++];
    *member = (struct batch_member){.site = site};
    member->radiance = (struct gather_radiance){
        .lambda = block, .dx = block + n, .dy = block + 2 * n, .noise = block + 3 * n};
}

// Selects the next members from the waiting sites. Covered sites are dropped; those too close to a
// member are moved to the front of the remaining ones. False if cancelled.
static bool choose_batch(struct batch *b) {
    const size_t start = b->next;
    size_t kept = 0, i = start;
    b->count = 0;
    while (i < b->last && b->count < b->size) {
        const size_t n = b->last - i < TESTED_MOST ? b->last - i : TESTED_MOST;
        b->tested = b->waiting + i;
        if (!parallel_for(b->fill->pool, n, 64, test_coverage, b)) return false;
        for (size_t j = 0; j < n && b->count < b->size; j++, i++) {
            const struct fill_site *site = b->waiting[i];
            if (b->covered[j]) continue;
            if (!lies_apart(b, site))
                b->waiting[start + kept++] = site;
            else
                add_member(b, site);
        }
    }
    b->next = i - kept;
    memmove(&b->waiting[b->next], &b->waiting[start], kept * sizeof *b->waiting);
    return true;
}

// ---- Gathering ----------------------------------------------------------------------------------

static rgb mix(rgb a, rgb b, float t) { return rgb_add(rgb_scale(a, 1.0f - t), rgb_scale(b, t)); }

// The mean of two values of one site, by their numbers of rays.
static struct cache_irradiance_value average_values(const struct cache_irradiance_value *a,
                                                    const struct cache_irradiance_value *b) {
    struct cache_irradiance_value mean = {.rays = a->rays + b->rays};
    const float t = (float)b->rays / (float)mean.rays;
    mean.E = mix(a->E, b->E, t);
    for (int k = 0; k < 3; k++) {
        mean.grad_t[k] = v3_mad(v3_mul(a->grad_t[k], 1.0f - t), t, b->grad_t[k]);
        mean.grad_r[k] = v3_mad(v3_mul(a->grad_r[k], 1.0f - t), t, b->grad_r[k]);
    }
    return mean;
}

static void find_surroundings(const struct batch *b, struct batch_member *member,
                              const struct gather_hemisphere *hemisphere) {
    const bool hessian = b->store->options.radius == SATIN_RADIUS_HESSIAN;
    gather_surroundings_make(hemisphere, hessian, &member->found.around);
}

// The light that the site reflects to the eye and that the harmonics leave out.
static struct cache_residual find_residual(const struct batch *b, const struct batch_member *member,
                                           const struct gather_hemisphere *hemisphere) {
    const struct fill_site *s = member->site;
    if (!s->glossy.table || !s->glossy.lobe_number)
        return (struct cache_residual){.lobe_number = 0};
    const rgb whole =
        gather_hemisphere_reflected(hemisphere, &s->glossy.brdf, s->glossy.wo, BRDF_GLOSSY);
    return fill_residual(&member->radiance, b->store->order, &s->frame, &s->glossy, whole);
}

static void find_irradiance(const struct batch *b, struct batch_member *member,
                            const struct gather_hemisphere *hemisphere) {
    find_surroundings(b, member, hemisphere);
    gather_hemisphere_irradiance(hemisphere, b->store->options.gradients,
                                 &member->found.irradiance);
}

static bool make_irradiance(const struct batch *b, struct batch_member *member) {
    if (!fill_valid_irradiance(&member->found.irradiance, &member->found.around)) return false;
    member->found.extent = fill_extent_irradiance(b->fill, member->site, &member->found.around,
                                                  &member->found.irradiance);
    return true;
}

// Copies coefficients to the layout of cache_radiance_record.
static void interleave(const struct gather_radiance *from, int n2, float *value) {
    const float *array[3] = {from->lambda, from->dx, from->dy};
    for (int k = 0; k < n2; k++)
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < 3; c++) value[k * CACHE_LANES + 4 * i + c] = array[i][c * n2 + k];
    for (int k = 0; k < n2; k++) value[k * CACHE_LANES + 3] = from->noise[k];
}

// The limit of R by the curvature of the light that the site reflects to the eye.
static float curvature_limit(const struct batch *b, const struct batch_member *member,
                             const struct gather_hemisphere *hemisphere) {
    const struct fill_site *s = member->site;
    const struct cache_options *o = &b->store->options;
    if (!s->glossy.table || !o->curvature_clamp) return INFINITY;
    const float most = fminf(b->cache->scene->radius, o->max_pixels * s->pixel / o->a);
    return fill_curvature_clamp_radius(hemisphere, &s->glossy, o->a,
                                       fminf(member->found.around.harmonic, most),
                                       fill_least_radius(b->fill, b->kind, s->pixel));
}

static void find_radiance(const struct batch *b, struct batch_member *member,
                          const struct gather_hemisphere *hemisphere) {
    find_surroundings(b, member, hemisphere);
    gather_hemisphere_radiance(hemisphere, b->store->options.gradients, &member->radiance);
    member->found.radiance_rays = member->radiance.rays;
    member->found.residual = find_residual(b, member, hemisphere);
    member->found.most = curvature_limit(b, member, hemisphere);
}

static bool make_radiance(const struct batch *b, struct batch_member *member) {
    if (!fill_valid_radiance(&member->radiance, b->store->order, &member->found.around) ||
        !rgb_finite(member->found.residual.L))
        return false;
    member->found.extent = fill_extent_radiance(b->fill, member->site, &member->found.around,
                                                member->found.most, &member->radiance);
    interleave(&member->radiance, b->store->order * b->store->order, member->value);
    return true;
}

// Allocates the values of a batch's records. False if there is no memory. Values of records that
// stay invalid are not used.
static bool allocate_values(struct batch *b) {
    if (!b->store->order) return true;
    for (struct batch_member *member = b->member; member < b->member + b->count; member++) {
        member->value = cache_value_new(b->cache);
        if (!member->value) return false;
    }
    return true;
}

// If a few of its rays make up most of an irradiance record, gathers it again, by all the rays of
// the options, and averages both values.
static void add_irradiance_rays(const struct batch *b, struct batch_member *member,
                                const struct gather_site *site, const struct gather_worker *w) {
    if (!(member->found.around.deviation > UNSURE)) return;
    const struct cache_irradiance_value first = member->found.irradiance;
    struct gather_site again = *site;
    again.stream = rng_mix(site->stream ^ RNG_GOLDEN);
    gather_hemisphere_trace(b->fill->g, b->fill->side[b->kind].whole, &again, w->scratch,
                            w->hemisphere);
    find_irradiance(b, member, w->hemisphere);
    member->found.irradiance = average_values(&first, &member->found.irradiance);
}

// Radiance records have enough rays.
static void keep_rays(const struct batch *b, struct batch_member *member,
                      const struct gather_site *site, const struct gather_worker *w) {
    (void)b, (void)member, (void)site, (void)w;
}

// Gathers the members [begin, end) of a batch. A record that is not finite or out of range is
// gathered again with other random numbers.
static void make_records(void *ctx, size_t begin, size_t end, int worker) {
    struct batch *b = ctx;
    const struct fill *f = b->fill;
    const struct gather_worker *w = &f->worker[worker];
    for (struct batch_member *member = b->member + begin; member < b->member + end; member++) {
        const struct fill_site *s = member->site;
        const struct gather_layout *layout =
            fill_rays_layout(f, b->kind, s, b->sites->a * b->sites->factor_max);
        struct gather_site site = {s->p, s->ng, s->frame, s->stream, true, NULL, s->glossy.wo};
        if (fill_rays_glossy(f, b->kind, s)) site.glossy = &s->glossy.brdf;
        for (int attempt = 0; attempt < ATTEMPTS && !member->found.valid; attempt++) {
            gather_hemisphere_trace(f->g, layout, &site, w->scratch, w->hemisphere);
            b->records->find(b, member, w->hemisphere);
            b->records->add_rays(b, member, &site, w);
            member->found.valid = b->records->make(b, member);
            if (!member->found.valid) member->found.refused++;
            site.stream = rng_mix(site.stream + RNG_GOLDEN);
        }
    }
}

// ---- Results of a member as bytes ---------------------------------------------------------------

static size_t value_bytes(const struct batch *b) {
    return (size_t)(b->store->order * b->store->order * CACHE_LANES) * sizeof(float);
}

// The member's pointers are set by choose_batch.
static void pack_members(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct batch *b = ctx;
    for (const struct batch_member *member = b->member + begin; member < b->member + end;
         member++) {
        bytes_put(out, &member->found, sizeof member->found);
        if (member->value) bytes_put(out, member->value, value_bytes(b));
    }
}

static bool unpack_members(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct batch *b = ctx;
    for (struct batch_member *member = b->member + begin; member < b->member + end; member++) {
        bytes_get(in, &member->found, sizeof member->found);
        if (member->value) bytes_get(in, member->value, value_bytes(b));
    }
    return true;
}

static const struct parallel_results members_results = {
    .pack = pack_members, .unpack = unpack_members, .journaled = true};

// ---- Inserting ----------------------------------------------------------------------------------

// The scale of a new record among adapted ones: 1.4 times that of the nearest one [K05 6.3.2].
static float first_scale(const struct cache_tree *tree, const struct fill_site *s, float radius) {
    static const float GROWTH = 1.4f;
    int64_t nearest = cache_tree_nearest(tree, s->p, s->frame.n, radius);
    return nearest < 0 ? 1.0f : fminf(1.0f, GROWTH * tree->head[nearest].scale);
}

// Limits a new record and its neighbours by each other, if the options include that.
static void clamp_extent(const struct batch *b, const struct fill_site *s, struct fill_extent *x) {
    if (!b->store->options.neighbour_clamp) return;
    x->R = fill_neighbour_clamp(&b->store->tree, s->p, s->frame.n, x->R);
    x->R = fmaxf(x->R, fill_least_radius(b->fill, b->kind, s->pixel));
    x->across = fminf(x->across, x->R);
}

// The head of a new record.
static struct cache_head make_head(const struct batch *b, const struct batch_member *member,
                                   const struct fill_extent *x) {
    const struct fill_site *s = member->site;
    const float radius = b->store->options.a * b->sites->factor_max * x->R;
    float ratio = x->R / x->across;
    float clear;
    const uint32_t near = fill_leak_sectors(&member->found.around, radius, &clear);
    return (struct cache_head){
        .p = s->p,
        .R = x->R,
        .n = s->frame.n,
        .search_radius = radius,
        .anisotropy = v3_mul(x->axis, sqrtf(fmaxf(ratio * ratio - 1.0f, 0.0f))),
        .scale = b->sites->adapted ? first_scale(&b->store->tree, s, radius) : 1.0f,
        .u = s->frame.u,
        .near_sectors = near,
        .clear = clear,
    };
}

static bool insert_irradiance(struct batch *b, struct batch_member *member) {
    struct fill_extent x = member->found.extent;
    clamp_extent(b, member->site, &x);
    const struct cache_head head = make_head(b, member, &x);
    const struct cache_irradiance_record record = {member->found.irradiance,
                                                   member->found.around.deviation, x.radius_ratio};
    return cache_insert_irradiance(b->cache, &head, &record);
}

static bool insert_radiance(struct batch *b, struct batch_member *member) {
    struct fill_extent x = member->found.extent;
    clamp_extent(b, member->site, &x);
    const struct cache_head head = make_head(b, member, &x);
    const struct cache_radiance_record record = {member->site->frame, member->value, x.radius_ratio,
                                                 member->found.radiance_rays,
                                                 member->found.residual};
    return cache_insert_radiance(b->cache, &head, &record);
}

// ---- All batches --------------------------------------------------------------------------------

static const struct record_functions functions[CACHE_KINDS] = {
    [CACHE_IRRADIANCE] = {add_irradiance_rays, find_irradiance, make_irradiance, insert_irradiance},
    [CACHE_RADIANCE] = {keep_rays, find_radiance, make_radiance, insert_radiance},
};

satin_status fill_records(struct fill *fill, enum cache_kind kind, const struct fill_sites *sites) {
    if (!fill->cache->store[kind].filled) return SATIN_OK;
    satin_status status = SATIN_ERROR_MEMORY;
    struct batch *b = calloc(1, sizeof *b);
    if (!b) return status;
    const char *part = parallel_begin_part(fill->pool, "insert");
    b->fill = fill;
    b->cache = fill->cache;
    b->sites = sites;
    b->kind = kind;
    b->store = &fill->cache->store[kind];
    b->records = &functions[kind];
    b->waiting = array_new(sites->count, sizeof *b->waiting);
    b->size = batch_size(sites->count);
    b->member = array_new((size_t)b->size, sizeof *b->member);
    b->coefficients =
        array_new((size_t)(b->size * 10 * b->store->order * b->store->order), sizeof(float));
    if (b->waiting && b->member && b->coefficients) status = SATIN_OK;
    for (size_t i = 0; i < sites->count && status == SATIN_OK; i++)
        if (sites->site[i].kinds >> kind & 1u) b->waiting[b->last++] = &sites->site[i];
    while (b->next < b->last && status == SATIN_OK && !cache_full(fill->cache)) {
        parallel_begin_part(fill->pool, "choose");
        bool whole = choose_batch(b);
        parallel_begin_part(fill->pool, "gather");
        if (whole && !allocate_values(b)) status = SATIN_ERROR_MEMORY;
        if (status != SATIN_OK) break;
        whole = whole && parallel_for_results(fill->pool, (size_t)b->count, 1, make_records, b,
                                              &members_results);
        parallel_begin_part(fill->pool, "insert");
        if (!whole) status = SATIN_CANCELLED;
        for (struct batch_member *member = b->member;
             member < b->member + b->count && status == SATIN_OK; member++) {
            fill->refused += (uint64_t)member->found.refused;
            assert(member->found.refused == 0);
            // A record that stayed invalid is left out, and gathering replaces it at its site.
            if (member->found.valid && !b->records->insert(b, member)) status = SATIN_ERROR_MEMORY;
        }
    }
    parallel_begin_part(fill->pool, part);
    free(b->waiting);
    free(b->coefficients);
    free(b->member);
    free(b);
    return status;
}
