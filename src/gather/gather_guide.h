// SPDX-License-Identifier: Apache-2.0
// Private to gather/: rays of a hemisphere that go to bright places, beside the even ones.
#ifndef GATHER_GUIDE_H
#define GATHER_GUIDE_H

#include "gather/gather_layout.h"
#include "gather/gather_scratch.h"

// Puts them behind the layout's rays, which `scratch` holds; returns how many.
size_t gather_guide_rays(const struct gather *g, const struct gather_layout *layout,
                         const struct gather_site *site, struct gather_scratch *scratch);
// Makes L of every ray what it counts when all count as the layout's do.
void gather_guide_weigh(const struct gather_layout *layout, struct gather_scratch *scratch);

// As gather_rays; bounces near the site of the scratch's guide are guided (gather_near.c).
void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream);

#endif
