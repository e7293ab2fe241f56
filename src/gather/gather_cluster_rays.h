// SPDX-License-Identifier: Apache-2.0
// Private to gather/: rays of a hemisphere that go to photon clusters, beside the stratified ones.
#ifndef GATHER_CLUSTER_RAYS_H
#define GATHER_CLUSTER_RAYS_H

#include "gather/gather_near.h"

// The photon clusters that a site sees and the rays that it sends there, and those around it.
struct gather_cluster_rays {
    struct guide_rays to;
    struct gather_near near;
};

// Puts rays from the site to clusters behind the layout's rays, which `scratch` holds; returns how
// many.
size_t gather_cluster_rays_add(const struct gather *g, const struct gather_layout *layout,
                               const struct gather_site *site, struct gather_scratch *scratch,
                               struct gather_cluster_rays *out);
// Weighs L of the first `count` rays, which were traced, so that each counts as a ray of the
// layout.
void gather_cluster_rays_weigh(const struct gather_cluster_rays *clusters,
                               const struct gather_layout *layout, struct gather_scratch *scratch,
                               size_t count);

// Roughness that a site's rays see lobes to have at least, by the width of the directions for which
// a ray stands (gather_hemisphere.c).
float gather_alpha_least(const struct gather_site *site, float spread);

#endif
