// SPDX-License-Identifier: Apache-2.0
// Voxels, which remember the entry of irradiance that is nearest to their centre. A search among
// the entries takes as long as two rays, and most lookups are near earlier ones. So a lookup reads
// the entry of its voxel, which is searched at the first lookup there: a voxel is so narrow that
// its entry is as good as the nearest one.
//
// Voxels divide space and the directions of normals. Their width is the spacing of the entries
// around them, rounded down to a power of two. Spacings vary by orders of magnitude between what
// lamps light and the rest, so widths are chosen by regions of a coarse grid. Regions without
// entries and points beside the grid have the widths of the nearest regions: otherwise there are
// three times as many searches in living-room and ten times in veach-ajar.
//
// Where the entry of a voxel faces away from a point or is hidden from it, several entries are
// tested, which are remembered too: searches for them took 7 % of the time of living-room.
//
// Entries that were found are kept in hash tables, which all workers read and write without locks.
// An entry is a function of its voxel alone, so no lookup depends on those before it. If all slots
// near that of a voxel are taken, its entry is searched each time.
#include "photon/photon_voxel.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    SCALES = PHOTON_VOXEL_SCALES,
    SLOTS = 8,  // per entry: with 4 up to 2.1 times the searches, with 16 .5 to 1 times
    NEAR_SLOTS_MOST = 1 << 17,  // slots of several entries: they take at most 8 MB
    REGIONS_MOST = 128,         // along an axis
    SLOTS_CHUNK = 1 << 14       // slots that a thread clears at a time
};

// Width of voxels over the spacing of entries. With .5 there are twice as many searches.
static const float VOXEL_WIDTH = 1.0f;

// Regions hold this many entries of a surface in the mean. Too large ones mix spacings: with one
// region for all there are 3.2 times as many searches in living-room and 2.3 in veach-ajar, in
// other scenes .8 to 1.3 times; with 4 and 64 entries .9 to 1.2 times.
static const float REGION_ENTRIES = 16.0f;

// The cube of voxels is this many times as wide as the box of the entries. In veach-ajar a quarter
// of the lookups is beside the box; there 2 and 64 need as many searches.
static const float CUBE_BOXES = 4.0f;

// ---- Widths by region ---------------------------------------------------------------------------

// Sets the box of the regions, their number, and the widths of voxels by scale. False if the box is
// too small.
static bool set_regions(const struct photon_irradiance *r, struct photon_voxels *out) {
    vec3 lo = v3(INFINITY, INFINITY, INFINITY), hi = v3_neg(lo);
    for (size_t i = 0; i < r->count; i++) {
        const vec3 p = photon_entry_position(&r->position, i);
        lo = v3_min(lo, p);
        hi = v3_max(hi, p);
    }
    const vec3 size = v3_sub(hi, lo);
    const float extent = maxf(maxf(size.x, size.y), size.z);
    if (!(extent > 0.0f && isfinite(extent))) return false;
    const float along = clampf(sqrtf((float)r->count / REGION_ENTRIES), 1.0f, REGIONS_MOST);
    out->lo = lo;
    out->hi = hi;
    out->per_length = along / extent;
    for (int k = 0; k < 3; k++) out->regions[k] = 1 + (int)(v3_along(size, k) * out->per_length);
    out->width = CUBE_BOXES * extent;
    const float half = 0.5f * out->width;
    out->corner = v3_sub(v3_mul(v3_add(lo, hi), 0.5f), v3(half, half, half));
    out->finest = out->width / (float)((1 << PHOTON_VOXEL_BITS) - 2);
    for (int i = 1; i < SCALES; i++) out->per_width[i] = 1.0f / ldexpf(out->finest, i - 1);
    return isfinite(out->per_length) && isfinite(out->width) && isfinite(out->per_width[1]);
}

// The scale of voxels for entries with a spacing.
static uint8_t width_scale(float finest, double spacing) {
    int scale;
    frexp(VOXEL_WIDTH * spacing / finest, &scale);  // 2^(scale - 1) <= the argument
    return scale < 1 || scale >= SCALES ? PHOTON_VOXEL_NONE : (uint8_t)scale;
}

