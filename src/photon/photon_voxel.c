// SPDX-License-Identifier: Apache-2.0
// Voxels, which remember the entry of irradiance that is nearest to their centre. A search among
// the entries takes as long as two rays, and most lookups are near earlier ones. So a lookup reads
// the entry of its voxel, which is searched at the first lookup there: a voxel is so narrow that
// its entry is as good as the nearest one.
//
// Voxels divide space and the directions of normals. Their width is the spacing of the
// entries around them, rounded down to a power of two. Spacings vary by orders of magnitude
// between what lamps light and the rest, so widths are chosen by regions of a coarse grid.
//
// Entries that were found are kept in a hash table, which all workers read and write without locks.
// An entry is a function of its voxel alone, so no lookup depends on those before it. If all slots
// near that of a voxel are taken, its entry is searched each time.
#include "photon/photon_voxel.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/rng.h"
#include "photon/photon_map.h"

enum {
    COORDINATE_BITS = 17,  // of a voxel's coordinate along an axis
    SCALES = PHOTON_VOXEL_SCALES,
    SCALE_BITS = 5,
    NORMAL_BITS = 4,       // of a direction's coordinate along an axis of the octahedral map
    NORMAL_MOST = 14,      // largest such coordinate: an even number, so axes are centres
    SLOTS = 8,             // per entry: with 4 up to 2.1 times the searches, with 16 .5 to 1 times
    SLOTS_TRIED = 4,       // slots in which a voxel may be
    REGIONS_MOST = 128,    // along an axis
    SLOTS_CHUNK = 1 << 14  // slots that a thread clears at a time
};

// Width of voxels over the spacing of entries. With .5 there are twice as many searches.
static const float VOXEL_WIDTH = 1.0f;

// Regions hold this many entries of a surface in the mean. Too small ones have no entries beside
// lit surfaces, too large ones mix their spacings. With 8 there are 1.0 to 2.8 times as many
// searches, with 32 .7 to 1 times; with one region for all 2.5 times in living-room, 1.2 in
// staircase2, and .1 to 1 times in four scenes without a sky or with few entries
// (docs/experiments/gather-time.md).
static const float REGION_ENTRIES = 16.0f;

// The box of regions ends at so many standard deviations from the mean of the entries, so that a
// far ground does not make the regions of a room too wide: on one a hundred times as wide as the
// room there are 1.5 times as many searches without this limit, but half as many on one ten times
// as wide, and .7 times in veach-ajar. With 1.5 there are 1.0 to 3.5 times as many.
static const float DEVIATIONS = 3.0f;

static const uint64_t NO_KEY = UINT64_MAX;  // has a scale that no voxel has

// A voxel whose entry is known.
struct photon_voxel_slot {
    _Atomic uint64_t key;  // 0: the slot is free
    atomic_int number;     // of the entry, from 1 on; 0: it is being written
};

// ---- Widths by region ---------------------------------------------------------------------------

// Sets the box of the regions, their number, and the widths of voxels by scale. False if the box is
// too small.
static bool set_regions(const struct photon_irradiance *r, struct photon_voxels *out) {
    double sum[3] = {0}, squares[3] = {0};
    float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < r->count; i++) {
        for (int k = 0; k < 3; k++) {
            const float x = r->position.row[6 * i + (size_t)k];
            sum[k] += x;
            squares[k] += (double)x * x;
            lo[k] = minf(lo[k], x);
            hi[k] = maxf(hi[k], x);
        }
    }
    float extent = 0.0f;
    for (int k = 0; k < 3; k++) {
        const double n = (double)r->count, mean = sum[k] / n;
        const double half = DEVIATIONS * sqrt(fmax(squares[k] / n - mean * mean, 0.0));
        lo[k] = maxf(lo[k], (float)(mean - half));
        hi[k] = minf(hi[k], (float)(mean + half));
        extent = maxf(extent, hi[k] - lo[k]);
    }
    if (!(extent > 0.0f && isfinite(extent))) return false;
    const float along = clampf(sqrtf((float)r->count / REGION_ENTRIES), 1.0f, REGIONS_MOST);
    out->lo = v3(lo[0], lo[1], lo[2]);
    out->per_length = along / extent;
    for (int k = 0; k < 3; k++) out->regions[k] = 1 + (int)((hi[k] - lo[k]) * out->per_length);
    // So that voxels within the regions, which end beyond the box, have coordinates of
    // COORDINATE_BITS.
    out->finest = extent * (1.0f + 1.0f / along) / (float)((1 << COORDINATE_BITS) - 2);
    for (int i = 1; i < SCALES; i++) out->per_width[i] = 1.0f / ldexpf(out->finest, i - 1);
    return isfinite(out->per_length) && isfinite(out->per_width[1]);
}

