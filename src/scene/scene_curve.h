// SPDX-License-Identifier: Apache-2.0
// Private to scene/: curves as round tubes.
#ifndef SCENE_CURVE_H
#define SCENE_CURVE_H

#include "scene/scene.h"

// Where a curve was hit.
struct curve_hit {
    uint32_t segment;
    float u;  // along the segment, 0 to 1
    vec3 p;   // as the ray tracer computed it
    vec3 n;   // normal, any length
    bool flip;
};
// Fills p, ng, frame, uv, dp_du and dp_dv. The point is moved a little outwards off the tube,
// because the errors of traced tubes grow with their radius.
void scene_curve_interaction(const struct curves *curves, const struct curve_hit *hit, bool tangent,
                             struct interaction *out);

#endif
