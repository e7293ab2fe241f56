// SPDX-License-Identifier: Apache-2.0
// Private to scene/: spheres, disks and cylinders as exact surfaces, in double precision.
#ifndef SCENE_QUADRIC_H
#define SCENE_QUADRIC_H

#include "scene/scene.h"

// A quadric in object space as in Mitsuba: the unit disk at z = 0 facing +z; the cylinder of radius
// 1 around z from 0 to 1, open at its ends. A sphere has its centre and radius in world space.
struct quadric {
    enum shape_kind kind;
    uint32_t shape;               // index in the scene
    const struct material *mask;  // NULL if rays cannot pass
    bool flip;                    // whether the front side is the inside, or -z
    double to_world[3][4], to_object[3][4];
    double centre[3], radius;  // sphere
};

// False if the transform of the shape has no inverse, or if the radius of a sphere is 0.
bool scene_quadric_make(const struct shape *shape, uint32_t index, struct quadric *out);
// A box around the surface, rounded outwards.
void scene_quadric_bounds(const struct quadric *quadric, vec3 *lo, vec3 *hi);
// The nearest crossing in (tnear, tfar) along o + t d.
bool scene_quadric_intersect(const struct quadric *quadric, vec3 o, vec3 d, float tnear, float tfar,
                             float *t);
// Fills p (projected onto the surface), ng, frame and uv of the hit at distance t. The frame
// follows dp/du if `tangent`.
void scene_quadric_interaction(const struct quadric *quadric, const struct ray *ray, float t,
                               bool tangent, struct interaction *out);

#endif