// The region of a point; -1: it is outside the box or not finite.
static inline int region_of(const struct photon_voxels *v, vec3 p) {
    const float x = (p.x - v->lo.x) * v->per_length, y = (p.y - v->lo.y) * v->per_length,
                z = (p.z - v->lo.z) * v->per_length;
    if (!(x >= 0.0f && x < (float)v->regions[0] && y >= 0.0f && y < (float)v->regions[1] &&
          z >= 0.0f && z < (float)v->regions[2]))
        return -1;
    return ((int)z * v->regions[1] + (int)y) * v->regions[0] + (int)x;
}

// The scale of voxels for entries with a spacing; 0: none.
static uint8_t width_scale(float finest, double spacing) {
    int scale;
    frexp(VOXEL_WIDTH * spacing / finest, &scale);  // 2^(scale - 1) <= the argument
    return scale < 1 || scale >= SCALES ? 0 : (uint8_t)scale;
}

// Sets the scale of each region from the geometric mean of the spacings of its entries.
static bool set_scales(const struct photon_irradiance *r, struct photon_voxels *v) {
    const size_t regions = (size_t)v->regions[0] * (size_t)v->regions[1] * (size_t)v->regions[2];
    double *sum = array_new(regions, sizeof *sum);
    uint32_t *count = array_new(regions, sizeof *count);
    v->scale = array_new(regions, 1);
    const bool memory = sum && count && v->scale;
    for (size_t i = 0; memory && i < r->count; i++) {
        const int region = region_of(v, photon_entry_position(&r->position, i));
        const float area = photon_irradiance_entry_area(r, i);
        if (region < 0 || !(area > 0.0f && isfinite(area))) continue;
        sum[region] += 0.5 * log2((double)area);
        count[region]++;
    }
    for (size_t i = 0; memory && i < regions; i++)
        if (count[i]) v->scale[i] = width_scale(v->finest, exp2(sum[i] / count[i]));
    free(sum);
    free(count);
    return memory;
}

static void clear_slots(void *ctx, size_t begin, size_t end, int worker) {
    struct photon_voxels *v = ctx;
    (void)worker;
    memset(v->slot + begin, 0, (end - begin) * sizeof *v->slot);
}

// Makes the hash table, without entries. False if there is no memory.
static bool make_slots(const struct photon_irradiance *r, struct parallel *pool,
                       struct photon_voxels *v) {
    unsigned bits = 10;
    while ((size_t)1 << bits < SLOTS * r->count) bits++;
    v->shift = 64 - bits;
    v->slots = ((size_t)1 << bits) + SLOTS_TRIED;
    v->slot = array_new_unset(v->slots, sizeof *v->slot);
    if (v->slot) parallel_for_all(pool, v->slots, SLOTS_CHUNK, clear_slots, v);
    return v->slot;
}

bool photon_voxels_build(struct photon_irradiance *irradiance, struct parallel *pool) {
    struct photon_voxels v = {0};
    if (!set_regions(irradiance, &v)) return true;
    if (set_scales(irradiance, &v) && make_slots(irradiance, pool, &v)) {
        irradiance->voxels = v;
        return true;
    }
    photon_voxels_free(&v);
    return false;
}

void photon_voxels_free(struct photon_voxels *voxels) {
    free(voxels->scale);
    free(voxels->slot);
    *voxels = (struct photon_voxels){0};
}

size_t photon_voxels_bytes(const struct photon_voxels *v) {
    const size_t regions = (size_t)v->regions[0] * (size_t)v->regions[1] * (size_t)v->regions[2];
    return regions * sizeof *v->scale + v->slots * sizeof *v->slot;
}

// ---- Lookups ------------------------------------------------------------------------------------

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

