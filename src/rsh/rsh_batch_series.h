// SPDX-License-Identifier: Apache-2.0
// The rotation of many records by the series about y, a record per lane.
//
// A rotation about z by a maps (p, q) of (m, -m) to c (p - t q, q + t p), with c and t the cosine
// and the tangent of m a. The cosines of both rotations are multiplied into the factors of the
// series between them, so that a rotation costs one multiply-add per coefficient and the series
// three. A cosine of 0 is replaced by a tiny one: the large tangent is multiplied by it again.
#ifndef RSH_BATCH_SERIES_H
#define RSH_BATCH_SERIES_H

#include <stddef.h>

#include "rsh/rsh_batch_band.h"
#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

// Tangents, and the factors of m, m -+ 1 and m -+ 2 in coefficient m of the result, without the
// entries of the series' matrices: beta^k / k! times the cosine of the input's multiple of gamma
// and of m alpha.
struct slants {
    vf gamma[RSH_MAX_ORDER], alpha[RSH_MAX_ORDER], own[RSH_MAX_ORDER], d2_diagonal[RSH_MAX_ORDER];
    vf down[RSH_MAX_ORDER], up[RSH_MAX_ORDER], down2[RSH_MAX_ORDER], up2[RSH_MAX_ORDER];
};

// Far below the rounding of 1, while its inverse is far from overflow.
#define NO_COSINE 1e-12f

// cos(m a) and sin(m a).
struct lane_angle {
    vf c, s;
};

INLINE struct lane_angle add_lane_angles(struct lane_angle a, struct lane_angle b) {
    return (struct lane_angle){a.c * b.c - a.s * b.s, a.c * b.s + a.s * b.c};
}

INLINE void slants_of(int offsets, const struct rsh_rotations *t, int order, struct slants *s) {
    const vf beta = load(t->beta), zero = {0};
    const vf half = t->method == RSH_METHOD_TAYLOR_1 ? zero : 0.5f * beta * beta;
    const struct lane_angle none = {splat(1.0f), zero};
    const struct lane_angle alpha1 = {load(t->cos_alpha), load(t->sin_alpha)};
    const struct lane_angle gamma1 = {load(t->cos_gamma), load(t->sin_gamma)};
    // Gamma is ahead of alpha: sines of m .. m + 2 and cosines of m - 2 .. m + 2 are needed.
    struct lane_angle alpha = none, gamma = add_lane_angles(gamma1, gamma1);
    vf c[5] = {zero, zero, none.c, lanes_at_least(gamma1.c, NO_COSINE),
               lanes_at_least(gamma.c, NO_COSINE)};
    vf sine[3] = {zero, gamma1.s, gamma.s};
    for (int m = 0; m < order; m++) {
        const vf to = lanes_at_least(alpha.c, NO_COSINE), both = c[2] * to, inverse = 1.0f / both;
        const vf tilt = beta * to, half_square = half * to;
        s->gamma[m] = sine[0] * (to * inverse);
        s->alpha[m] = alpha.s * (c[2] * inverse);
        s->own[m] = both;
        s->d2_diagonal[m] = half_square * c[2];
        s->down[m] = tilt * c[1];
        s->up[m] = tilt * c[3];
        if (offsets == 2) {
            s->down2[m] = half_square * c[0];
            s->up2[m] = half_square * c[4];
        }
        alpha = add_lane_angles(alpha, alpha1);
        gamma = add_lane_angles(gamma, gamma1);
        for (int k = 0; k < 4; k++) c[k] = c[k + 1];
        c[4] = lanes_at_least(gamma.c, NO_COSINE);
        sine[0] = sine[1], sine[1] = sine[2], sine[2] = gamma.s;
    }
}

