// SPDX-License-Identifier: Apache-2.0
// Private to photon/: the area of the surface in each photon's own disc (photon_own_area.c).
#ifndef PHOTON_OWN_AREA_H
#define PHOTON_OWN_AREA_H

#include "photon/photon_map.h"

// The area of one photon's disc, whose squared radius is map->radius2.
struct photon_own_area {
    float scale;   // 1 / (area of the surface in it, weighted by the kernel) [m^-2]
    float clear2;  // squared distance up to which there is no wall or edge
    // By sector, in units of EXTENT_STEP radii; undefined if the surface covers the whole disc.
    uint8_t extent[AREA_SECTORS];
};

// Sets map->own and, for all photons, map->whole_disc and `clear`, the least distance to a wall or
// an edge, both of which have memory for as many. The radii must be known. With `measure` false all
// discs count as whole. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_own_areas_find(struct photon_map *map, const struct satin_scene *scene,
                                   enum photon_kernel kernel, bool measure, struct parallel *pool,
                                   float *clear);
// The weight [m^-2] with which photon i, whose unit normal is n, counts at p, at a squared distance
// d2 that is less than its radius2. 0 beyond a wall or an edge.
float photon_own_weight(const struct photon_map *map, size_t i, vec3 n, vec3 p, float d2,
                        enum photon_kernel kernel);

#endif
