// SPDX-License-Identifier: Apache-2.0
// Private to gather/: rays of a hemisphere to photon clusters, in addition to the stratified ones.
#ifndef GATHER_CLUSTER_RAYS_H
#define GATHER_CLUSTER_RAYS_H

#include "gather/gather_near.h"

// The photon clusters that are visible from a site and its rays to them, and the clusters around
// it.
struct gather_cluster_rays {
    struct guide_rays to;
    struct gather_near near;
};

// Appends rays from the site to clusters to the stratified rays of a hemisphere.
void gather_cluster_rays_add(const struct gather *g, const struct gather_site *site,
                             struct gather_hemisphere *h, struct gather_cluster_rays *out);
// Weights L of all rays, after tracing, so that each counts as a stratified ray.
void gather_cluster_rays_weights(const struct gather_cluster_rays *clusters,
                                 struct gather_hemisphere *h);

#endif
