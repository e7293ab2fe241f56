// SPDX-License-Identifier: Apache-2.0
// Lookups of entries of irradiance by voxels (photon_voxel.c).
#include "base/rng.h"
#include "photon/photon_map.h"

enum {
    SCALE_BITS = 5,
    NORMAL_BITS = 4,  // of a direction's coordinate along an axis of the octahedral map
    NORMAL_MOST = 14  // largest such coordinate: an even number, so axes are centres
};

// Beside the box of the entries, all of them are as far as the box at least, so voxels are as wide
// as this fraction of its distance. On a ground a hundred times as wide as a room, .125, .5 and 2
// need .75, .2 and .03 searches per lookup.
static const float FAR_WIDTH = 0.5f;

static const uint64_t NO_KEY = UINT64_MAX;  // has a scale that no voxel has

// The coordinates of a unit normal in the octahedral map [Cigolle et al. 2014].
static inline uint64_t normal_key(vec3 n) {
    const float scale = 1.0f / (fabsf(n.x) + fabsf(n.y) + fabsf(n.z));
    float x = n.x * scale, y = n.y * scale;
    if (n.z < 0.0f) {
        const float folded = copysignf(1.0f - fabsf(y), x);
        y = copysignf(1.0f - fabsf(x), y);
        x = folded;
    }
    const float half = 0.5f * (float)NORMAL_MOST;
    return (uint64_t)(half * x + half + 0.5f) << NORMAL_BITS | (uint64_t)(half * y + half + 0.5f);
}

static vec3 normal_of(uint64_t key) {
    const float half = 0.5f * (float)NORMAL_MOST;
    const float x = (float)(key >> NORMAL_BITS & 15u) / half - 1.0f;
    const float y = (float)(key & 15u) / half - 1.0f, z = 1.0f - fabsf(x) - fabsf(y);
    if (z >= 0.0f) return v3_unit(v3(x, y, z));
    return v3_unit(v3(copysignf(1.0f - fabsf(y), x), copysignf(1.0f - fabsf(x), y), z));
}

// The scale of the voxels at p. Without voxels it is 0 or at least PHOTON_VOXEL_SCALES.
static int scale_at(const struct photon_voxels *v, vec3 p) {
    const vec3 inside = v3_min(v3_max(p, v->lo), v->hi);
    const int scale = v->scale[photon_voxel_region(v, inside)];
    const float beside2 = v3_dist2(p, inside);
    if (beside2 == 0.0f) return scale;
    int far;
    frexpf(FAR_WIDTH * sqrtf(beside2) / v->finest, &far);  // 2^(far - 1) <= the argument
    return scale > far ? scale : far;
}

// The key of the voxel that holds a point with a unit normal; NO_KEY: there is none.
static uint64_t key_of(const struct photon_voxels *v, vec3 p, vec3 n) {
    const vec3 q = v3_sub(p, v->corner);
    if (!(q.x >= 0.0f && q.x < v->width && q.y >= 0.0f && q.y < v->width && q.z >= 0.0f &&
          q.z < v->width))
        return NO_KEY;
    const int scale = scale_at(v, p);
    if (scale == 0 || scale >= PHOTON_VOXEL_SCALES) return NO_KEY;
    const float per_width = v->per_width[scale];
    const uint64_t x = (uint64_t)(q.x * per_width), y = (uint64_t)(q.y * per_width),
                   z = (uint64_t)(q.z * per_width);
    return (((x << PHOTON_VOXEL_BITS | y) << PHOTON_VOXEL_BITS | z) << SCALE_BITS | (uint64_t)scale)
               << 2 * NORMAL_BITS |
           normal_key(n);
}

// Sets a query for the entries of a voxel: its centre.
static void set_centre(const struct photon_irradiance *r, uint64_t key, float query[6]) {
    const struct photon_voxels *v = &r->voxels;
    const uint64_t coordinates = key >> 2 * NORMAL_BITS, mask = (1u << PHOTON_VOXEL_BITS) - 1u;
    const float width = 1.0f / v->per_width[coordinates & (PHOTON_VOXEL_SCALES - 1)];
    const float x = (float)(coordinates >> (2 * PHOTON_VOXEL_BITS + SCALE_BITS));
    const float y = (float)(coordinates >> (PHOTON_VOXEL_BITS + SCALE_BITS) & mask);
    const float z = (float)(coordinates >> SCALE_BITS & mask);
    const vec3 p = v3_add(v->corner, v3_mul(v3(x + 0.5f, y + 0.5f, z + 0.5f), width));
    photon_entry_row_set(query, p, normal_of(key), r->position.scale);
}

