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

// Appends rays from the site to clusters to those of the layout in `scratch`. Returns their number.
size_t gather_cluster_rays_add(const struct gather *g, const struct gather_layout *layout,
                               const struct gather_site *site, struct gather_scratch *scratch,
                               struct gather_cluster_rays *out);
// Weights L of the first `count` rays, after tracing, so that each counts as a ray of the layout.
void gather_cluster_rays_weigh(const struct gather_cluster_rays *clusters,
                               const struct gather_layout *layout, struct gather_scratch *scratch,
                               size_t count);

// The least roughness of lobes that the rays of a site hit, from the solid angle that a ray
// represents (gather_hemisphere.c).
float gather_alpha_least(const struct gather_site *site, float spread);

#endif
