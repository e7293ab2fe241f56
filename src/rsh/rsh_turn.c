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

// Channels turned at once: what the registers hold. They share the loads of the tables.
#if defined(__AVX512F__)
enum { BLOCK = 3 };
#else
enum { BLOCK = 1 };
#endif

struct angle {
    lanes cosine, sine;
};

INLINE struct angle add_angles(struct angle a, struct angle b) {
    return (struct angle){
        lanes_nmad(a.sine, b.sine, lanes_mul(a.cosine, b.cosine)),
        lanes_mad(a.sine, b.cosine, lanes_mul(a.cosine, b.sine)),
    };
}

#define ANGLE_IN(mask, c, s) \
    ((struct angle){lanes_choose(mask, c, 1.0f), lanes_choose(mask, s, 0.0f)})

// Cosines and sines of m times an angle for m = 0 2 4 .. 14 1 3 .. 15: lane by lane the sum of the
// angle's multiples by 1, 2, 4 and 8 that make up m.
INLINE struct angle multiples(float c1, float s1) {
    float c2 = c1 * c1 - s1 * s1, s2 = 2.0f * c1 * s1;
    float c4 = c2 * c2 - s2 * s2, s4 = 2.0f * c2 * s2;
    float c8 = c4 * c4 - s4 * s4, s8 = 2.0f * c4 * s4;
    struct angle low = add_angles(ANGLE_IN(0xff00, c1, s1), ANGLE_IN(0xaaaa, c2, s2));
    return add_angles(low, add_angles(ANGLE_IN(0xcccc, c4, s4), ANGLE_IN(0xf0f0, c8, s8)));
}

// (a, b) turned by the angle.
INLINE void turn_pair(struct angle t, lanes *a, lanes *b) {
    lanes p = *a, q = *b;
    *a = lanes_nmad(t.sine, q, lanes_mul(t.cosine, p));
    *b = lanes_mad(t.sine, p, lanes_mul(t.cosine, q));
}

// Exchanges y and z of the parts even and odd in x, of `block` channels at once; direction 0 leads
// to the inner layout, 1 back.
INLINE void exchange(const struct rsh_lane_group *g, int direction, int block, lanes *even,
                     lanes *odd) {
    const struct rsh_lane_step *step = rsh_lane_steps + g->offset;
    lanes a[BLOCK], b[BLOCK];
    for (int c = 0; c < block; c++) a[c] = b[c] = lanes_zero();
    for (int i = 0; i < g->steps; i++, step++) {
        lanes even_factor = lanes_load(step->factor[direction][0]);
        lanes odd_factor = lanes_load(step->factor[direction][1]);
        for (int c = 0; c < block; c++) {
            a[c] = lanes_mad(lanes_within(even[c], step->source[direction][0]), even_factor, a[c]);
            b[c] = lanes_mad(lanes_across(odd[c], step->source[direction][1]), odd_factor, b[c]);
        }
    }
    for (int c = 0; c < block; c++) {
        even[c] = a[c];
        odd[c] = b[c];
    }
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

// Coefficients of the group that order n = order^2 has.
INLINE int group_count(const struct rsh_lane_group *g, int n) {
    int end = g + 1 < rsh_lane_groups + RSH_LANE_GROUPS ? g[1].first : RSH_MAX_COEFFICIENTS;
    return (n < end ? n : end) - g->first;
}

// `in` and `out` are the group's place in the first of `block` channels of n coefficients each.
INLINE void turn_group(const struct rsh_lane_group *g, const struct rsh_turn *t,
                       const struct multiples *multiples, int block, int n, const float *in,
                       float *out) {
    int count = group_count(g, n);
    struct angle gamma = place(&multiples->gamma, g->power[0]);
    lanes plus[BLOCK], minus[BLOCK], even[BLOCK], odd[BLOCK];
    for (int c = 0; c < block; c++) {
        struct lanes_source source = lanes_source(in + c * n, count);
        plus[c] = lanes_gather(source, g->plus);
        minus[c] = lanes_gather(source, g->minus);
        turn_pair(gamma, &plus[c], &minus[c]);
    }
    if (t->method == RSH_METHOD_EXACT) {
        struct angle beta = {lanes_any(multiples->beta.cosine, g->power[1]),
                             lanes_any(multiples->beta.sine, g->power[1])};
        for (int c = 0; c < block; c++) {
            even[c] = lanes_halves(plus[c], minus[c]);
            odd[c] = lanes_halves(minus[c], plus[c]);
        }
        exchange(g, 0, block, even, odd);
        for (int c = 0; c < block; c++) turn_pair(beta, &even[c], &odd[c]);
        exchange(g, 1, block, even, odd);
        for (int c = 0; c < block; c++) {
            plus[c] = lanes_halves(even[c], odd[c]);
            minus[c] = lanes_halves(odd[c], even[c]);
        }
    } else if (t->method != RSH_METHOD_Z) {
        for (int c = 0; c < block; c++) {
            plus[c] = series(g, t, 0, plus[c]);
            minus[c] = series(g, t, 1, minus[c]);
        }
    }
    struct angle alpha = place(&multiples->alpha, g->power[0]);
    for (int c = 0; c < block; c++) {
        if (t->method != RSH_METHOD_Z) turn_pair(alpha, &plus[c], &minus[c]);
        lanes_scatter(plus[c], minus[c], g->natural, count, out + c * n);
    }
}

INLINE void turn_channels(const struct rsh_turn *t, const struct multiples *multiples, int order,
                          int block, const float *in, float *out) {
    const struct rsh_lane_group *g = rsh_lane_groups, *end = g + RSH_LANE_GROUPS;
    int n = order * order;
    for (; g < end && g->first < n; g++)
        turn_group(g, t, multiples, block, n, in + g->first, out + g->first);
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
    int n = order * order;
    for (; channels >= BLOCK; channels -= BLOCK, in += BLOCK * n, out += BLOCK * n)
        turn_channels(t, &m, order, BLOCK, in, out);
    for (; channels > 0; channels--, in += n, out += n) turn_channels(t, &m, order, 1, in, out);
}
