// SPDX-License-Identifier: Apache-2.0
// Private to scene/: hits on triangles, exactly, and how far a ray starts off the surface.
#ifndef SCENE_INTERACTION_H
#define SCENE_INTERACTION_H

#include "scene/scene.h"

// How far off the surface a ray starts that leaves p: a bound of what separates a float position
// from the surface it lies on. It is relative to p, so that it serves in scenes of any size; the
// scene's epsilon covers double rounding where p is next to the origin, and what rays lose when
// they enter an instance's space.
static inline float interaction_offset(const struct satin_scene *scene, vec3 p) {
    const float ulps = 8.0f * 0x1p-24f;
    return ulps * (v3_max_abs(p) + scene->epsilon);
}

// Where a triangle was hit: barycentric coordinates (1 - u - v, u, v).
struct interaction_hit {
    uint32_t prim;
    float u, v;
    bool tangent;   // the frame follows dp/du
    bool partials;  // dp_du and dp_dv are wanted; they are if `tangent`
    bool rate;      // uv_rate is wanted
    float margin;   // how far off its edges a point is kept; 0: 4 offsets
};
// Fills p, ng, frame and uv, if wanted dp_du and dp_dv, and uv_rate, in the mesh's own space.
void interaction_triangle(const struct satin_scene *scene, const struct shape *shape,
                          const struct interaction_hit *hit, struct interaction *out);

// Whether the ray o + t d crosses the plane of the triangle at tnear < t < tfar, in double.
bool interaction_crosses(const struct mesh *mesh, uint32_t prim, vec3 o, vec3 d, float tnear,
                         float tfar);

// How far the plane distance of a triangle of the mesh is off when a ray tracer computes it in
// float, times the length |n| of the product of two edges: a few ulp of the longest edge cubed. It
// is below both `most` and `by_area` |n|^1.5.
struct interaction_error {
    double most, by_area;
};
struct interaction_error interaction_error(const struct mesh *mesh);

#endif
