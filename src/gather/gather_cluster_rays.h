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
// The factor of the radiance along ray i of the hemisphere by which it counts as a stratified one,
// if only the other rays and those to clusters exist: for a ray by a lobe, that of such a
// direction.
float gather_cluster_rays_weight(const struct gather_cluster_rays *clusters,
                                 const struct gather_hemisphere *h, size_t i);

#endif
