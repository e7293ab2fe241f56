// SPDX-License-Identifier: Apache-2.0
// Evaluation of the harmonics in one direction, which defines them, and the calls for many.
#include "rsh/rsh.h"

#include <math.h>

#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

// The direction at which spherical harmonics take a hemispherical harmonic's value, but for the
// factor sqrt 2: cos theta' = 2 cos theta - 1 at the same phi. As sin theta' / sin theta =
// 2 sqrt(cos theta / (1 + cos theta)), nothing is singular at the pole.
static void stretch(const float w[3], float out[3]) {
    float z = w[2] > 0.0f ? fminf(w[2], 1.0f) : 0.0f;
    float s = 2.0f * sqrtf(z / (1.0f + z));
    out[0] = s * w[0];
    out[1] = s * w[1];
    out[2] = 2.0f * z - 1.0f;
}

bool rsh_eval(rsh_basis basis, int order, const float w[3], float *y) {
    if (!rsh_order_ok(order)) return false;
    float d[3] = {w[0], w[1], w[2]}, c = 1.0f, s = 0.0f;
    if (basis == RSH_HEMISPHERE) {
        stretch(w, d);
        c = sqrtf(2.0f);
    }
    for (int m = 0; m < order; m++) {
        const float *norm = rsh_norm + m * RSH_MAX_ORDER, *b = rsh_recurrence + m * RSH_MAX_ORDER;
        float p = 1.0f, p1 = 0.0f;
        for (int l = m; l < order; l++) {
            float v = p * norm[l];
            y[l * (l + 1) - m] = v * s;
            y[l * (l + 1) + m] = v * c;
            float next = d[2] * p - (l + 1 < RSH_MAX_ORDER ? b[l + 1] : 0.0f) * p1;
            p1 = p;
            p = next;
        }
        float t = d[0] * c - d[1] * s;
        s = d[0] * s + d[1] * c;
        c = t;
    }
    return true;
}

bool rsh_eval_many(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                   const float *z, float *out) {
    if (!rsh_order_ok(order)) return false;
    rsh_kernels_best()->eval_many(basis, order, count, x, y, z, out);
    return true;
}

bool rsh_project(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                 const float *z, const float *r, const float *g, const float *b, float *out) {
    if (!rsh_order_ok(order)) return false;
    const float *const value[3] = {r, b ? g : NULL, g ? b : NULL};
    rsh_kernels_best()->project(basis, order, count, x, y, z, value, out);
    return true;
}

void rsh_accumulate(size_t count, size_t coefficients, const float *matrix, const float *r,
                    const float *g, const float *b, float *out) {
    const float *const value[3] = {r, b ? g : NULL, g ? b : NULL};
    rsh_kernels_best()->accumulate(count, coefficients, matrix, value, out);
}

bool rsh_dot3(int order, int a_channels, const float *a, const float *b, float out[3]) {
    if (!rsh_order_ok(order)) return false;
    int n = order * order;
    rsh_kernels_best()->dot3(n, a_channels == 1 ? 0 : n, a, b, out);
    return true;
}
