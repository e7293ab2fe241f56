// SPDX-License-Identifier: Apache-2.0
// Private to gather/: segments of light paths (gather_segment.c).
#ifndef GATHER_SEGMENT_H
#define GATHER_SEGMENT_H

#include "gather/gather.h"

// Where a segment starts.
struct gather_segment_start {
    struct ray ray;
    float spread;       // width per distance of what the ray stands for, for textures; 0: a point
    float alpha_least;  // roughness that lobes at its end have at least
    const vec3 *lit;  // the surface point that the ray leaves, whose light samples emitted light is
                      // weighed against; NULL: do not look for emitted light
    int depth;        // segments between the eye and that point
};

// What a segment meets on its way.
struct gather_segment {
    rgb T;                      // what the ideal specular surfaces leave of the light at its end
    struct gather_first first;  // the surface that the ray itself meets
    rgb Le;           // direct light: emitted light before any ideal specular surface, or through
                      // panes; 0 unless `lit` is given, as the following two
    float light_pdf;  // density over solid angle with which light samples at `lit` draw it
    rgb Le_specular;  // emitted light that comes by other ideal specular surfaces
};

// Follows a segment to the first surface with a smooth lobe, which *end gets. False if the segment
// ends without one: it leaves the scene, is absorbed, or is ended by chance. *end is undefined
// then.
bool gather_segment_trace(const struct gather *g, const struct gather_segment_start *start,
                          struct sampler *sampler, struct gather_segment *out,
                          struct gather_point *end);

#endif
