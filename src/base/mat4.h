// SPDX-License-Identifier: Apache-2.0
// 4x4 matrices in row-major order, for column vectors: p' = M p. Products are computed in double
// and rounded.
#ifndef BASE_MAT4_H
#define BASE_MAT4_H

#include "base/vec.h"

struct mat4 {
    float m[4][4];
};

struct mat4 mat4_identity(void);
struct mat4 mat4_mul(const struct mat4 *a, const struct mat4 *b);
// False, and *out untouched, if m has no finite inverse.
bool mat4_inverse(const struct mat4 *m, struct mat4 *out);
// The determinant of the upper left 3x3 block, which is negative if the matrix mirrors.
double mat4_det3(const struct mat4 *m);
struct mat4 mat4_translate(vec3 t);
struct mat4 mat4_scale(vec3 s);
struct mat4 mat4_rotate(vec3 axis, float degrees);  // right-handed, any non-zero axis
// The transform from camera space to world space: z points to the target, y up and x to the left,
// as in Mitsuba. False if origin and target coincide, or `up`, of any length, is along the view.
bool mat4_look_at(vec3 origin, vec3 target, vec3 up, struct mat4 *out);

vec3 mat4_point(const struct mat4 *m, vec3 p);         // divides by w if it is not 1
vec3 mat4_vector(const struct mat4 *m, vec3 v);        // without translation
vec3 mat4_normal(const struct mat4 *inverse, vec3 n);  // multiplies by the transpose of `inverse`;
                                                       // does not normalise

#endif
