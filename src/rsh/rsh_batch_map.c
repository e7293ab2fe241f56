// SPDX-License-Identifier: Apache-2.0
// Steps before and after the rotation of many records, a record per lane: the angles of their
// matrices, and the conversion between hemisphere and sphere.
#include <math.h>
#include <stddef.h>

#include "rsh/rsh_batch.h"
#include "rsh/rsh_vector.h"

#define PI_SINGLE 3.14159265f

// Selections below are between values and never jumps, so that loops over lanes are vectorised.
INLINE float select_if(bool yes, float a, float b) { return yes ? a : b; }

// atan2(s, c) for s, c >= 0 with s^2 + c^2 = 1: the series of 8 atan(tan(angle / 8)), whose
// argument is at most .2. The first omitted term is below the rounding of floats.
INLINE float angle_of(float s, float c) {
    float half = s / (1.0f + c), quarter = half / (1.0f + sqrtf(1.0f + half * half));
    float t = quarter / (1.0f + sqrtf(1.0f + quarter * quarter)), u = t * t;
    float sum = 1.0f / 7.0f - u * (1.0f / 9.0f);
    sum = 1.0f / 5.0f - u * sum;
    sum = 1.0f / 3.0f - u * sum;
    return 8.0f * t * (1.0f - u * sum);
}

// Square roots and divisions take most of the time. Those that small angles or exact rotations do
// not need are left out if no lane needs them, which does not change the result of any lane.

// Does what rsh_rotation_angle does. Above 90 degrees the supplement is computed, which is accurate
// even if the cosine is nearly or exactly -1.
INLINE void angles_of(const float s[W], const float c[W], float angle[W]) {
    int large = 0;
    for (int i = 0; i < W; i++) {
        float u = s[i] * s[i], sum = 15.0f / 336.0f + u * (105.0f / 3456.0f);
        angle[i] = s[i] + s[i] * u * (1.0f / 6.0f + u * (3.0f / 40.0f + u * sum));
        large |= u >= 0.09f;
    }
    for (int i = 0; i < W && large; i++)
        angle[i] = select_if(s[i] * s[i] >= 0.09f, angle_of(s[i], fabsf(c[i])), angle[i]);
    for (int i = 0; i < W; i++) angle[i] = select_if(c[i] < 0.0f, PI_SINGLE - angle[i], angle[i]);
}

// 1 / sqrt(x), or 0 for 0. Near 1 by a step of Newton's iteration, as in rsh_rotation_of_matrix.
INLINE void inverse_lengths(const float x[W], float inverse[W]) {
    int far = 0;
    for (int i = 0; i < W; i++) {
        inverse[i] = 1.5f - 0.5f * x[i];
        far |= !(fabsf(x[i] - 1.0f) < 1e-3f);
    }
    for (int i = 0; i < W && far; i++) {
        float root = select_if(x[i] > 0.0f, 1.0f / sqrtf(select_if(x[i] > 0.0f, x[i], 1.0f)), 0.0f);
        inverse[i] = select_if(fabsf(x[i] - 1.0f) < 1e-3f, inverse[i], root);
    }
}

// Does what rsh_rotation_stretch does.
INLINE void stretch_angles(float cosine[W], float sine[W]) {
    for (int i = 0; i < W; i++) {
        float above = select_if(cosine[i] > 0.0f, cosine[i], 0.0f),
              lift = 2.0f * sine[i] * sine[i] / (1.0f + above);
        lift = select_if(cosine[i] > 0.0f && lift < 2.0f, lift, 2.0f);
        cosine[i] = 1.0f - lift;
        sine[i] = sqrtf(2.0f * above * lift);
    }
}

