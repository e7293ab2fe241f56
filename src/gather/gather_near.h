// SPDX-License-Identifier: Apache-2.0
// Private to gather/: the next bounce of gather rays whose hit is near their site.
#ifndef GATHER_NEAR_H
#define GATHER_NEAR_H

#include "gather/gather_scratch.h"

// The photon clusters around a site, for the next bounce of rays whose hit is near.
struct gather_near {
    vec3 p;          // the site,
    float expected;  // and its approximate irradiance [W m^-2]
    struct guide_cone cone[GUIDE_CONES];
    float visible[GUIDE_CONES];  // fraction of the near hits from which it is visible, never 0
    int found;                   // number of cones around the site; negative: not searched yet
    int count;                   // number of those that contribute to the hits, first in `cone`
};

// Finds the clusters around the site that contribute to those of the first `count` hits that are
// near it. E and radius of the hits must be known.
void gather_near_look(const struct gather *g, const struct gather_hits *hits, size_t count,
                      struct gather_near *near);

// Draws a direction from which y, near the site, reflects light by its diffuse lobe: by the lobe
// itself or to one of the clusters. E [W m^-2] is the luminance of the first-pass irradiance at y.
// Otherwise as brdf_sample; pdf_w is that of the lobe alone, for MIS with light samples.
bool gather_near_bounce(const struct gather_near *near, const struct gather_point *y, float E,
                        float u_lobe, vec2 u, struct brdf_sample *out);

// As gather_rays, with guided bounces from hits near the site of `near`. NULL: no bounces are
// guided.
void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream,
                        struct gather_near *near);

#endif
