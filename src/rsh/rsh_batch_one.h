// SPDX-License-Identifier: Apache-2.0
// The series about y for one record, in scalars: rsh_batch_series.h for instruction sets that
// cannot permute lanes. The time is limited by the number of instructions, not by arithmetic.
// Therefore every band is an unrolled function of its own, in which moving the window along the
// band and the zeros at its ends cost nothing. Channels are processed one after another, so that
// the window stays in registers.
#ifndef RSH_BATCH_ONE_H
#define RSH_BATCH_ONE_H

#include "rsh/rsh_batch_series.h"

// Does what load_slanted does.
INLINE void load_one(const float *in, const vf *tangent, int m, vf *plus, vf *minus) {
    const vf u = load(in + m), v = load(in - m);
    *plus = u - tangent[m] * v;
    *minus = v + tangent[m] * u;
}

// Does what series_row does with offsets 1. at[1] is the coefficient; neighbours that are 0 are
// left out.
INLINE vf one_row(bool down, bool up, const struct factors *f, vf own, const vf at[3]) {
    vf sum = own * at[1];
    if (down) sum += f->down * at[0];
    if (up) sum -= f->up * at[2];
    return sum;
}

// Does what series_band does with offsets 1. `in` and `out` point to coefficient (l, 0) of the
// first of `channels`; channels are `n` coefficients apart.
INLINE void one_band(int l, int channels, int n, const struct slants *s, const float *in,
                     float *out) {
    struct factors f[RSH_MAX_ORDER];
#pragma GCC unroll 16
    for (int m = 0; m <= l; m++) f[m] = factors_of(1, l, m, s);
    const vf own = s->own[1] + rsh_d2_diagonal[l * (l + 1) - 1] * s->d2_diagonal[1];
    for (; channels > 0; channels--, in += n, out += n) {
        vf plus[3], minus[3];
        plus[1] = load(in), minus[1] = (vf){0};
        load_one(in, s->gamma, 1, plus + 2, minus + 2);
        store(out, one_row(false, true, f, f->own, plus));
#pragma GCC unroll 16
        for (int m = 1; m <= l; m++) {
            plus[0] = plus[1], plus[1] = plus[2];
            minus[0] = minus[1], minus[1] = minus[2];
            if (m < l) load_one(in, s->gamma, m + 1, plus + 2, minus + 2);
            const bool first = m == 1, last = m == l;
            const vf a = one_row(true, !last, f + m, f[m].own, plus);
            const vf b = one_row(!first, !last, f + m, first ? own : f[m].own, minus);
            store(out + m, a - s->alpha[m] * b);
            store(out - m, b + s->alpha[m] * a);
        }
    }
}

#define ONE_BAND(l)                                                                        \
    static void one_band_##l(int channels, int n, const struct slants *s, const float *in, \
                             float *out) {                                                 \
        one_band(l, channels, n, s, in, out);                                              \
    }
ONE_BAND(1)
ONE_BAND(2)
ONE_BAND(3)
ONE_BAND(4)
ONE_BAND(5)
ONE_BAND(6)
ONE_BAND(7)
ONE_BAND(8)
ONE_BAND(9)
ONE_BAND(10)
ONE_BAND(11)
ONE_BAND(12)
ONE_BAND(13)
ONE_BAND(14)
ONE_BAND(15)
#undef ONE_BAND

// All channels of a record.
INLINE void rotate_one(int order, int channels, const struct slants *s, const float *in,
                       float *out) {
    static void (*const bands[RSH_MAX_ORDER])(int channels, int n, const struct slants *s,
                                              const float *in, float *out) = {
        NULL,        one_band_1,  one_band_2,  one_band_3, one_band_4,  one_band_5,
        one_band_6,  one_band_7,  one_band_8,  one_band_9, one_band_10, one_band_11,
        one_band_12, one_band_13, one_band_14, one_band_15};
    const int n = order * order;
    for (int c = 0; c < channels; c++) out[c * n] = in[c * n];
    for (int l = 1; l < order; l++) bands[l](channels, n, s, in + l * (l + 1), out + l * (l + 1));
}

#endif
