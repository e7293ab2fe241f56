// SPDX-License-Identifier: Apache-2.0
// Private to guide/: the hierarchy of photon clusters (guide_clusters.c), which guide_cones.c
// traverses.
#ifndef GUIDE_CLUSTERS_H
#define GUIDE_CLUSTERS_H

#include "guide/guide.h"

// A sphere around some photons.
struct guide_cluster {
    vec3 centre;
    float radius, power;  // radius of the sphere; luminance of the photons' power [W]
    float area;           // approximate area of the leaves' surface
    float dense;          // largest irradiance of its leaves [W m^-2]
    float common;         // mean irradiance of its leaves, weighted by power
    vec3 normal;          // mean of unit normals, weighted by power
    size_t first, count;  // range of the photons of its leaves
    int32_t right;  // index of its right child, while the left one is the next node; 0: a leaf
};

struct guide_clusters {
    struct guide_cluster *node;  // in depth-first order
    size_t node_count;
    vec3 *position;  // of photons, in the order of the leaves
    float uniform;   // irradiance if all the light were on a sphere around the scene [W m^-2]
};

#endif
