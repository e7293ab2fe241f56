// SPDX-License-Identifier: Apache-2.0
// 4x4 matrices.
#include "base/mat4.h"

#include <string.h>

struct mat4 mat4_identity(void) {
    return (struct mat4){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
}

struct mat4 mat4_mul(const struct mat4 *a, const struct mat4 *b) {
    struct mat4 c;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double s = 0.0;
            for (int k = 0; k < 4; k++) s += (double)a->m[i][k] * (double)b->m[k][j];
            c.m[i][j] = (float)s;
        }
    return c;
}

bool mat4_inverse(const struct mat4 *m, struct mat4 *out) {
    // Gauss-Jordan with partial pivoting on [M | I].
    double a[4][8];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 8; j++) a[i][j] = j < 4 ? (double)m->m[i][j] : (double)(j - 4 == i);
    for (int c = 0; c < 4; c++) {
        int pivot = c;
        for (int r = c + 1; r < 4; r++)
            if (fabs(a[r][c]) > fabs(a[pivot][c])) pivot = r;
        if (!(fabs(a[pivot][c]) > 0.0) || !isfinite(a[pivot][c])) return false;
        double row[8];
        memcpy(row, a[pivot], sizeof row);
        memcpy(a[pivot], a[c], sizeof row);
        for (int j = 0; j < 8; j++) a[c][j] = row[j] / row[c];
        for (int r = 0; r < 4; r++) {
            if (r == c) continue;
            double f = a[r][c];
            for (int j = 0; j < 8; j++) a[r][j] -= f * a[c][j];
        }
    }
    struct mat4 inverse;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            inverse.m[i][j] = (float)a[i][j + 4];
            if (!isfinite(inverse.m[i][j])) return false;
        }
    *out = inverse;
    return true;
}

double mat4_det3(const struct mat4 *t) {
    const float(*m)[4] = t->m;
    return (double)m[0][0] * ((double)m[1][1] * m[2][2] - (double)m[1][2] * m[2][1]) -
           (double)m[0][1] * ((double)m[1][0] * m[2][2] - (double)m[1][2] * m[2][0]) +
           (double)m[0][2] * ((double)m[1][0] * m[2][1] - (double)m[1][1] * m[2][0]);
}

struct mat4 mat4_translate(vec3 t) {
    return (struct mat4){{{1, 0, 0, t.x}, {0, 1, 0, t.y}, {0, 0, 1, t.z}, {0, 0, 0, 1}}};
}

struct mat4 mat4_scale(vec3 s) {
    return (struct mat4){{{s.x, 0, 0, 0}, {0, s.y, 0, 0}, {0, 0, s.z, 0}, {0, 0, 0, 1}}};
}

struct mat4 mat4_rotate(vec3 axis, float degrees) {
    double length =
        sqrt((double)axis.x * axis.x + (double)axis.y * axis.y + (double)axis.z * axis.z);
    double x = axis.x / length, y = axis.y / length, z = axis.z / length;
    double angle = (double)degrees * 3.14159265358979323846 / 180.0;
    double s = sin(angle), c = cos(angle), d = 1.0 - c;
    return (struct mat4){
        {{(float)(c + x * x * d), (float)(x * y * d - z * s), (float)(x * z * d + y * s), 0},
         {(float)(y * x * d + z * s), (float)(c + y * y * d), (float)(y * z * d - x * s), 0},
         {(float)(z * x * d - y * s), (float)(z * y * d + x * s), (float)(c + z * z * d), 0},
         {0, 0, 0, 1}}};
}

// A vector times the power of two that brings its largest component near 1, so that its square is
// neither 0 nor infinite.
static vec3 near_one(vec3 v) {
    int exponent;
    (void)frexpf(v3_max_abs(v), &exponent);
    return v3(ldexpf(v.x, -exponent), ldexpf(v.y, -exponent), ldexpf(v.z, -exponent));
}

bool mat4_look_at(vec3 origin, vec3 target, vec3 up, struct mat4 *out) {
    vec3 dir = v3_unit(near_one(v3_sub(target, origin)));
    const vec3 cross = v3_cross(near_one(up), dir), left = v3_unit(cross);
    // The product of vectors that are parallel but for rounding has no direction.
    const bool parallel = !(v3_len2(cross) > 1e-12f);
    if (parallel || !(v3_len2(dir) > 0.5f) || !v3_finite(origin)) return false;
    vec3 y = v3_cross(dir, left);
    *out = (struct mat4){{{left.x, y.x, dir.x, origin.x},
                          {left.y, y.y, dir.y, origin.y},
                          {left.z, y.z, dir.z, origin.z},
                          {0, 0, 0, 1}}};
    return true;
}

vec3 mat4_point(const struct mat4 *t, vec3 p) {
    const float(*m)[4] = t->m;
    vec3 q = v3(m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]);
    float w = m[3][0] * p.x + m[3][1] * p.y + m[3][2] * p.z + m[3][3];
    return w == 1.0f ? q : v3_mul(q, 1.0f / w);
}

vec3 mat4_vector(const struct mat4 *t, vec3 v) {
    const float(*m)[4] = t->m;
    return v3(m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
              m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
              m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z);
}

vec3 mat4_normal(const struct mat4 *inverse, vec3 n) {
    const float(*m)[4] = inverse->m;
    return v3(m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z,
              m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
              m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z);
}
