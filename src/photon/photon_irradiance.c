// SPDX-License-Identifier: Apache-2.0
// Irradiance precomputed at every 8th photon [Christensen 1999, who takes every 4th: here that
// costs more time than it saves error], so that a gather hit costs one nearest-neighbour query. The
// query is in six dimensions, position and scaled normal: the nearest photon of the right
// orientation is then the nearest point of the index. The scale is twice the median radius of the
// density estimates, about three times the spacing of the entries. So photons on a wall at right
// angles are farther away than any neighbour on the same wall, while on curved surfaces neighbours
// stay near as long as the normal changes little within the disc of an estimate.
//
// The photon of an entry counts in its own estimate, which makes estimates too bright by 1 / (k -
// 1) on average over photons. But lookups are not uniform over photons: an entry in a gap is read
// from a larger area than one in a cluster, and its estimate is lower. Over the area the two
// effects cancel (measured in a furnace: within .3 % for k of 20 to 200, 4 % too bright at 10).
//
// Gather rays continue where the estimate of an entry is too wide. The radius of the estimate's own
// disc cannot decide that: it is smaller for estimates that came out brighter, so that bright ones
// would be read and dark ones would not. A room lit through a door was .7 % too bright with 100,000
// photons. Instead, lookups return the radius of an equal number of photons around the disc.
#include "photon/photon_cover.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_entry.h"
#include "photon/photon_own_area.h"

enum {
    IRRADIANCE_CHUNK = 256,           // entries of a chunk
    TOGETHER = PHOTON_CLEARING_DISCS  // of these, entries that are searched and evaluated together
};
// The nearest of randomly distributed entries is farther than the root of FADE / (pi density) at
// one in e^FADE positions. Where it is farther, no light arrived, and the entry's irradiance fades.
#define FADE 6.0f
struct precompute_loop {
    const struct photon_precompute *what;
    struct photon_irradiance *out;
    uint8_t *refused;  // by entry: whether its estimate is not finite
    atomic_bool failed;
};

static void precompute_one(struct precompute_loop *loop, size_t entry,
                           const struct photon_clearing *clearing, int *row, float *distance2) {
    const struct photon_precompute *what = loop->what;
    struct photon_entry_rows rows[2];
    struct photon_entry at = {.ring = loop->out->ring ? loop->out->ring[entry] : INFINITY};
    photon_entry_estimate(what, entry, clearing, row, distance2, rows, &at);
    loop->out->E[entry] = photon_disc_irradiance(&at.disc);
    if (loop->out->last) loop->out->last[entry] = photon_disc_last(&at.disc);
    loop->out->radius[entry] = at.disc.r;
    if (loop->out->ring) loop->out->ring[entry] = at.ring;
    what->map->whole_disc[entry] = !at.disc.corrected;
    loop->out->position.clear[entry] = photon_disc_clear(&at.disc);
}

// Refuses estimates that are not finite.
static void refuse_invalid(struct precompute_loop *loop, size_t entry) {
    struct photon_irradiance *r = loop->out;
    loop->refused[entry] = !rgb_finite(r->E[entry]) || !(r->radius[entry] >= 0.0f);
    if (!loop->refused[entry]) return;
    r->E[entry] = rgb_grey(0.0f);
    if (r->last) r->last[entry] = rgb_grey(0.0f);
    r->radius[entry] = INFINITY;
}

// The entries of light that ends, which has a stride of 1.
static void precompute_ending(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct precompute_loop *loop = ctx;
    struct photon_irradiance *r = loop->out;
    photon_cover_estimate(loop->what->map, begin, end, loop->what->kernel, r->E, r->bounces);
    for (size_t i = begin; i < end; i++) {
        r->radius[i] = sqrtf(loop->what->map->radius2[i]);
        refuse_invalid(loop, i);
    }
}

