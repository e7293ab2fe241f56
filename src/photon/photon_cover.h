// SPDX-License-Identifier: Apache-2.0
// Private to photon/: the photons whose own discs cover a point (photon_cover.c).
#ifndef PHOTON_COVER_H
#define PHOTON_COVER_H

#include "photon/photon_index_tree.h"
#include "photon/photon_map.h"

// Around the own discs of the photons below a node of the map's index.
struct photon_cover {
    float lo[3], hi[3];
    uint32_t end;  // the first node after those below this one
};

// Sets map->cover, given the radii. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_cover_build(struct photon_map *map, struct parallel *pool);
size_t photon_cover_bytes(const struct photon_map *map);

// Goes through the photons whose discs cover p, some at a time, which are those of `disc`.
struct photon_cover_walk {
    struct photon_disc disc;
    uint32_t node;  // the next one
    int row[PHOTON_INDEX_LEAF];
    float distance2[PHOTON_INDEX_LEAF];
};
// Begins at p, a point on a surface of unit geometric normal n. The radii, areas and boxes of the
// map must be known.
void photon_cover_begin(struct photon_cover_walk *walk, const struct photon_map *map, vec3 p,
                        vec3 n, enum photon_kernel kernel);
// Sets the next photons of the disc; false if there are no more.
bool photon_cover_next(struct photon_cover_walk *walk);

// Irradiance at photons begin to end - 1, by those whose discs cover them, and, if `bounces` is not
// NULL, the largest number of bounces of one of these; by photon.
void photon_cover_estimate(const struct photon_map *map, size_t begin, size_t end,
                           enum photon_kernel kernel, rgb *E, uint8_t *bounces);

#endif
