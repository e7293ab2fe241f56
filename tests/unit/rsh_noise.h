// SPDX-License-Identifier: Apache-2.0
// Random vectors and rotations, and values of functions, for the tests of the harmonics.
#ifndef RSH_NOISE_H
#define RSH_NOISE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "rsh/rsh.h"

enum { MAX = RSH_MAX_COEFFICIENTS };

static inline float noise(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 8388608.0f - 1.0f;
}

// A vector of unit length.
static inline void noise_unit(uint32_t *state, int n, float *v) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        v[i] = noise(state);
        sum += (double)v[i] * (double)v[i];
    }
    for (int i = 0; i < n; i++) v[i] /= (float)sqrt(sum);
}

static inline void noise_rotation(uint32_t *state, float r[9]) {
    float q[4];
    noise_unit(state, 4, q);
    float x = q[0], y = q[1], z = q[2], w = q[3];
    const float m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                        2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                        2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    memcpy(r, m, sizeof m);
}

static inline void rsh_noise_multiply(const float *a, const float *b, float *out) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

static inline void transpose(const float *a, float *out) {
    for (int i = 0; i < 9; i++) out[i] = a[i % 3 * 3 + i / 3];
}

static inline void rsh_noise_apply(const float *r, const float *w, float *out) {
    for (int i = 0; i < 3; i++)
        out[i] = r[3 * i] * w[0] + r[3 * i + 1] * w[1] + r[3 * i + 2] * w[2];
}

static inline double rsh_noise_value(rsh_basis basis, int order, const float *v, const float *w) {
    float y[MAX];
    double sum = 0.0;
    rsh_eval(basis, order, w, y);
    for (int i = 0; i < order * order; i++) sum += (double)v[i] * (double)y[i];
    return sum;
}

static inline double rsh_noise_distance(int n, const float *a, const float *b) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += ((double)a[i] - b[i]) * ((double)a[i] - b[i]);
    return sqrt(sum);
}

#endif
