// SPDX-License-Identifier: Apache-2.0
// Private to gather/: rays of a hemisphere that go to photon clusters, beside the stratified ones.
#ifndef GATHER_GUIDE_H
#define GATHER_GUIDE_H

#include "gather/gather_near.h"

// The photon clusters that a site sees, and the rays that it sends there.
struct gather_guide {
    struct guide_rays to;
    size_t first[GUIDE_CONES];  // ray of a cone
    struct gather_near near;
};

// Puts guided rays from the site behind the layout's rays, which `scratch` holds; returns how many.
// None goes below the horizon.
size_t gather_guide_rays(const struct gather *g, const struct gather_layout *layout,
                         const struct gather_site *site, struct gather_scratch *scratch,
                         struct gather_guide *out);
// Weighs L of the first `count` rays, which were traced, so that each counts as a ray of the
// layout.
void gather_guide_weigh(const struct gather_guide *guide, const struct gather_layout *layout,
                        struct gather_scratch *scratch, size_t count);

// As gather_rays; bounces from hits near the site of `near` are guided (gather_near.c).
void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream,
                        struct gather_near *near);

#endif
