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
    RADII_GROUP = 8     // of these, photons that are searched together
};

struct radii_job {
    const struct photon_map *map;
    float *radius2;
    int k;
    atomic_bool failed;
};

static void find_radii(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct radii_job *job = ctx;
    const struct photon_map *map = job->map;
    const size_t k = (size_t)job->k;
    int *row = malloc(RADII_GROUP * k * sizeof *row);
    float *distance2 = malloc(RADII_GROUP * k * sizeof *distance2);
    if (!row || !distance2) atomic_store(&job->failed, true);
    for (size_t at = begin; at < end && !atomic_load(&job->failed); at += RADII_GROUP) {
        const size_t n = end - at < RADII_GROUP ? end - at : RADII_GROUP;
        photon_index_nearest(map->index, map->position + 3 * at, n, job->k, photon_map_far2(map),
                             row, distance2);
        for (size_t i = 0; i < n; i++)
            job->radius2[at + i] = photon_radius2(map, row + i * k, distance2 + i * k, job->k);
    }
    free(row);
    free(distance2);
}

satin_status photon_map_find_radii(struct photon_map *map, int k, struct parallel *pool) {
    struct radii_job job = {.map = map, .k = k};
    job.radius2 = array_new_unset(map->count, sizeof *job.radius2);
    if (!job.radius2) return SATIN_ERROR_MEMORY;
    const struct parallel_results radii = {.slot = {{job.radius2, sizeof *job.radius2}},
                                           .journaled = true};
    satin_status status = SATIN_OK;
    if (!parallel_for_results(pool, map->count, RADII_CHUNK, find_radii, &job, &radii))
        status = SATIN_CANCELLED;
    if (atomic_load(&job.failed)) status = SATIN_ERROR_MEMORY;
    if (status == SATIN_OK)
        map->radius2 = job.radius2;
    else
        free(job.radius2);
    return status;
}
