// SPDX-License-Identifier: Apache-2.0
// The functions of the kernel table in plain C. They define each function, and the vector forms are
// tested against them.
#include <math.h>
#include <string.h>

#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

static void plain_eval_many(rsh_basis basis, int order, size_t count, const float *x,
                            const float *y, const float *z, float *out) {
    float h[RSH_MAX_COEFFICIENTS];
    for (size_t i = 0; i < count; i++) {
        rsh_eval(basis, order, (float[3]){x[i], y[i], z[i]}, h);
        for (int k = 0; k < order * order; k++) out[(size_t)k * count + i] = h[k];
    }
}

static void plain_accumulate(size_t count, size_t coefficients, const float *matrix,
                             const float *const value[3], float *out) {
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3 && value[c]; c++)
            for (size_t k = 0; k < coefficients; k++)
                out[c * coefficients + k] += matrix[i * coefficients + k] * value[c][i];
}

static void plain_project(rsh_basis basis, int order, size_t count, const float *const d[3],
                          const float *const value[3], float *out) {
    float h[RSH_MAX_COEFFICIENTS];
    for (size_t i = 0; i < count; i++) {
        const float *const one[3] = {value[0] + i, value[1] ? value[1] + i : NULL,
                                     value[2] ? value[2] + i : NULL};
        rsh_eval(basis, order, (float[3]){d[0][i], d[1][i], d[2][i]}, h);
        plain_accumulate(1, (size_t)(order * order), h, one, out);
    }
}

static void plain_dot3(int n, int step, const float *a, const float *b, float out[3]) {
    for (int c = 0; c < 3; c++) {
        float sum = 0.0f;
        for (int k = 0; k < n; k++) sum += a[c * step + k] * b[c * n + k];
        out[c] = sum;
    }
}

// Rotates about z: the pair (m, -m) rotates by m times the angle.
static void plain_rotate_z(int order, float cosine, float sine, float *v) {
    float c = 1.0f, s = 0.0f;
    for (int m = 1; m < order; m++) {
        float t = c * cosine - s * sine;
        s = c * sine + s * cosine;
        c = t;
        for (int l = m; l < order; l++) {
            float *plus = v + l * (l + 1) + m, *minus = v + l * (l + 1) - m, p = *plus;
            *plus = c * p - s * *minus;
            *minus = s * p + c * *minus;
        }
    }
}

// Exchanges y and z, which keeps the parity in x and exchanges the parities in y (m < 0) and z
// (l + m). So row a has entries only in every second column of one sign.
static void plain_exchange(int order, float *v) {
    const float *matrix = rsh_swap;
    for (int l = 0; l < order; l++) {
        float in[2 * RSH_MAX_ORDER - 1];
        int size = 2 * l + 1;
        memcpy(in, v + l * l, (size_t)size * sizeof *in);
        for (int a = -l; a <= l; a++, matrix += size) {
            bool negative = (l + a) & 1;
            int first = negative ? (a < 0) : l + ((l + (a < 0)) & 1), end = negative ? l : size;
            float sum = 0.0f;
            for (int b = first; b < end; b += 2) sum += matrix[b] * in[b];
            v[l * l + a + l] = sum;
        }
    }
}

// Rotates about y by the series I + beta D + beta^2 / 2 times nothing, the diagonal of D^2, or D^2.
static void rotate_taylor(enum rsh_method method, float beta, int n, float *v) {
    float d1[RSH_MAX_COEFFICIENTS], d2[RSH_MAX_COEFFICIENTS] = {0};
    const float *s = rsh_slope;
    for (int i = 0; i < n; i++)
        d1[i] = (i > 0 ? s[i] * v[i - 1] : 0.0f) - (i + 1 < n ? s[i + 1] * v[i + 1] : 0.0f);
    for (int i = 0; i < n && method == RSH_METHOD_TAYLOR_1_5; i++)
        d2[i] = rsh_d2_diagonal[i] * v[i];
    for (int i = 0; i < n && method == RSH_METHOD_TAYLOR_2; i++)
        d2[i] = (i > 0 ? s[i] * d1[i - 1] : 0.0f) - (i + 1 < n ? s[i + 1] * d1[i + 1] : 0.0f);
    for (int i = 0; i < n; i++) v[i] += beta * d1[i] + 0.5f * beta * beta * d2[i];
}

