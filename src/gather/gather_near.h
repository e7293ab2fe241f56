// SPDX-License-Identifier: Apache-2.0
// Private to gather/: the next bounce of gather rays that hit near to their site.
#ifndef GATHER_NEAR_H
#define GATHER_NEAR_H

#include "gather/gather_guide.h"

// Finds the bright places around the site of the scratch's guide that matter to those of its first
// `hits` hits that are near; E and radius of the hits must be known.
void gather_near_look(const struct gather *g, struct gather_scratch *scratch, size_t hits);

// Draws a direction from which y, near the site, reflects light by its diffuse lobe: by the lobe or
// to one of the places. E [W m^-2] is the luminance of the first-pass irradiance at y. Otherwise as
// brdf_sample; pdf_w is the lobe's alone, for MIS with lights.
bool gather_near_bounce(const struct gather_near *near, const struct gather_point *y, float E,
                        float u_lobe, vec2 u, struct brdf_sample *out);

#endif