// Does what rsh_rotation_of_matrix does, from the same entries, but alpha is from column y of r
// R_z(-gamma). If there is no rotation about y, or one by 180 degrees, alpha is 0 and gamma has the
// whole angle. The series depends on which of the two has it.
void GLUE(rsh_angles_, RSH_NAME)(const float r[9][RSH_MAX_WIDTH], bool stretch,
                                 struct rsh_rotations *t) {
    float ca[W], sa[W], cb[W], sb[W], cg[W], sg[W], beta[W], square[W], unit[W], length[W];
    for (int i = 0; i < W; i++) {
        float s2 = r[6][i] * r[6][i] + r[7][i] * r[7][i], s = sqrtf(s2);
        square[i] = s2 + r[8][i] * r[8][i];
        s = select_if(s > RSH_NO_ANGLE, s, 0.0f);
        float inverse = 1.0f / select_if(s > 0.0f, s, 1.0f);
        cg[i] = select_if(s > 0.0f, -r[6][i] * inverse, 1.0f);
        sg[i] = select_if(s > 0.0f, r[7][i] * inverse, 0.0f);
        sb[i] = s;
        sa[i] = -(sg[i] * r[0][i] + cg[i] * r[1][i]);
        ca[i] = sg[i] * r[3][i] + cg[i] * r[4][i];
        length[i] = sa[i] * sa[i] + ca[i] * ca[i];
    }
    inverse_lengths(square, unit);
    for (int i = 0; i < W; i++) {
        cb[i] = select_if(sb[i] > 0.0f, r[8][i] * unit[i], copysignf(1.0f, r[8][i]));
        sb[i] *= unit[i];
    }
    inverse_lengths(length, unit);
    for (int i = 0; i < W; i++) {
        sa[i] *= unit[i];
        ca[i] = select_if(length[i] > 0.0f, ca[i] * unit[i], 1.0f);
        // R_z(alpha) R_y(180 degrees) = R_y(180 degrees) R_z(-alpha).
        cg[i] = select_if(sb[i] > 0.0f, cg[i], ca[i]);
        sg[i] = select_if(sb[i] > 0.0f, sg[i], cb[i] * sa[i]);
        ca[i] = select_if(sb[i] > 0.0f, ca[i], 1.0f);
        sa[i] = select_if(sb[i] > 0.0f, sa[i], 0.0f);
    }
    if (stretch) stretch_angles(cb, sb);
    angles_of(sb, cb, beta);
    memcpy(t->cos_alpha, ca, sizeof ca);
    memcpy(t->sin_alpha, sa, sizeof sa);
    memcpy(t->cos_beta, cb, sizeof cb);
    memcpy(t->sin_beta, sb, sizeof sb);
    memcpy(t->cos_gamma, cg, sizeof cg);
    memcpy(t->sin_gamma, sg, sizeof sg);
    memcpy(t->beta, beta, sizeof beta);
}

// The rows (o, +-m) of a conversion, for outputs o and inputs i from m on.
struct row_map {
    const float *factor;  // the factor of output and input m
    ptrdiff_t output, input;
    int m, inputs;
    const float *in;  // coefficient 0
    float *out;
    ptrdiff_t in_stride, out_stride;
};

// Outputs o .. o + block - 1, computed together because they load the same inputs.
INLINE void convert_map_rows(int block, const struct row_map *a, int o) {
    vf plus[4], minus[4];
    for (int k = 0; k < block; k++) plus[k] = minus[k] = (vf){0};
    const float *f = a->factor + (o - a->m) * a->output;
    int i = a->m;
    do {
        const float *in = a->in + i * (i + 1) * a->in_stride;
        vf p = load(in + a->m * a->in_stride), q = load(in - a->m * a->in_stride);
        RSH_KEEP(p);
        RSH_KEEP(q);
        for (int k = 0; k < block; k++) {
            vf v = splat(f[k * a->output]);
            plus[k] += v * p;
            minus[k] += v * q;
        }
        f += a->input;
    } while (++i < a->inputs);
    for (int k = 0; k < block; k++) {
        float *out = a->out + (o + k) * (o + k + 1) * a->out_stride;
        store(out - a->m * a->out_stride, minus[k]);
        store(out + a->m * a->out_stride, plus[k]);
    }
}

static void clear_rows(const struct row_map *a, int outputs) {
    for (int o = a->m; o < outputs; o++) {
        float *out = a->out + o * (o + 1) * a->out_stride;
        store(out - a->m * a->out_stride, (vf){0});
        store(out + a->m * a->out_stride, (vf){0});
    }
}

void GLUE(rsh_convert_many_, RSH_NAME)(const struct rsh_rows *rows, bool transposed,
                                       const int bands[2], const size_t strides[2], const float *in,
                                       float *out) {
    struct row_map a = {.inputs = bands[1], .in = in, .out = out};
    a.out_stride = (ptrdiff_t)strides[0];
    a.in_stride = (ptrdiff_t)strides[1];
    for (a.m = 0; a.m < bands[0]; a.m++) {
        if (a.m >= bands[1]) {
            clear_rows(&a, bands[0]);
            continue;
        }
        int base = a.m < 8 ? 0 : 8, row = (rows->inputs - base) * 8;
        a.factor = (a.m < 8 ? rows->low : rows->high) + (a.m - base) * (row + 8) + a.m % 8;
        a.output = transposed ? 8 : row;
        a.input = transposed ? row : 8;
        int o = a.m;
        for (; o + 4 <= bands[0]; o += 4) convert_map_rows(4, &a, o);
        if (o + 3 == bands[0]) convert_map_rows(3, &a, o);
        if (o + 2 == bands[0]) convert_map_rows(2, &a, o);
        if (o + 1 == bands[0]) convert_map_rows(1, &a, o);
    }
}
