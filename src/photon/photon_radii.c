// SPDX-License-Identifier: Apache-2.0
// The radius of each photon of a map: that of the disc of the k photons nearest to it. An estimate
// whose kernel has the width of its own disc, the balloon estimator, does not have the power of the
// photons [Terrell and Scott 1992]: in the dark beside a caustic the disc widens until it reaches
// the caustic's photons, which count there as well as in the caustic. If each photon is distributed
// by a kernel of its own width [Breiman, Meisel and Purcell 1977], its power is that of the kernel.
//
// All photons around one of them are searched within twice the radius that is expected of it, which
// needs no heap. Among them are the k nearest ones of the photons beside it, too: if its k-th
// neighbour is at r, those of a photon at a distance a are within r + a of that one. Their radii
// are found by counting distances, which takes no jumps that a processor cannot predict.
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    RADII_CHUNK = 256,    // photons of a chunk
    RADII_TOGETHER = 64,  // of these, photons that are searched together
    RADII_AROUND = 8,     // photons around these that are searched at most, in units of k
    RADII_LANES = 16,     // distances that are counted together
    RADII_FEW = 6,        // distances that are sorted, unless equal ones are more
    RADII_MIDDLE = 3      // one in this number of limits is in the middle, as not all are planes
};
// The radius that is searched around a photon, in units of that of the one before it.
#define RADII_WITHIN 2.0f
#define RADII_ROUND 1.00001f  // as distances are rounded

struct radii_loop {
    const struct photon_map *map;
    float *radius2;
    int k;
    atomic_bool failed;
};

// Memory of a chunk: the photons around some, and their positions and distances, with as many more
// as there are lanes.
struct radii_around {
    int count, most;
    int *row;
    float *distance2;
    float *x, *y, *z;
    float *few;
};

// ---- The k-th smallest of distances -------------------------------------------------------------

static int count_below(const float *distance2, int count, float limit) {
    int below[RADII_LANES] = {0}, sum = 0;
    for (int i = 0; i < count; i += RADII_LANES)
        for (int j = 0; j < RADII_LANES; j++) below[j] += distance2[i + j] <= limit;
    for (int j = 0; j < RADII_LANES; j++) sum += below[j];
    return sum;
}

// Sorts the distances above `low` up to `high` into `few`. Without jumps until they are found.
static void sort_few(const float *distance2, int count, float low, float high, float *few) {
    int n = 0;
    for (int i = 0; i < count; i++) {
        few[n] = distance2[i];
        n += (int)(distance2[i] > low) & (int)(distance2[i] <= high);
    }
    for (int i = 1; i < n; i++) {
        const float d2 = few[i];
        int j = i;
        for (; j > 0 && few[j - 1] > d2; j--) few[j] = few[j - 1];
        few[j] = d2;
    }
}

// The k-th smallest of the distances, of which `within` >= k are at most `most`. In a plane, their
// number grows as the squared distance.
static float find_smallest(const struct radii_around *around, int k, float most, int within) {
    const float *distance2 = around->distance2;
    float low = 0.0f, high = most;
    int below = count_below(distance2, around->count, low);
    if (below >= k) return 0.0f;
    for (int i = 1; within - below > RADII_FEW; i++) {
        const float expected = ((float)(k - below) - 0.5f) / (float)(within - below);
        const float limit = low + (i % RADII_MIDDLE ? expected : 0.5f) * (high - low);
        if (!(limit > low && limit < high)) break;
        const int n = count_below(distance2, around->count, limit);
        if (n >= k) {
            high = limit;
            within = n;
        } else {
            low = limit;
            below = n;
        }
    }
    sort_few(distance2, around->count, low, high, around->few);
    return around->few[k - below - 1];
}

// ---- Photons that are neighbours ----------------------------------------------------------------

static void find_alone(struct radii_loop *loop, size_t i, struct radii_around *around) {
    const struct photon_map *map = loop->map;
    photon_index_nearest(map->index, map->position + 3 * i, 1, loop->k, photon_map_far2(map),
                         around->row, around->distance2);
    loop->radius2[i] = photon_radius2(map, around->row, around->distance2, loop->k);
}

// Finds all photons around a position within a radius. False if these are too many.
static bool find_around(const struct photon_map *map, const float p[3], float radius,
                        struct radii_around *around) {
    around->count = photon_index_within(map->index, p, around->most, radius * radius, around->row,
                                        around->distance2);
    if (around->count == around->most) return false;
    for (int i = 0; i < around->count; i++) {
        const float *q = map->position + 3 * (size_t)around->row[i];
        around->x[i] = q[0];
        around->y[i] = q[1];
        around->z[i] = q[2];
    }
    for (int j = around->count; j < around->count + RADII_LANES; j++)
        around->x[j] = around->y[j] = around->z[j] = INFINITY;
    return true;
}

