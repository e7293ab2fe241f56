// SPDX-License-Identifier: Apache-2.0
// Private to photon/: the hierarchy of bright places (photon_bright.c) that photon_cones.c looks
// at.
#ifndef PHOTON_BRIGHT_H
#define PHOTON_BRIGHT_H

#include "photon/photon_map.h"

// A sphere around some photons.
struct photon_place {
    vec3 center;
    float radius, power, area;
    float dense;          // largest irradiance of its leaves,
    float common;         // and their mean, by power
    vec3 normal;          // mean of unit normals, by power
    size_t first, count;  // photons of its leaves
    int32_t right;        // its left child is the next node; 0: a leaf
};

struct photon_bright {
    struct photon_place *node;  // depth first
    size_t node_count;
    vec3 *place;   // of photons
    float spread;  // irradiance if all the light came down on a sphere around the scene [W m^-2]
};

#endif
