// SPDX-License-Identifier: Apache-2.0
// Rotation on lanes, one source for AVX2 and AVX-512: the build defines RSH_NAME, the suffix.
// rsh_tables.h describes the layout. A group of bands is loaded, turned about z, y and z, and
// stored; what depends on the angles only is computed once for all channels.
#include "rsh/rsh_turn.h"

#include "rsh/rsh_lanes.h"
#include "rsh/rsh_tables.h"

#define GLUE2(a, b) a##b
#define GLUE(a, b) GLUE2(a, b)
#define INLINE static inline __attribute__((always_inline))

struct angle {
    lanes cosine, sine;
};

// Cosines and sines of m times an angle for m = 0 2 4 .. 14 1 3 .. 15: the even ones by doubling.
INLINE struct angle multiples(float c1, float s1) {
    float c[16], s[16], ck = c1 * c1 - s1 * s1, sk = 2.0f * c1 * s1;
    c[0] = 1.0f;
    s[0] = 0.0f;
    for (int k = 1; k < 8; k *= 2) {
        for (int i = 0; i < k; i++) {
            c[k + i] = c[i] * ck - s[i] * sk;
            s[k + i] = c[i] * sk + s[i] * ck;
        }
        float t = ck * ck - sk * sk;
        sk = 2.0f * ck * sk;
        ck = t;
    }
    for (int i = 0; i < 8; i++) {
        c[8 + i] = c[i] * c1 - s[i] * s1;
        s[8 + i] = c[i] * s1 + s[i] * c1;
    }
    return (struct angle){lanes_load(c), lanes_load(s)};
}

// (a, b) turned by the angle.
INLINE void turn_pair(struct angle t, lanes *a, lanes *b) {
    lanes p = *a, q = *b;
    *a = lanes_nmad(t.sine, q, lanes_mul(t.cosine, p));
    *b = lanes_mad(t.sine, p, lanes_mul(t.cosine, q));
}

// Exchanges y and z of the parts even and odd in x; direction 0 leads to the inner layout, 1 back.
INLINE void exchange(const struct rsh_lane_group *g, int direction, lanes *even, lanes *odd) {
    const struct rsh_lane_step *step = rsh_lane_steps + g->offset;
    lanes a = lanes_zero(), b = lanes_zero();
    for (int i = 0; i < g->steps; i++, step++) {
        lanes from_even = lanes_within(*even, step->source[direction][0]);
        lanes from_odd = lanes_across(*odd, step->source[direction][1]);
        a = lanes_mad(from_even, lanes_load(step->factor[direction][0]), a);
        b = lanes_mad(from_odd, lanes_load(step->factor[direction][1]), b);
    }
    *even = a;
    *odd = b;
}

// D, the derivative of the rotation about y, applied to plus (0) or minus (1).
INLINE lanes derivative(const struct rsh_lane_group *g, int part, lanes v) {
    lanes down = lanes_mul(lanes_across(v, g->down), lanes_load(g->from_down[part]));
    return lanes_mad(lanes_across(v, g->up), lanes_load(g->from_up[part]), down);
}

INLINE lanes series(const struct rsh_lane_group *g, const struct rsh_turn *t, int part, lanes v) {
    lanes first = derivative(g, part, v), beta = lanes_splat(t->beta), rest = first;
    if (t->method != RSH_METHOD_TAYLOR_1) {
        lanes second = t->method == RSH_METHOD_TAYLOR_2 ? derivative(g, part, first)
                                                        : lanes_mul(v, lanes_load(g->curve[part]));
        rest = lanes_mad(lanes_splat(0.5f * t->beta), second, first);
    }
    return lanes_mad(beta, rest, v);
}

struct multiples {
    struct angle alpha, beta, gamma;
};

INLINE struct angle place(const struct angle *a, const int32_t *power) {
    return (struct angle){lanes_within(a->cosine, power), lanes_within(a->sine, power)};
}

INLINE void turn_group(const struct rsh_lane_group *g, const struct rsh_turn *t,
                       const struct multiples *multiples, int channels, int n, const float *in,
                       float *out) {
    int count = n - g->first < 32 ? n - g->first : 32;
    if (g + 1 < rsh_lane_groups + RSH_LANE_GROUPS && g[1].first - g->first < count)
        count = g[1].first - g->first;
    struct angle gamma = place(&multiples->gamma, g->power[0]), alpha = gamma, beta = gamma;
    if (t->method != RSH_METHOD_Z) alpha = place(&multiples->alpha, g->power[0]);
    if (t->method == RSH_METHOD_EXACT)
        beta = (struct angle){lanes_any(multiples->beta.cosine, g->power[1]),
                              lanes_any(multiples->beta.sine, g->power[1])};
    for (int channel = 0; channel < channels; channel++) {
        int at = channel * n + g->first;
        struct lanes_source source = lanes_source(in + at, count);
        lanes plus = lanes_gather(source, g->plus), minus = lanes_gather(source, g->minus);
        turn_pair(gamma, &plus, &minus);
        if (t->method == RSH_METHOD_EXACT) {
            lanes even = lanes_halves(plus, minus), odd = lanes_halves(minus, plus);
            exchange(g, 0, &even, &odd);
            turn_pair(beta, &even, &odd);
            exchange(g, 1, &even, &odd);
            plus = lanes_halves(even, odd);
            minus = lanes_halves(odd, even);
        } else if (t->method != RSH_METHOD_Z) {
            plus = series(g, t, 0, plus);
            minus = series(g, t, 1, minus);
        }
        if (t->method != RSH_METHOD_Z) turn_pair(alpha, &plus, &minus);
        lanes_scatter(plus, minus, g->natural, count, out + at);
    }
}

INLINE void turn_groups(const struct rsh_turn *t, const struct multiples *multiples, int order,
                        int channels, const float *in, float *out) {
    int n = order * order;
    for (int g = 0; g < RSH_LANE_GROUPS && rsh_lane_groups[g].first < n; g++)
        turn_group(rsh_lane_groups + g, t, multiples, channels, n, in, out);
}

void GLUE(rsh_turn_, RSH_NAME)(const struct rsh_turn *t, int order, int channels, const float *in,
                               float *out) {
    struct multiples m;
    m.alpha = m.beta = m.gamma = multiples(t->cos_gamma, t->sin_gamma);
    if (t->method != RSH_METHOD_Z) m.alpha = multiples(t->cos_alpha, t->sin_alpha);
    if (t->method == RSH_METHOD_EXACT) {
        // Y by beta is z by -beta between the exchanges, and a pair (even, odd) is (plus, minus)
        // for even m and (minus, plus), which turns the other way, for odd m.
        m.beta = multiples(t->cos_beta, -t->sin_beta);
        lanes back = lanes_mul(m.beta.sine, lanes_splat(-1.0f));
        m.beta.sine = lanes_halves(m.beta.sine, back);
    }
    if (channels == 1)
        turn_groups(t, &m, order, 1, in, out);
    else if (channels == 3)
        turn_groups(t, &m, order, 3, in, out);
    else
        turn_groups(t, &m, order, channels, in, out);
}