// The key of the voxel that holds a point with a unit normal; NO_KEY: there is none.
static uint64_t key_of(const struct photon_voxels *v, vec3 p, vec3 n) {
    const int region = region_of(v, p);
    const int scale = region < 0 ? 0 : v->scale[region];
    if (scale == 0) return NO_KEY;
    const float per_width = v->per_width[scale];
    const uint64_t x = (uint64_t)((p.x - v->lo.x) * per_width);
    const uint64_t y = (uint64_t)((p.y - v->lo.y) * per_width);
    const uint64_t z = (uint64_t)((p.z - v->lo.z) * per_width);
    return (((x << COORDINATE_BITS | y) << COORDINATE_BITS | z) << SCALE_BITS | (uint64_t)scale)
               << 2 * NORMAL_BITS |
           normal_key(n);
}

// Sets the query of a voxel: its centre.
static void set_centre(const struct photon_irradiance *r, uint64_t key, float query[6]) {
    const struct photon_voxels *v = &r->voxels;
    const uint64_t coordinates = key >> 2 * NORMAL_BITS, mask = (1u << COORDINATE_BITS) - 1u;
    const float width = 1.0f / v->per_width[coordinates & (SCALES - 1)];
    const float x = (float)(coordinates >> (2 * COORDINATE_BITS + SCALE_BITS));
    const float y = (float)(coordinates >> (COORDINATE_BITS + SCALE_BITS) & mask);
    const float z = (float)(coordinates >> SCALE_BITS & mask);
    const vec3 p = v3_add(v->lo, v3_mul(v3(x + 0.5f, y + 0.5f, z + 0.5f), width));
    photon_entry_row_set(query, p, normal_of(key), r->position.scale);
}

// The first slot in which a voxel may be.
static size_t home_of(const struct photon_voxels *v, uint64_t key) {
    return key * RNG_GOLDEN >> v->shift;
}

// The entry of a voxel; -1: it is not known yet.
static int known_entry(const struct photon_voxels *v, uint64_t key) {
    if (key == NO_KEY) return -1;
    const size_t home = home_of(v, key);
    for (size_t i = 0; i < SLOTS_TRIED; i++) {
        const struct photon_voxel_slot *slot = &v->slot[home + i];
        const uint64_t at = atomic_load_explicit(&slot->key, memory_order_acquire);
        if (at == key) return atomic_load_explicit(&slot->number, memory_order_relaxed) - 1;
        if (at == 0) break;
    }
    return -1;
}

// Remembers the entry of a voxel, unless the slots near its home are taken.
static void remember(const struct photon_voxels *v, uint64_t key, int entry) {
    const size_t home = home_of(v, key);
    for (size_t i = 0; i < SLOTS_TRIED; i++) {
        struct photon_voxel_slot *slot = &v->slot[home + i];
        uint64_t at = atomic_load_explicit(&slot->key, memory_order_relaxed);
        if (at == 0 && atomic_compare_exchange_strong(&slot->key, &at, key)) at = key;
        if (at != key) continue;
        atomic_store_explicit(&slot->number, entry + 1, memory_order_relaxed);
        return;
    }
}

void photon_voxel_find(const struct photon_irradiance *r, const vec3 *p, const vec3 *n,
                       size_t count, int *entry) {
    const struct photon_voxels *v = &r->voxels;
    uint64_t key[PHOTON_VOXEL_LOOKUPS];
    for (size_t i = 0; i < count; i++) {
        key[i] = key_of(v, p[i], n[i]);
        __builtin_prefetch(&v->slot[home_of(v, key[i])]);
    }
    size_t missing = 0;
    int missed[PHOTON_VOXEL_LOOKUPS], found[PHOTON_VOXEL_LOOKUPS];
    float query[6 * PHOTON_VOXEL_LOOKUPS], distance2[PHOTON_VOXEL_LOOKUPS];
    for (size_t i = 0; i < count; i++) {
        entry[i] = known_entry(v, key[i]);
        if (entry[i] >= 0) continue;
        if (key[i] == NO_KEY)
            photon_entry_row_set(query + 6 * missing, p[i], n[i], r->position.scale);
        else
            set_centre(r, key[i], query + 6 * missing);
        missed[missing++] = (int)i;
    }
    if (missing == 0) return;
    photon_index_nearest(r->index, query, missing, 1, r->far2, found, distance2);
    for (size_t i = 0; i < missing; i++) {
        const int at = missed[i];
        entry[at] = found[i];
        if (key[at] != NO_KEY) remember(v, key[at], found[i]);
    }
}
