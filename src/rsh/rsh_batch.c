// SPDX-License-Identifier: Apache-2.0
// Rotation of RSH_WIDTH records at once, a record per lane; one source for every instruction set.
// At width 1 it rotates a single record, for instruction sets that cannot permute lanes.
//
// No lanes are permuted here. Bands are rotated one after another, and three channels use the same
// angles and constants. A rotation about z costs four operations per pair (m, -m). The exchange of
// y and z costs one fused multiply-add per entry that does not vanish by parity. The series about y
// is in rsh_batch_series.h, and in rsh_batch_one.h for a single record.
#include "rsh/rsh_batch.h"

#include <stddef.h>
#include <stdint.h>

#include "rsh/rsh_batch_series.h"
#if RSH_WIDTH == 1
#include "rsh/rsh_batch_one.h"
#endif
#include "rsh/rsh_rotate_lanes.h"

// Pairs of rows that are summed at once, for three channels and for one, so that their sums stay in
// registers.
enum { SIZE = 2 * RSH_MAX_ORDER - 1 };
enum { PAIRS_OF_THREE = RSH_WIDTH == 16 ? 3 : 2, PAIRS_OF_ONE = 4 };

struct lane_rotations {
    struct band_powers alpha, beta, gamma;
};

// Loads the pair (m, -m) of all channels and rotates it about z.
INLINE void load_pair(struct band b, int channels, const struct band_powers *p, int m, vf *plus,
                      vf *minus) {
    vf cosine = p->cosine[m], sine = p->sine[m];
    for (int c = 0; c < channels; c++) {
        const float *in = b.p + c * b.channel;
        vf u = load(in + m * b.step), v = load(in - m * b.step);
        plus[c] = cosine * u - sine * v;
        minus[c] = sine * u + cosine * v;
    }
}

INLINE void store_pair(struct band b, int channels, const struct band_powers *p, int m,
                       const vf *plus, const vf *minus) {
    vf cosine = p->cosine[m], sine = p->sine[m];
    for (int c = 0; c < channels; c++) {
        float *out = b.p + c * b.channel;
        store(out + m * b.step, cosine * plus[c] - sine * minus[c]);
        store(out - m * b.step, sine * plus[c] + cosine * minus[c]);
    }
}

// The inputs of an exchange of y and z for rows of one sign and one parity: every second column of
// one sign, from the first one on.
struct exchange_input {
    const float *matrix;  // where the first entry of row 0 of the band would be
    const vf *in;         // the first coefficient; its channels are consecutive
    int columns;
};

// The exchange of all rows m of one parity, followed by a rotation about z.
struct batch_exchange {
    int l;
    struct exchange_input plus, minus;
    const struct band_powers *p;
    struct band out;
};

INLINE struct exchange_input exchange_input_of(int l, int channels, int m, const vf *in) {
    int size = 2 * l + 1, below = m < 0;
    bool negative = (l + m) & 1;
    int first = negative ? below : l + ((l + below) & 1), end = negative ? l : size;
    const float *matrix = rsh_swap + l * (2 * l - 1) * (2 * l + 1) / 3 + l * size;
    return (struct exchange_input){matrix + first, in + first * channels, (end - first + 1) / 2};
}

// Computes sum[r], row m + r step of the exchange. No row is empty for l > 0.
INLINE void exchange_rows(int rows, int channels, int l, const struct exchange_input *input, int m,
                          int step, vf (*sum)[CHANNELS]) {
    const ptrdiff_t size = 2 * l + 1, row = step * size;
    const float *matrix = input->matrix + m * size;
    const vf *in = input->in;
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < channels; c++) sum[r][c] = (vf){0};
    int left = input->columns;
    do {
        vf v[CHANNELS];
        for (int c = 0; c < channels; c++) {
            v[c] = in[c];
            if (rows > 1) RSH_KEEP(v[c]);
        }
        for (int r = 0; r < rows; r++) {
            vf f = splat(matrix[r * row]);
            for (int c = 0; c < channels; c++) sum[r][c] += f * v[c];
        }
        matrix += 2;
        in += 2 * channels;
    } while (--left > 0);
}

// Computes rows m, m + 2 ... of `pairs` pairs and rotates them about z.
INLINE void exchange_pairs(int pairs, int channels, const struct batch_exchange *e, int m) {
    vf plus[PAIRS_OF_ONE][CHANNELS], minus[PAIRS_OF_ONE][CHANNELS];
    exchange_rows(pairs, channels, e->l, &e->plus, m, 2, plus);
    exchange_rows(pairs, channels, e->l, &e->minus, -m, -2, minus);
    for (int r = 0; r < pairs; r++)
        store_pair(e->out, channels, e->p, m + 2 * r, plus[r], minus[r]);
}

// One function per shape: inlined into one function, they would leave too few registers.
#define BATCH_SHAPE(name, pairs, channels)                                                         \
    static __attribute__((noinline)) void exchange_##name(const struct batch_exchange *e, int m) { \
        exchange_pairs(pairs, channels, e, m);                                                     \
    }
BATCH_SHAPE(one_1, 1, 1)
BATCH_SHAPE(one_2, 2, 1)
BATCH_SHAPE(one_3, 3, 1)
BATCH_SHAPE(one_4, 4, 1)
BATCH_SHAPE(three_1, 1, 3)
BATCH_SHAPE(three_2, 2, 3)
BATCH_SHAPE(three_most, PAIRS_OF_THREE, 3)
#undef BATCH_SHAPE