// Sets the scale of each region from the geometric mean of the spacings of its entries.
static bool set_scales(const struct photon_irradiance *r, struct photon_voxels *v) {
    const size_t regions = (size_t)v->regions[0] * (size_t)v->regions[1] * (size_t)v->regions[2];
    double *sum = array_new(regions, sizeof *sum);
    uint32_t *count = array_new(regions, sizeof *count);
    v->scale = array_new(regions, 1);
    const bool memory = sum && count && v->scale;
    for (size_t i = 0; memory && i < r->count; i++) {
        const int region = photon_voxel_region(v, photon_entry_position(&r->position, i));
        const float area = photon_irradiance_entry_area(r, i);
        if (!(area > 0.0f && isfinite(area))) continue;
        sum[region] += 0.5 * log2((double)area);
        count[region]++;
    }
    for (size_t i = 0; memory && i < regions; i++)
        if (count[i]) v->scale[i] = width_scale(v->finest, exp2(sum[i] / count[i]));
    free(sum);
    free(count);
    return memory;
}

// Gives the regions without entries the scale of the nearest ones that have one. False if there is
// no memory.
static bool spread_scales(struct photon_voxels *v) {
    const int *along = v->regions, step[3] = {1, along[0], along[0] * along[1]};
    const int regions = along[0] * along[1] * along[2];
    int *queue = array_new_unset((size_t)regions, sizeof *queue), end = 0;
    if (!queue) return false;
    for (int i = 0; i < regions; i++)
        if (v->scale[i] > 0 && v->scale[i] != PHOTON_VOXEL_NONE) queue[end++] = i;
    for (int at = 0; at < end; at++) {
        const int i = queue[at];
        for (int side = 0; side < 6; side++) {
            const int axis = side / 2, move = side % 2 ? 1 : -1;
            const int x = i / step[axis] % along[axis] + move, next = i + move * step[axis];
            if (x < 0 || x >= along[axis] || v->scale[next]) continue;
            v->scale[next] = v->scale[i];
            queue[end++] = next;
        }
    }
    free(queue);
    return true;
}

static void clear_slots(void *ctx, size_t begin, size_t end, int worker) {
    struct photon_voxel_table *table = ctx;
    const size_t bytes = photon_voxel_slot_bytes(table->numbers);
    (void)worker;
    memset(table->memory + begin * bytes, 0, (end - begin) * bytes);
}

// Makes a hash table of at least so many slots, without entries. False if there is no memory.
static bool make_voxel_table(size_t slots, int numbers, struct parallel *pool,
                             struct photon_voxel_table *out) {
    unsigned bits = 10;
    while ((size_t)1 << bits < slots) bits++;
    out->numbers = numbers;
    out->shift = 64 - bits;
    out->slots = ((size_t)1 << bits) + PHOTON_VOXEL_TRIED;
    out->memory = array_new_unset(out->slots, photon_voxel_slot_bytes(numbers));
    if (out->memory) parallel_for_all(pool, out->slots, SLOTS_CHUNK, clear_slots, out);
    return out->memory;
}

static bool make_voxel_tables(size_t entries, struct parallel *pool, struct photon_voxels *v) {
    const size_t slots = SLOTS * entries;
    const size_t near = slots < NEAR_SLOTS_MOST ? slots : NEAR_SLOTS_MOST;
    return make_voxel_table(slots, 1, pool, &v->nearest) &&
           make_voxel_table(near, PHOTON_VOXEL_NEAR, pool, &v->near);
}

bool photon_voxels_build(struct photon_irradiance *irradiance, struct parallel *pool) {
    struct photon_voxels v = {0};
    if (!set_regions(irradiance, &v)) return true;
    if (set_scales(irradiance, &v) && spread_scales(&v) &&
        make_voxel_tables(irradiance->count, pool, &v)) {
        irradiance->voxels = v;
        return true;
    }
    photon_voxels_free(&v);
    return false;
}

void photon_voxels_free(struct photon_voxels *voxels) {
    free(voxels->scale);
    free(voxels->nearest.memory);
    free(voxels->near.memory);
    *voxels = (struct photon_voxels){0};
}

static size_t table_bytes(const struct photon_voxel_table *table) {
    return table->slots * photon_voxel_slot_bytes(table->numbers);
}

size_t photon_voxels_bytes(const struct photon_voxels *v) {
    const size_t regions = (size_t)v->regions[0] * (size_t)v->regions[1] * (size_t)v->regions[2];
    return regions * sizeof *v->scale + table_bytes(&v->nearest) + table_bytes(&v->near);
}
