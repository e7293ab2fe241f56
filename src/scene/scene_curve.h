// SPDX-License-Identifier: Apache-2.0
// Private to scene/: curves as round tubes.
#ifndef SCENE_CURVE_H
#define SCENE_CURVE_H

#include "scene/scene.h"

// Where a curve was hit.
struct curve_hit {
    uint32_t segment;
    float u;  // along the segment, 0 to 1
    vec3 p;   // as the ray finds it
    vec3 n;   // normal, any length
    bool flip;
};
// Fills p, ng, frame, uv and dp_du, dp_dv. The point is put a little off the tube, to the outside:
// the tracer finds tubes with errors that grow with their radius.
void curve_interaction(const struct curves *curves, const struct curve_hit *hit, bool tangent,
                       struct interaction *out);

#endif