INLINE void exchange_some(int pairs, int channels, const struct batch_exchange *e, int m) {
    if (pairs == 1)
        channels == 1 ? exchange_one_1(e, m) : exchange_three_1(e, m);
    else if (pairs == 2)
        channels == 1 ? exchange_one_2(e, m) : exchange_three_2(e, m);
    else if (channels > 1)
        exchange_three_most(e, m);
    else
        pairs == 3 ? exchange_one_3(e, m) : exchange_one_4(e, m);
}

// Exchanges y and z, then rotates about z.
INLINE void exchange(int l, int channels, const struct band_powers *p, const vf *in,
                     struct band out) {
    const int most = channels == 1 ? PAIRS_OF_ONE : PAIRS_OF_THREE;
    for (int first = 1; first >= 0; first--) {
        struct batch_exchange e = {l, exchange_input_of(l, channels, first, in),
                                   exchange_input_of(l, channels, -first, in), p, out};
        int m = first;
        if (m == 0) {
            vf row[1][CHANNELS];
            exchange_rows(1, channels, l, &e.plus, 0, 0, row);
            for (int c = 0; c < channels; c++) store(out.p + c * out.channel, row[0][c]);
            m = 2;
            e.minus = exchange_input_of(l, channels, -2, in);
        }
        while (m <= l) {
            int left = (l - m) / 2 + 1;
            // Rows beyond `most` are split into two equal runs, because a run of few sums waits for
            // latency.
            int pairs = left <= most ? left : left < 2 * most ? (left + 1) / 2 : most;
            exchange_some(pairs, channels, &e, m);
            m += 2 * pairs;
        }
    }
}

INLINE void exact_band(int l, int channels, const struct lane_rotations *t, struct band in,
                       struct band out) {
    vf v[SIZE * CHANNELS], u[SIZE * CHANNELS];
    for (int c = 0; c < channels; c++) v[l * channels + c] = load(in.p + c * in.channel);
    for (int m = 1; m <= l; m++)
        load_pair(in, channels, &t->gamma, m, v + (l + m) * channels, v + (l - m) * channels);
    struct band between = {(float *)(u + l * channels), channels * W, W};
    exchange(l, channels, &t->beta, v, between);
    exchange(l, channels, &t->alpha, u, out);
}

// A rotation of all lanes: `exact` if `offsets` is 0, otherwise `series`, with `offsets` as in
// series_band. `stride` is the distance of the coefficients of a vector.
struct batch_rotation {
    const struct lane_rotations *exact;
    const struct slants *series;
    int order;
    size_t stride;
};

INLINE void rotate_bands(int offsets, const struct batch_rotation *r, int channels, const float *in,
                         float *out) {
    const int order = r->order;
    ptrdiff_t step = (ptrdiff_t)r->stride, channel = order * order * step;
    for (int c = 0; c < channels; c++) store(out + c * channel, load(in + c * channel));
    for (int l = 1; l < order; l++) {
        // `in` is read but never written, so the cast is safe.
        const struct band from = {(float *)(uintptr_t)in + l * (l + 1) * step, step, channel};
        const struct band to = {out + l * (l + 1) * step, step, channel};
        if (offsets == 0)
            exact_band(l, channels, r->exact, from, to);
        else
            series_band(offsets, l, channels, r->series, from, to);
    }
}

INLINE void rotate_batch_channels(int offsets, const struct batch_rotation *r, int channels,
                                  const float *in, float *out) {
    const size_t n = (size_t)(r->order * r->order) * r->stride;
    for (; channels >= CHANNELS; channels -= CHANNELS, in += CHANNELS * n, out += CHANNELS * n)
        rotate_bands(offsets, r, CHANNELS, in, out);
    for (; channels > 0; channels--, in += n, out += n) rotate_bands(offsets, r, 1, in, out);
}

void GLUE(rsh_rotate_many_, RSH_NAME)(const struct rsh_rotations *angles, int order, int channels,
                                      size_t stride, const float *in, float *out) {
    if (angles->method != RSH_METHOD_EXACT) {
        struct slants s;
        const struct batch_rotation series = {NULL, &s, order, stride};
        if (angles->method == RSH_METHOD_TAYLOR_2) {
            slants_of(2, angles, order, &s);
            rotate_batch_channels(2, &series, channels, in, out);
        } else {
            slants_of(1, angles, order, &s);
            rotate_batch_channels(1, &series, channels, in, out);
        }
        return;
    }
    struct lane_rotations t;
    powers_of(angles->cos_gamma, angles->sin_gamma, order, &t.gamma);
    powers_of(angles->cos_alpha, angles->sin_alpha, order, &t.alpha);
    // The exchange reverses the sense: a rotation about y by beta is one about z by -beta between
    // two exchanges.
    powers_of(angles->cos_beta, angles->sin_beta, order, &t.beta);
    for (int m = 0; m < order; m++) t.beta.sine[m] = -t.beta.sine[m];
    const struct batch_rotation exact = {&t, NULL, order, stride};
    rotate_batch_channels(0, &exact, channels, in, out);
}

#if RSH_WIDTH == 1
void rsh_rotate_lanes_scalar(const struct rsh_rotation *t, int order, int channels, const float *in,
                             float *out) {
    if (t->method == RSH_METHOD_Z) {
        rsh_plain_rotate(t, order, channels, in, out);
        return;
    }
    const struct rsh_rotations one = {t->method,     {t->beta},     {t->cos_alpha}, {t->sin_alpha},
                                      {t->cos_beta}, {t->sin_beta}, {t->cos_gamma}, {t->sin_gamma}};
    if (t->method == RSH_METHOD_TAYLOR_1 || t->method == RSH_METHOD_TAYLOR_1_5) {
        struct slants s;
        slants_of(1, &one, order, &s);
        rotate_one(order, channels, &s, in, out);
        return;
    }
    rsh_rotate_many_scalar(&one, order, channels, 1, in, out);
}
#endif