static void precompute_chunk(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct precompute_loop *loop = ctx;
    const struct photon_precompute *what = loop->what;
    const size_t k = (size_t)what->k * (loop->out->ring ? 2 : 1);
    int *row = malloc(TOGETHER * k * sizeof *row);
    float *distance2 = malloc(TOGETHER * k * sizeof *distance2);
    if (!row || !distance2) atomic_store(&loop->failed, true);
    for (size_t at = begin; at < end && !atomic_load(&loop->failed); at += TOGETHER) {
        size_t n = end - at < TOGETHER ? end - at : TOGETHER, middle = n / 2;
        float query[3 * TOGETHER];
        for (size_t i = 0; i < n; i++) {
            vec3 p = photon_position(what->map, (at + i) * what->stride);
            query[3 * i] = p.x;
            query[3 * i + 1] = p.y;
            query[3 * i + 2] = p.z;
        }
        photon_index_nearest(what->map->index, query, n, (int)k, photon_map_far2(what->map), row,
                             distance2);
        for (size_t i = 0; loop->out->ring && i < n; i++)
            loop->out->ring[at + i] = photon_ring_radius(row + i * k, distance2 + i * k, what->k);
        struct photon_clearing clearing =
            photon_entry_clearing(what, at + middle, row + middle * k, distance2 + middle * k);
        for (size_t i = 0; i < n; i++)
            precompute_one(loop, at + i, &clearing, row + i * k, distance2 + i * k);
        for (size_t i = 0; i < n; i++) refuse_invalid(loop, at + i);
    }
    free(row);
    free(distance2);
}

// The median radius of a sample of the entries.
static float median_radius(const struct photon_irradiance *irradiance) {
    enum { SAMPLE = 1023 };
    float sample[SAMPLE];
    size_t n = irradiance->count < SAMPLE ? irradiance->count : SAMPLE;
    for (size_t i = 0; i < n; i++) sample[i] = irradiance->radius[i * irradiance->count / n];
    qsort(sample, n, sizeof *sample, array_compare_floats);
    return sample[n / 2];
}

void photon_entry_position_set(struct photon_positions *positions, size_t i, vec3 p, vec3 n) {
    photon_entry_row_set(positions->row + 6 * i, p, n, positions->scale);
}

// The scale of normals in the rows, which is positive and finite, so that normals can be read from
// the rows. The median radius may be 0, if most photons are at a few points, or INFINITY, if they
// are fewer than an estimate needs.
static float normal_scale(const struct photon_irradiance *r, const struct satin_scene *scene) {
    const float scale = 2.0f * median_radius(r);
    return scale > 0.0f && isfinite(scale) ? scale : scene->radius;
}

// The squared distance of rows beyond which no entry of light that ends is used: the normal of an
// entry with the orientation of the query differs by less than the scale.
static float far_of(const struct photon_precompute *what, const struct photon_irradiance *r) {
    if (!r->ends) return INFINITY;
    return fmaxf(PHOTON_ENDS * r->fade2, 1.0f) * photon_map_far2(what->map) +
           sqrf(r->position.scale);
}

// Computes the rows of the index, once their scale is known.
static void set_rows(void *ctx, size_t begin, size_t end, int worker) {
    struct precompute_loop *loop = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct photon_map *map = loop->what->map;
        const size_t at = i * loop->what->stride;
        photon_entry_position_set(&loop->out->position, i, photon_position(map, at),
                                  photon_unpack(map->photon[at].n));
    }
}

// Builds the index of the rows. False if there is no memory or the pool was cancelled.
static bool index_rows(const struct photon_precompute *what, struct parallel *pool,
                       struct photon_irradiance *r) {
    struct precompute_loop loop = {.what = what, .out = r};
    parallel_begin_part(pool, "index");
    r->position.scale = normal_scale(r, what->scene);
    r->far2 = far_of(what, r);
    if (!parallel_for(pool, r->count, IRRADIANCE_CHUNK, set_rows, &loop)) return false;
    r->index = photon_index_new(r->position.row, r->count, 6, &what->map->morton, pool);
    if (!r->index) return false;
    return r->ends || photon_voxels_build(r, pool);  // light that ends is looked up seldom
}

// Computes all entries and counts those that are refused.
static satin_status precompute_entries(const struct photon_precompute *what, struct parallel *pool,
                                       struct photon_irradiance *r) {
    const struct photon_map *map = what->map;
    uint8_t *refused = array_new(r->count, 1);
    if (!refused) return SATIN_ERROR_MEMORY;
    struct precompute_loop loop = {.what = what, .out = r, .refused = refused};
    atomic_init(&loop.failed, false);
    const struct parallel_results entries = {
        .slot = {{map->whole_disc, 1},
                 {r->E, sizeof *r->E},
                 r->ends ? (struct parallel_slot){r->bounces, sizeof *r->bounces}
                         : (struct parallel_slot){r->last, sizeof *r->last},
                 {r->radius, sizeof *r->radius},
                 {r->ring, sizeof *r->ring},
                 {r->position.clear, sizeof *r->position.clear},
                 {refused, 1}},
        .journaled = true};
    satin_status status = SATIN_OK;
    if (!parallel_for_results(pool, r->count, IRRADIANCE_CHUNK,
                              r->ends ? precompute_ending : precompute_chunk, &loop, &entries))
        status = SATIN_CANCELLED;
    else if (atomic_load(&loop.failed))
        status = SATIN_ERROR_MEMORY;
    for (size_t i = 0; i < r->count; i++) r->refused += refused[i];
    free(refused);
    return status;
}

