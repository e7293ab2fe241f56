// SPDX-License-Identifier: Apache-2.0
// Right-handed orthonormal frames. Local coordinates: x along u, y along v, z along n (the normal).
#ifndef BASE_FRAME_H
#define BASE_FRAME_H

#include "base/vec.h"

struct frame {
    vec3 u, v, n;
};

// A frame that depends on a unit normal alone, by Duff et al. 2017, "Building an orthonormal basis,
// revisited". Equal normals give equal frames, so records on a flat surface need no rotation.
static inline struct frame frame_from_normal(vec3 n) {
    float s = copysignf(1.0f, n.z);
    float a = -1.0f / (s + n.z);
    float b = n.x * n.y * a;
    return (struct frame){v3(1.0f + s * n.x * n.x * a, s * b, -s * n.x),
                          v3(b, s + n.y * n.y * a, -n.y), n};
}

// The frame of a unit normal whose u is the projection of `tangent`, of any length. If `tangent` is
// nearly parallel to n, the frame is frame_from_normal(n).
static inline struct frame frame_from_tangent(vec3 n, vec3 tangent) {
    vec3 u = v3_mad(tangent, -v3_dot(n, tangent), n);
    float l2 = v3_len2(u);
    if (!(l2 > 1e-12f * v3_len2(tangent))) return frame_from_normal(n);
    u = v3_mul(u, 1.0f / sqrtf(l2));
    return (struct frame){u, v3_cross(n, u), n};
}

static inline vec3 frame_to_local(const struct frame *f, vec3 w) {
    return v3(v3_dot(w, f->u), v3_dot(w, f->v), v3_dot(w, f->n));
}

static inline vec3 frame_to_world(const struct frame *f, vec3 l) {
    return v3(l.x * f->u.x + l.y * f->v.x + l.z * f->n.x,
              l.x * f->u.y + l.y * f->v.y + l.z * f->n.y,
              l.x * f->u.z + l.y * f->v.z + l.z * f->n.z);
}

// The frame of the other side of the surface: rotated about u by 180 degrees.
static inline struct frame frame_flip(struct frame f) {
    return (struct frame){f.u, v3_neg(f.v), v3_neg(f.n)};
}

#endif