// Sets a query for the entries of the voxel or, where there is none, for those near p.
static void set_query(const struct photon_irradiance *r, uint64_t key, vec3 p, vec3 n,
                      float query[6]) {
    if (key == NO_KEY)
        photon_entry_row_set(query, p, n, r->position.scale);
    else
        set_centre(r, key, query);
}

// The i-th of the slots in which a voxel may be.
static struct photon_voxel_slot *slot_of(const struct photon_voxel_table *table, uint64_t key,
                                         size_t i) {
    const size_t home = key * RNG_GOLDEN >> table->shift;
    return (void *)(table->memory + (home + i) * photon_voxel_slot_bytes(table->numbers));
}

// Reads the entries of a voxel. False if they are not known yet.
static bool read_entries(const struct photon_voxel_table *table, uint64_t key, int *entry) {
    for (size_t i = 0; i < PHOTON_VOXEL_TRIED && key != NO_KEY; i++) {
        const struct photon_voxel_slot *slot = slot_of(table, key, i);
        const uint64_t at = atomic_load_explicit(&slot->key, memory_order_relaxed);
        if (at == 0) return false;
        if (at != key) continue;
        bool whole = true;
        for (int k = 0; k < table->numbers; k++) {
            const int number = atomic_load_explicit(&slot->number[k], memory_order_relaxed);
            whole &= number > 0;
            entry[k] = number - 2;
        }
        return whole;
    }
    return false;
}

// Remembers the entries of a voxel, unless the slots in which it may be are taken.
static void remember(const struct photon_voxel_table *table, uint64_t key, const int *entry) {
    for (size_t i = 0; i < PHOTON_VOXEL_TRIED && key != NO_KEY; i++) {
        struct photon_voxel_slot *slot = slot_of(table, key, i);
        uint64_t at = atomic_load_explicit(&slot->key, memory_order_relaxed);
        if (at == 0 && atomic_compare_exchange_strong(&slot->key, &at, key)) at = key;
        if (at != key) continue;
        for (int k = 0; k < table->numbers; k++)
            atomic_store_explicit(&slot->number[k], entry[k] + 2, memory_order_relaxed);
        return;
    }
}

void photon_voxel_find(const struct photon_irradiance *r, const vec3 *p, const vec3 *n,
                       size_t count, int *entry) {
    const struct photon_voxels *v = &r->voxels;
    uint64_t key[PHOTON_VOXEL_LOOKUPS];
    for (size_t i = 0; i < count; i++) {
        key[i] = key_of(v, p[i], n[i]);
        __builtin_prefetch(slot_of(&v->nearest, key[i], 0));
    }
    size_t missing = 0;
    int missed[PHOTON_VOXEL_LOOKUPS], found[PHOTON_VOXEL_LOOKUPS];
    float query[6 * PHOTON_VOXEL_LOOKUPS], distance2[PHOTON_VOXEL_LOOKUPS];
    for (size_t i = 0; i < count; i++) {
        if (read_entries(&v->nearest, key[i], &entry[i])) continue;
        set_query(r, key[i], p[i], n[i], query + 6 * missing);
        missed[missing++] = (int)i;
    }
    if (missing == 0) return;
    photon_index_nearest(r->index, query, missing, 1, r->far2, found, distance2);
    for (size_t i = 0; i < missing; i++) {
        const int at = missed[i];
        entry[at] = found[i];
        remember(&v->nearest, key[at], &found[i]);
    }
}

void photon_voxel_find_near(const struct photon_irradiance *r, vec3 p, vec3 n,
                            int entry[PHOTON_VOXEL_NEAR]) {
    const struct photon_voxels *v = &r->voxels;
    const uint64_t key = v->scale ? key_of(v, p, n) : NO_KEY;
    if (read_entries(&v->near, key, entry)) return;
    float query[6], distance2[PHOTON_VOXEL_NEAR];
    set_query(r, key, p, n, query);
    photon_index_nearest(r->index, query, 1, PHOTON_VOXEL_NEAR, r->far2, entry, distance2);
    remember(&v->near, key, entry);
}
