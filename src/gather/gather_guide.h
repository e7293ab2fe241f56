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

// As gather_rays; bounces near where the rays begin are guided. NULL: they are not.
void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream,
                        const struct gather_guide *guide);
// Draws a direction from which y, near the site, reflects light by its diffuse lobe: by the lobe or
// to one of the places. Otherwise as brdf_sample; pdf_w is the lobe's alone, for MIS with lights.
bool gather_guide_bounce(const struct gather_guide *guide, const struct gather_point *y,
                         float u_lobe, vec2 u, struct brdf_sample *out);

#endif
