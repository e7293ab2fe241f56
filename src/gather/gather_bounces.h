// SPDX-License-Identifier: Apache-2.0
// Private to gather/: the path after the hit of a gather ray (gather_bounces.c).
#ifndef GATHER_BOUNCES_H
#define GATHER_BOUNCES_H

#include "gather/gather_near.h"

// The first-pass estimate at a surface: its irradiance E [W m^-2], and whether it is reliable. If
// not, the path continues there by the diffuse lobe too.
struct gather_estimate {
    rgb E;
    bool reliable;
    const rgb *direct;  // irradiance of direct light that is not in E; NULL: it is not known
    int light_samples;  // light samples to be taken if it is not known, at least 1
};
// The cosine between geometric and shading normal below which a surface takes no direct light of
// entries, which face as the geometric normal does.
static const float GATHER_UPRIGHT = 0.99f;

// The direct light at y by the entry that a lookup by photon_irradiance_many has returned.
static inline const rgb *gather_direct_known(const struct gather *g, const struct shading_point *y,
                                             int entry) {
    const struct gather_direct *t = g->direct;
    const bool known = t && entry >= 0 && t->similar[entry];
    return known && v3_dot(gather_viewer_normal(y), y->ng) > GATHER_UPRIGHT ? &t->E[entry] : NULL;
}

// The radiance [W m^-2 sr^-1] that y, the hit of a gather ray, reflects by its smooth lobes to its
// viewer, without emitted light. `depth` is the number of segments from the eye to y. Diffuse
// bounces are guided to the clusters of `near`, and lookups are strict if it is of a record; NULL:
// neither.
rgb gather_bounces(const struct gather *g, const struct shading_point *y, int depth,
                   struct gather_estimate estimate, const struct gather_near *near,
                   struct sampler sampler);

#endif
