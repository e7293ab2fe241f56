// SPDX-License-Identifier: Apache-2.0
// The radius of each photon of a map: that of the disc of the k photons nearest to it. An estimate
// whose kernel has the width of its own disc, the balloon estimator, does not have the power of the
// photons [Terrell and Scott 1992]: in the dark beside a caustic the disc widens until it reaches
// the caustic's photons, which count there as well as in the caustic. If each photon is distributed
// by a kernel of its own width [Breiman, Meisel and Purcell 1977], its power is that of the kernel.
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    RADII_CHUNK = 256,  // photons of a chunk
    RADII_TOGETHER = 8  // of these, photons that are searched together
};

struct radii_loop {
    const struct photon_map *map;
    float *radius2;
    int k;
    atomic_bool failed;
};

static void find_radii(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct radii_loop *loop = ctx;
    const struct photon_map *map = loop->map;
    const size_t k = (size_t)loop->k;
    int *row = malloc(RADII_TOGETHER * k * sizeof *row);
    float *distance2 = malloc(RADII_TOGETHER * k * sizeof *distance2);
    if (!row || !distance2) atomic_store(&loop->failed, true);
    for (size_t at = begin; at < end && !atomic_load(&loop->failed); at += RADII_TOGETHER) {
        const size_t n = end - at < RADII_TOGETHER ? end - at : RADII_TOGETHER;
        photon_index_nearest(map->index, map->position + 3 * at, n, loop->k, photon_map_far2(map),
                             row, distance2);
        for (size_t i = 0; i < n; i++)
            loop->radius2[at + i] = photon_radius2(map, row + i * k, distance2 + i * k, loop->k);
    }
    free(row);
    free(distance2);
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