// Finds the radius of photon i, if all of its neighbours within a distance `most` are around it and
// these are k or more.
static bool find_beside(struct radii_loop *loop, size_t i, float most,
                        struct radii_around *around) {
    const float *q = loop->map->position + 3 * i;
    for (int j = 0; j < around->count + RADII_LANES; j++) {
        const float x = q[0] - around->x[j], y = q[1] - around->y[j], z = q[2] - around->z[j];
        around->distance2[j] = x * x + y * y + z * z;
    }
    const int n = count_below(around->distance2, around->count, most * most);
    if (n < loop->k) return false;
    const float r2 = find_smallest(around, loop->k, most * most, n);
    loop->radius2[i] = minf(r2, photon_map_far2(loop->map));
    return true;
}

// Moves those of the photons to the front whose neighbours are all within a distance of the first
// one, which has this radius. Returns their number.
static int select_beside(const struct photon_map *map, vec3 first, float radius, float within,
                         size_t *photon, int count) {
    const float most = 0.5f * (within / RADII_ROUND - radius);
    int near = 0;
    for (int i = 0; i < count; i++) {
        if (!(v3_dist2(photon_position(map, photon[i]), first) < sqrf(most))) continue;
        const size_t other = photon[near];
        photon[near++] = photon[i];
        photon[i] = other;
    }
    return near;
}

// Finds the radii of `count` photons that follow each other in Morton order: of one of those that
// are left, then of the others near it.
static void find_together(struct radii_loop *loop, size_t begin, int count,
                          struct radii_around *around) {
    const struct photon_map *map = loop->map;
    size_t left[RADII_TOGETHER];
    for (int i = 0; i < count; i++) left[i] = begin + (size_t)i;
    float within = 0.0f;
    while (count > 0) {
        const size_t first = left[--count];
        const vec3 p = photon_position(map, first);
        const bool found =
            within > 0.0f && find_around(map, map->position + 3 * first, within, around);
        if (!found || !find_beside(loop, first, within / RADII_ROUND, around)) {
            find_alone(loop, first, around);
            within = RADII_WITHIN * sqrtf(loop->radius2[first]);
            continue;
        }
        const float radius = sqrtf(loop->radius2[first]);
        const int near = select_beside(map, p, radius, within, left, count);
        for (int i = 0; i < near; i++) {
            const float aside = sqrtf(v3_dist2(photon_position(map, left[i]), p));
            if (!find_beside(loop, left[i], (radius + aside) * RADII_ROUND, around))
                find_alone(loop, left[i], around);
        }
        count -= near;
        for (int i = 0; i < count; i++) left[i] = left[near + i];
        within = RADII_WITHIN * radius;
    }
}

static void find_radii(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct radii_loop *loop = ctx;
    const size_t most = RADII_AROUND * (size_t)loop->k, lanes = most + RADII_LANES;
    float *memory = array_new_unset(5 * lanes, sizeof *memory);
    int *row = array_new_unset(most, sizeof *row);
    struct radii_around around = {.most = (int)most, .row = row};
    if (!memory || !row) {
        atomic_store(&loop->failed, true);
        goto end;
    }
    around.distance2 = memory;
    around.x = memory + lanes;
    around.y = memory + 2 * lanes;
    around.z = memory + 3 * lanes;
    around.few = memory + 4 * lanes;
    for (size_t at = begin; at < end; at += RADII_TOGETHER)
        find_together(loop, at, end - at < RADII_TOGETHER ? (int)(end - at) : RADII_TOGETHER,
                      &around);
end:
    free(memory);
    free(row);
}

satin_status photon_map_find_radii(struct photon_map *map, int k, struct parallel *pool) {
    struct radii_loop loop = {.map = map, .k = k};
    loop.radius2 = array_new_unset(map->count, sizeof *loop.radius2);
    if (!loop.radius2) return SATIN_ERROR_MEMORY;
    const struct parallel_results radii = {.slot = {{loop.radius2, sizeof *loop.radius2}},
                                           .journaled = true};
    satin_status status = SATIN_OK;
    if (!parallel_for_results(pool, map->count, RADII_CHUNK, find_radii, &loop, &radii))
        status = SATIN_CANCELLED;
    if (atomic_load(&loop.failed)) status = SATIN_ERROR_MEMORY;
    if (status == SATIN_OK)
        map->radius2 = loop.radius2;
    else
        free(loop.radius2);
    return status;
}
