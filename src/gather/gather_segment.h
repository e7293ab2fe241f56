// SPDX-License-Identifier: Apache-2.0
// Private to gather/: segments of light paths (gather_segment.c).
#ifndef GATHER_SEGMENT_H
#define GATHER_SEGMENT_H

#include "gather/gather.h"

// The number of segments from the eye to the end of a gather ray without specular surfaces.
static inline int gather_hit_depth(const struct gather *g) {
    return photon_hit_depth(g->options) + g->deeper;
}
// Whether a path from the eye whose first `depth` segments end at a surface is within max_depth
// with `more` segments after it.
static inline bool gather_within_depth(const struct gather *g, int depth, int more) {
    return g->options->max_depth < 0 || depth + more <= g->options->max_depth;
}
// Likewise with the path of any photon of the estimate after it.
static inline bool gather_reads_photons(const struct gather *g, int depth) {
    return gather_within_depth(g, depth, g->options->gather_direct ? 2 : 1);
}

// The start of a segment.
struct gather_segment_start {
    struct ray ray;
    float spread;       // width over distance of what the ray represents, for textures; 0: a point
    float alpha_least;  // least roughness of lobes at its end; 0: any
    // The surface point that the ray leaves, against whose light samples emitted light is weighted;
    // NULL: emitted light is ignored.
    const struct light_receiver *lit;
    int depth;  // number of segments from the eye to that point
};

// Results of tracing a segment.
struct gather_segment {
    rgb T;                      // transmittance of the ideal specular surfaces
    int specular;               // number of these
    struct gather_first first;  // the first surface that the ray hits
    rgb Le;  // direct light: emitted light hit directly or through panes; 0 if `lit` is NULL, as
             // the following two
    float light_pdf;  // density over solid angle with which light samples at `lit` draw it
    rgb Le_specular;  // emitted light by other ideal specular surfaces
};

// Follows a segment to the first surface with a smooth lobe, and sets *end to it. False, with *end
// undefined, if there is none: the segment leaves the scene, is absorbed, or ends by Russian
// roulette.
bool gather_segment_trace(const struct gather *g, const struct gather_segment_start *start,
                          struct sampler *sampler, struct gather_segment *out,
                          struct shading_point *end);

#endif
