// SPDX-License-Identifier: Apache-2.0
// Private to guide/: the hierarchy of photon clusters (guide_clusters.c) that guide_cones.c looks
// at.
#ifndef GUIDE_CLUSTERS_H
#define GUIDE_CLUSTERS_H

#include "guide/guide.h"

// A sphere around some photons.
struct guide_cluster {
    vec3 center;
    float radius, power, area;
    float dense;          // largest irradiance of its leaves,
    float common;         // and their mean, by power
    vec3 normal;          // mean of unit normals, by power
    size_t first, count;  // photons of its leaves
    int32_t right;        // its left child is the next node; 0: a leaf
};

struct guide_clusters {
    struct guide_cluster *node;  // depth first
    size_t node_count;
    vec3 *place;   // of photons
    float spread;  // irradiance if all the light came down on a sphere around the scene [W m^-2]
};

#endif
