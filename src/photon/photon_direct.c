// SPDX-License-Identifier: Apache-2.0
// Direct photons at the entries of irradiance. Direct light that is sampled at the entries misses
// lit patches between them, such as that of a spot or of the sun, if they are smaller than the
// entries' spacing; direct photons show them.
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum { DIRECT_CHUNK = 256 };  // photons per chunk

struct direct_lookup {
    const struct photon_maps *maps;
    const struct satin_scene *scene;
    const struct photon_trace *direct;
    int *entry;  // of each photon
};

// Finds the entries as gather rays do that hit the photons' positions: an entry behind a wall would
// get photons that do not arrive where it is read, and hits there would read another one.
static void find_entries(void *ctx, size_t begin, size_t end, int worker) {
    const struct direct_lookup *lookup = ctx;
    (void)worker;
    vec3 p[DIRECT_CHUNK], n[DIRECT_CHUNK];
    rgb E[DIRECT_CHUNK];
    float radius[DIRECT_CHUNK];
    for (size_t i = begin; i < end; i++) {
        p[i - begin] = lookup->direct->hit[i].p;
        n[i - begin] = photon_unpack(lookup->direct->hit[i].n);
    }
    const struct photon_lookups lookups = {end - begin,           p,    n, NULL, E, radius,
                                           lookup->entry + begin, false};
    photon_irradiance_many(lookup->maps, lookup->scene, &lookups);
}

satin_status photon_direct_build(const struct photon_maps *maps, const struct satin_scene *scene,
                                 const struct photon_trace *direct, struct parallel *pool,
                                 struct log log, struct photon_direct **out) {
    *out = NULL;
    const size_t entries = maps->irradiance.count;
    if (direct->count == 0 || entries == 0) return SATIN_OK;
    struct photon_direct *sum = array_new(entries, sizeof *sum);
    int *entry = array_new(direct->count, sizeof *entry);
    struct direct_lookup lookup = {maps, scene, direct, entry};
    const struct parallel_results found = {.slot = {{entry, sizeof *entry}}};
    satin_status status = SATIN_OK;
    if (!sum || !entry)
        status = log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for direct photons");
    else if (!parallel_for_results(pool, direct->count, DIRECT_CHUNK, find_entries, &lookup,
                                   &found))
        status = SATIN_CANCELLED;
    for (size_t i = 0; i < direct->count && status == SATIN_OK; i++) {
        if (entry[i] < 0) continue;
        const float power = rgb_luminance(direct->hit[i].power);
        sum[entry[i]].power += power;
        sum[entry[i]].power2 += power * power;
    }
    free(entry);
    if (status == SATIN_OK)
        *out = sum;
    else
        free(sum);
    return status;
}

struct photon_direct photon_direct_at(const struct photon_maps *maps, size_t entry) {
    return maps->direct ? maps->direct[entry] : (struct photon_direct){0.0f, 0.0f};
}

size_t photon_direct_bytes(const struct photon_maps *maps) {
    return maps->direct ? maps->irradiance.count * sizeof *maps->direct : 0;
}
