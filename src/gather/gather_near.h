// SPDX-License-Identifier: Apache-2.0
// Private to gather/: the next bounce of gather rays that hit near to their site.
#ifndef GATHER_NEAR_H
#define GATHER_NEAR_H

#include "gather/gather_scratch.h"

// The photon clusters around a site, for the next bounce of rays that hit near to it.
struct gather_near {
    vec3 p;          // the site,
    float expected;  // and roughly its irradiance [W m^-2]
    struct guide_cone cone[GUIDE_CONES];
    float visible[GUIDE_CONES];  // fraction of the near hits from which it is visible, never 0
    int found;                   // cones around the site; negative: not yet looked for
    int count;                   // of them, first in `cone`, those that matter to the hits
};

// Finds the clusters around the site that matter to those of the first `count` hits that are near
// it; E and radius of the hits must be known.
void gather_near_look(const struct gather *g, const struct gather_hits *hits, size_t count,
                      struct gather_near *near);

// Draws a direction from which y, near the site, reflects light by its diffuse lobe: by the lobe or
// to one of the clusters. E [W m^-2] is the luminance of the first-pass irradiance at y. Otherwise
// as brdf_sample; pdf_w is the lobe's alone, for MIS with lights.
bool gather_near_bounce(const struct gather_near *near, const struct gather_point *y, float E,
                        float u_lobe, vec2 u, struct brdf_sample *out);

// As gather_rays; bounces from hits near the site of `near` are guided. NULL: none are.
void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream,
                        struct gather_near *near);

#endif
