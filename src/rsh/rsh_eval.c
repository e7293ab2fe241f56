// SPDX-License-Identifier: Apache-2.0
// Evaluation of the harmonics in one direction, which defines them, and the calls for many
// directions.
#include "rsh/rsh.h"

#include <math.h>

#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

// Maps a direction to the one at which a spherical harmonic has the hemispherical harmonic's value,
// except for the factor sqrt 2: cos theta' = 2 cos theta - 1 at the same phi. As sin theta' / sin
// theta = 2 sqrt(cos theta / (1 + cos theta)), nothing is singular at the pole.
static void stretch_direction(double w[3]) {
    double z = w[2] > 0.0 ? fmin(w[2], 1.0) : 0.0, s = 2.0 * sqrt(z / (1.0 + z));
    w[0] *= s;
    w[1] *= s;
    w[2] = 2.0 * z - 1.0;
}

// In double: near the poles degree l multiplies an error of z by l (l + 1) / 2. Such an error also
// comes from a length that is 1 only to the rounding of floats; a step of Newton's iteration
// removes it.
bool rsh_eval(rsh_basis basis, int order, const float w[3], float *y) {
    if (!rsh_basis_ok(basis) || !rsh_order_ok(order)) return false;
    double d[3] = {(double)w[0], (double)w[1], (double)w[2]}, c = 1.0, s = 0.0;
    double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (fabs(square - 1.0) < 1e-5)
        for (int i = 0; i < 3; i++) d[i] *= 1.5 - 0.5 * square;
    if (basis == RSH_HEMISPHERE) {
        stretch_direction(d);
        c = sqrt(2.0);
    }
    for (int m = 0; m < order; m++) {
        const float *norm = rsh_norm + m * RSH_MAX_ORDER;
        const double *b = rsh_recurrence_d + m * RSH_MAX_ORDER;
        double p = 1.0, p1 = 0.0;
        for (int l = m; l < order; l++) {
            double v = p * (double)norm[l];
            y[l * (l + 1) - m] = (float)(v * s);
            y[l * (l + 1) + m] = (float)(v * c);
            double next = d[2] * p - (l + 1 < RSH_MAX_ORDER ? b[l + 1] : 0.0) * p1;
            p1 = p;
            p = next;
        }
        double t = d[0] * c - d[1] * s;
        s = d[0] * s + d[1] * c;
        c = t;
    }
    return true;
}

bool rsh_eval_many(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                   const float *z, float *out) {
    if (!rsh_basis_ok(basis) || !rsh_order_ok(order)) return false;
    rsh_kernels_best()->eval_many(basis, order, count, x, y, z, out);
    return true;
}

bool rsh_project(rsh_basis basis, int order, const rsh_samples *s, float *out) {
    if (!rsh_basis_ok(basis) || !rsh_order_ok(order)) return false;
    const float *const direction[3] = {s->x, s->y, s->z};
    const float *const value[3] = {s->r, s->b ? s->g : NULL, s->g ? s->b : NULL};
    rsh_kernels_best()->project(basis, order, s->count, direction, value, out);
    return true;
}

void rsh_accumulate(size_t count, size_t coefficients, const float *matrix, const float *r,
                    const float *g, const float *b, float *out) {
    const float *const value[3] = {r, b ? g : NULL, g ? b : NULL};
    rsh_kernels_best()->accumulate(count, coefficients, matrix, value, out);
}

bool rsh_dot3(int order, int a_channels, const float *a, const float *b, float out[3]) {
    if (!rsh_order_ok(order) || (a_channels != 1 && a_channels != 3)) return false;
    int n = order * order;
    rsh_kernels_best()->dot3(n, a_channels == 1 ? 0 : n, a, b, out);
    return true;
}