// Finds the discs of all photons and, for each, the least distance to a wall or an edge.
static satin_status find_own_discs(const struct photon_precompute *what, struct parallel *pool,
                                   float *clear) {
    satin_status status = photon_map_find_radii(what->map, what->k, pool);
    if (status == SATIN_OK)
        status =
            photon_own_areas_find(what->map, what->scene, what->kernel, what->area, pool, clear);
    return status == SATIN_OK ? photon_cover_build(what->map, pool) : status;
}

satin_status photon_irradiance_build(const struct photon_precompute *what, struct parallel *pool,
                                     struct log log, struct photon_irradiance *out) {
    struct photon_map *map = what->map;
    struct photon_irradiance r = {.count = (map->count + what->stride - 1) / what->stride};
    r.fade2 = FADE * (float)what->stride / (float)what->k;
    r.ends = what->ends;
    r.radius_max = map->radius_max;
    if (map->count == 0) {
        *out = r;
        return SATIN_OK;
    }
    satin_status status = SATIN_ERROR_MEMORY;
    map->stride = what->stride;
    map->whole_disc = array_new(r.count, 1);
    r.position.row = array_new_unset(6 * r.count, sizeof *r.position.row);
    r.E = array_new(r.count, sizeof *r.E);
    r.radius = array_new(r.count, sizeof *r.radius);
    if (map->limited && r.ends)
        r.bounces = array_new(r.count, sizeof *r.bounces);
    else if (map->limited)
        r.last = array_new(r.count, sizeof *r.last);
    if (!r.ends) r.ring = array_new(r.count, sizeof *r.ring);
    r.position.clear = array_new(r.count, sizeof *r.position.clear);
    if (map->whole_disc && r.position.row && r.E && r.radius && (r.ring || r.ends) &&
        r.position.clear && (r.last || r.bounces || !map->limited)) {
        status = r.ends ? find_own_discs(what, pool, r.position.clear) : SATIN_OK;
        if (status == SATIN_OK) status = precompute_entries(what, pool, &r);
    }
    if (status == SATIN_OK && !index_rows(what, pool, &r))
        status = parallel_stopped(pool) ? SATIN_CANCELLED : SATIN_ERROR_MEMORY;
    parallel_begin_part(pool, "smooth");
    if (status == SATIN_OK && what->smooth) status = photon_caustic_smooth(what, pool, &r);
    if (status == SATIN_ERROR_MEMORY) log_fail(log, status, "not enough memory for irradiance");
    if (status != SATIN_OK)
        photon_irradiance_free(&r);
    else
        *out = r;
    return status;
}

void photon_irradiance_free(struct photon_irradiance *irradiance) {
    photon_index_free(irradiance->index);
    photon_voxels_free(&irradiance->voxels);
    free(irradiance->position.row);
    free(irradiance->E);
    free(irradiance->radius);
    free(irradiance->ring);
    free(irradiance->last);
    free(irradiance->bounces);
    free(irradiance->position.clear);
    *irradiance = (struct photon_irradiance){0};
}

size_t photon_irradiance_bytes(const struct photon_irradiance *irradiance) {
    return irradiance->count * (6 * sizeof(float) + sizeof(rgb) + 2 * sizeof(float)) +
           (irradiance->ring ? irradiance->count * sizeof(float) : 0) +
           (irradiance->last ? irradiance->count * sizeof(rgb) : 0) +
           (irradiance->bounces ? irradiance->count : 0) + photon_index_bytes(irradiance->index) +
           photon_voxels_bytes(&irradiance->voxels);
}

float photon_irradiance_entry_area(const struct photon_irradiance *r, size_t entry) {
    return PI_F * sqrf(r->radius[entry]) * r->fade2 / FADE;
}
