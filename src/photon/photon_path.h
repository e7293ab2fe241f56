// SPDX-License-Identifier: Apache-2.0
// Private to photon/: one light path, and where it stores photons.
#ifndef PHOTON_PATH_H
#define PHOTON_PATH_H

#include "base/rng.h"
#include "photon/photon_map.h"

// The photons of one chunk of paths for one consumer.
struct photon_stored {
    struct photon_hit *hit;
    size_t count, capacity;
    size_t first;  // index of the first of them among those of all chunks
    uint64_t stored[PHOTON_CLASSES];
};

struct photon_chunk {
    struct photon_stored photons[PHOTON_CONSUMERS];
    struct photon_power power[PHOTON_POWERS];  // of its paths
    uint64_t refused;                          // number of photons that are not finite
    bool failed;                               // whether memory ran out
};

// A photon on its way.
struct photon_path {
    struct ray ray;
    rgb power;
    float unit;       // the power at which it goes on for sure when it scatters, largest component
    float entering;   // that of photons through the openings of the aim; at most `unit`
    uint32_t light;   // index of the light that emitted it
    uint8_t bounces;  // these as in photon_hit
    bool last;
    uint8_t path;
    enum photon_class class;             // direct, unless a chain deflects it: see class_at
    struct light_chain chain;            // of a direct photon
    unsigned classes[PHOTON_CONSUMERS];  // classes that each consumer gets from this path
    unsigned wanted;                     // classes that any of them gets
    float factor[PHOTON_CONSUMERS];      // factor of its power, for each consumer
};

// The random numbers in [0, 1) by which path `index` of a light starts (photon_trace.c). The paths
// of each 2^32 are a sequence of their own.
void photon_start_numbers(const struct photon_tracing *tracing, uint32_t light, uint64_t index,
                          float u[4]);

// Follows the photon through the scene and appends what it stores to the chunk, until it is
// absorbed, has no more bounces (< 0: no limit) or, of a caustic pass, meets a surface without
// delta lobes. What becomes of its power is added to that of the chunk, but for the emission.
// Towards the openings, which may be NULL, photons are scattered
// with the power of those that come in there.
void photon_path_follow(const struct satin_scene *scene, bool caustic, int bounces,
                        const struct light_openings *openings, struct photon_path photon,
                        struct rng *rng, struct photon_chunk *chunk);

#endif
