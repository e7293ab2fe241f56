// SPDX-License-Identifier: Apache-2.0
// Private to scene/: exact hits on triangles, and the offset of a ray's origin from the surface.
#ifndef SCENE_INTERACTION_H
#define SCENE_INTERACTION_H

#include "scene/scene.h"

// The distance from the surface at which a ray from p starts: a bound of the distance between a
// float position and its surface. It is relative to p, so that it is valid in scenes of any size.
// The scene's epsilon covers the rounding of double where p is near the origin, and that of rays
// transformed to an instance's space.
static inline float scene_interaction_offset(const struct satin_scene *scene, vec3 p) {
    const float ulps = 8.0f * 0x1p-24f;
    return ulps * (v3_max_abs(p) + scene->epsilon);
}

// A hit on a triangle, with barycentric coordinates (1 - u - v, u, v).
struct interaction_hit {
    uint32_t prim;
    float u, v;
    bool tangent;   // whether the frame follows dp/du
    bool partials;  // whether dp_du and dp_dv are needed; always true if `tangent`
    bool rate;      // whether uv_rate is needed
    float margin;   // least distance of the point from the edges; 0: 4 offsets
};
// Fills p, ng, frame and uv, and if needed dp_du, dp_dv and uv_rate, in the mesh's own space.
void scene_interaction_triangle(const struct satin_scene *scene, const struct shape *shape,
                                const struct interaction_hit *hit, struct interaction *out);

// Whether the ray o + t d crosses the plane of the triangle at tnear < t < tfar, in double.
bool scene_interaction_crosses(const struct mesh *mesh, uint32_t prim, vec3 o, vec3 d, float tnear,
                               float tfar);

// A bound of the error with which a ray tracer computes, in float, the distance from a triangle's
// plane times the length |n| of the product of two edges: a few ulp of the longest edge cubed. It
// is below both `most` and `by_area` |n|^1.5.
struct interaction_error {
    double most, by_area;
};
struct interaction_error scene_interaction_error(const struct mesh *mesh);

#endif