// Loads the pair (m, -m) of all channels, rotated by gamma except for the cosine.
INLINE void load_slanted(struct band b, int channels, vf tangent, int m, vf *plus, vf *minus) {
    for (int c = 0; c < channels; c++) {
        const float *in = b.p + c * b.channel;
        vf u = load(in + m * b.step), v = load(in - m * b.step);
        plus[c] = u - tangent * v;
        minus[c] = v + tangent * u;
    }
}

INLINE void store_slanted(struct band b, int channels, vf tangent, int m, const vf *plus,
                          const vf *minus) {
    for (int c = 0; c < channels; c++) {
        float *out = b.p + c * b.channel;
        store(out + m * b.step, plus[c] - tangent * minus[c]);
        store(out - m * b.step, minus[c] + tangent * plus[c]);
    }
}

// The factors of row m for its own coefficient and its neighbours. D is antisymmetric and D(-m, -m
// - 1) = -D(m + 1, m), so row -m has the factors of row m. Its window has 0 where it would include
// m = 0.
struct factors {
    vf own, down, up, down2, up2;
};

// `offsets` is 1 without and 2 with the second-order entries two off the diagonal.
INLINE struct factors factors_of(int offsets, int l, int m, const struct slants *s) {
    const float *slope = rsh_slope + l * (l + 1) + m;
    // Beyond l the slope is 0; the table has that of the next band there.
    const float up = m < l ? slope[1] : 0.0f;
    struct factors f = {.own = s->own[m] + rsh_d2_diagonal[l * (l + 1) + m] * s->d2_diagonal[m]};
    f.down = m > 0 ? slope[0] * s->down[m] : (vf){0};
    f.up = up * s->up[m];
    if (offsets == 2) {
        f.down2 = m > 1 ? slope[0] * slope[-1] * s->down2[m] : (vf){0};
        f.up2 = (m + 1 < l ? up * slope[2] : 0.0f) * s->up2[m];
    }
    return f;
}

// at[2] is coefficient m.
INLINE void series_row(int offsets, int channels, const struct factors *f, vf (*at)[CHANNELS],
                       vf *out) {
    for (int c = 0; c < channels; c++) {
        out[c] = f->own * at[2][c] + f->down * at[1][c] - f->up * at[3][c];
        if (offsets == 2) out[c] += f->down2 * at[0][c] + f->up2 * at[4][c];
    }
}

// Moves a window of five coefficients of each sign along the band.
INLINE void series_band(int offsets, int l, int channels, const struct slants *s, struct band in,
                        struct band out) {
    vf plus[5][CHANNELS], minus[5][CHANNELS], a[CHANNELS], b[CHANNELS];
    for (int k = 0; k < 5; k++)
        for (int c = 0; c < channels; c++) plus[k][c] = minus[k][c] = (vf){0};
    for (int c = 0; c < channels; c++) plus[2][c] = load(in.p + c * in.channel);
    for (int m = 1; m <= offsets && m <= l; m++)
        load_slanted(in, channels, s->gamma[m], m, plus[2 + m], minus[2 + m]);
    for (int m = 0; m <= l; m++) {
        struct factors f = factors_of(offsets, l, m, s);
        series_row(offsets, channels, &f, plus, a);
        if (m == 0) {
            for (int c = 0; c < channels; c++) store(out.p + c * out.channel, a[c]);
        } else {
            if (m == 1) f.own = s->own[1] + rsh_d2_diagonal[l * (l + 1) - 1] * s->d2_diagonal[1];
            series_row(offsets, channels, &f, minus, b);
            store_slanted(out, channels, s->alpha[m], m, a, b);
        }
        for (int k = 0; k < 2 + offsets; k++)
            for (int c = 0; c < channels; c++) {
                plus[k][c] = plus[k + 1][c];
                minus[k][c] = minus[k + 1][c];
            }
        if (m + 1 + offsets <= l)
            load_slanted(in, channels, s->gamma[m + 1 + offsets], m + 1 + offsets,
                         plus[2 + offsets], minus[2 + offsets]);
    }
}

#endif