void rsh_plain_rotate(const struct rsh_rotation *t, int order, int channels, const float *in,
                      float *out) {
    int n = order * order;
    for (int channel = 0; channel < channels; channel++, in += n, out += n) {
        float v[RSH_MAX_COEFFICIENTS];
        memcpy(v, in, (size_t)n * sizeof *v);
        plain_rotate_z(order, t->cos_gamma, t->sin_gamma, v);
        if (t->method == RSH_METHOD_EXACT) {
            // The exchange reverses the sense: a rotation about y by beta is one about z by -beta
            // between two exchanges.
            plain_exchange(order, v);
            plain_rotate_z(order, t->cos_beta, -t->sin_beta, v);
            plain_exchange(order, v);
        } else if (t->method != RSH_METHOD_Z) {
            rotate_taylor(t->method, t->beta, n, v);
        }
        if (t->method != RSH_METHOD_Z) plain_rotate_z(order, t->cos_alpha, t->sin_alpha, v);
        memcpy(out, v, (size_t)n * sizeof *v);
    }
}

void rsh_plain_convert(const struct rsh_rows *rows, bool transposed, const int bands[2],
                       const float *in, float *out) {
    for (int o = 0; o < bands[0]; o++)
        for (int m = 0; m <= o; m++) {
            float plus = 0.0f, minus = 0.0f;
            for (int i = m; i < bands[1]; i++) {
                int a = transposed ? i : o, b = transposed ? o : i;
                float f = m < 8 ? rows->low[(a * rows->inputs + b) * 8 + m]
                                : rows->high[((a - 8) * (rows->inputs - 8) + b - 8) * 8 + m - 8];
                plus += f * in[i * (i + 1) + m];
                minus += f * in[i * (i + 1) - m];
            }
            out[o * (o + 1) - m] = minus;
            out[o * (o + 1) + m] = plus;
        }
}

static void plain_angles(const float r[9][RSH_MAX_WIDTH], bool stretch, struct rsh_rotations *t) {
    float one[9];
    for (int e = 0; e < 9; e++) one[e] = r[e][0];
    struct rsh_rotation rotation = rsh_rotation_of_matrix(one);
    if (stretch) rsh_rotation_stretch(&rotation);
    t->beta[0] = atan2f(rotation.sin_beta, rotation.cos_beta);
    t->cos_alpha[0] = rotation.cos_alpha, t->sin_alpha[0] = rotation.sin_alpha;
    t->cos_beta[0] = rotation.cos_beta, t->sin_beta[0] = rotation.sin_beta;
    t->cos_gamma[0] = rotation.cos_gamma, t->sin_gamma[0] = rotation.sin_gamma;
}

static void plain_rotate_many(const struct rsh_rotations *t, int order, int channels, size_t stride,
                              const float *in, float *out) {
    const struct rsh_rotation rotation = {t->method,       t->beta[0],     t->cos_alpha[0],
                                          t->sin_alpha[0], t->cos_beta[0], t->sin_beta[0],
                                          t->cos_gamma[0], t->sin_gamma[0]};
    size_t n = (size_t)(order * order);
    for (int c = 0; c < channels; c++, in += n * stride, out += n * stride) {
        float v[RSH_MAX_COEFFICIENTS];
        for (size_t k = 0; k < n; k++) v[k] = in[k * stride];
        rsh_plain_rotate(&rotation, order, 1, v, v);
        for (size_t k = 0; k < n; k++) out[k * stride] = v[k];
    }
}

static void plain_convert_many(const struct rsh_rows *rows, bool transposed, const int bands[2],
                               const size_t strides[2], const float *in, float *out) {
    float from[RSH_MAX_COEFFICIENTS], to[RSH_MAX_COEFFICIENTS];
    for (int k = 0; k < bands[1] * bands[1]; k++) from[k] = in[(size_t)k * strides[1]];
    rsh_plain_convert(rows, transposed, bands, from, to);
    for (int k = 0; k < bands[0] * bands[0]; k++) out[(size_t)k * strides[0]] = to[k];
}

const struct rsh_kernels rsh_kernels_plain = {
    .name = "plain",
    .eval_many = plain_eval_many,
    .project = plain_project,
    .accumulate = plain_accumulate,
    .dot3 = plain_dot3,
    .rotate = rsh_plain_rotate,
    .convert = rsh_plain_convert,
    .width = 1,
    .angles = plain_angles,
    .rotate_many = plain_rotate_many,
    .convert_many = plain_convert_many,
};
