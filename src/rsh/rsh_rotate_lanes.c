// SPDX-License-Identifier: Apache-2.0
// Rotation on lanes; one source for AVX2 and AVX-512: the build defines RSH_NAME, the suffix.
// Orders up to 6 are in rsh_rotate_pairs.c. rsh_tables.h describes the layout. A set of bands is
// loaded, rotated about z, y and z, and stored. Values that depend only on the angles are computed
// once for all channels.
#include "rsh/rsh_rotate_lanes.h"

#include "rsh/rsh_inline.h"
#include "rsh/rsh_lanes.h"
#include "rsh/rsh_tables.h"

// Channels that are rotated at once, as many as the registers hold. They load the same tables.
#if defined(__AVX512F__)
enum { LANES_BLOCK = 3 };
#else
enum { LANES_BLOCK = 1 };
#endif

struct multiple_angle {
    lanes cosine, sine;
};

INLINE struct multiple_angle add_multiples(struct multiple_angle a, struct multiple_angle b) {
    return (struct multiple_angle){
        lanes_nmad(a.sine, b.sine, lanes_mul(a.cosine, b.cosine)),
        lanes_mad(a.sine, b.cosine, lanes_mul(a.cosine, b.sine)),
    };
}

#define ANGLE_IN(mask, c, s) \
    ((struct multiple_angle){lanes_choose(mask, c, 1.0f), lanes_choose(mask, s, 0.0f)})

// cos(m a) and (-1)^m sin(m a) for m = 0 2 4 .. 14 1 3 .. 15. In each lane the multiples 1, 2, 4
// and, if m > 7 is needed, 8 that make up m are added.
INLINE struct multiple_angle multiples(float c1, float s1, bool wide) {
    float c2 = c1 * c1 - s1 * s1, s2 = 2.0f * c1 * s1;
    float c4 = c2 * c2 - s2 * s2, s4 = 2.0f * c2 * s2;
    struct multiple_angle low = add_multiples(ANGLE_IN(0xff00, c1, s1), ANGLE_IN(0xaaaa, c2, s2));
    struct multiple_angle high = ANGLE_IN(0xcccc, c4, s4);
    if (wide) {
        float c8 = c4 * c4 - s4 * s4, s8 = 2.0f * c4 * s4;
        high = add_multiples(high, ANGLE_IN(0xf0f0, c8, s8));
    }
    struct multiple_angle m = add_multiples(low, high);
    m.sine = lanes_halves(m.sine, lanes_nmad(m.sine, lanes_splat(1.0f), lanes_zero()));
    return m;
}

// Rotates about z.
INLINE void rotate_z(struct multiple_angle t, lanes *even, lanes *odd) {
    lanes a = *even, b = *odd;
    *even = lanes_nmad(t.sine, b, lanes_mul(t.cosine, a));
    *odd = lanes_mad(t.sine, a, lanes_mul(t.cosine, b));
}

// Constants of a set at the point of use: its number of coefficients, the steps of its exchange,
// and the steps after the first.
struct lane_span {
    int first, end, steps, offset;
};

// Exchanges y and z of `block` channels. Direction 0 is from the outer to the inner layout, 1 back.
INLINE void exchange_lanes(const struct rsh_lane_set *g, struct lane_span span, int direction,
                           int block, lanes *even, lanes *odd) {
    const struct rsh_lane_step *step = rsh_lane_steps + span.offset;
    indices source = indices_load(g->source[direction]), other = indices_opposite(source);
    lanes a[LANES_BLOCK], b[LANES_BLOCK], p = lanes_load(step->factor[direction][0]),
                                          q = lanes_load(step->factor[direction][1]);
    for (int c = 0; c < block; c++) {
        a[c] = lanes_mul(lanes_within(even[c], source), p);
        b[c] = lanes_mul(lanes_opposite(odd[c], other), q);
    }
    for (int i = 1; i < span.steps; i++) {
        source = indices_next(source), other = indices_next(other);
        p = lanes_load(step[i].factor[direction][0]), q = lanes_load(step[i].factor[direction][1]);
        for (int c = 0; c < block; c++) {
            a[c] = lanes_mad(lanes_within(even[c], source), p, a[c]);
            b[c] = lanes_mad(lanes_opposite(odd[c], other), q, b[c]);
        }
    }
    for (int c = 0; c < block; c++) {
        even[c] = a[c];
        odd[c] = b[c];
    }
}

// D, the derivative of the rotation about y: the contribution of `other` to the even (0) or odd (1)
// component.
INLINE lanes lane_derivative(const struct rsh_lane_set *g, int component, lanes other) {
    lanes down =
        lanes_mul(lanes_across(other, indices_load(g->down)), lanes_load(g->from_down[component]));
    return lanes_mad(lanes_across(other, indices_load(g->up)), lanes_load(g->from_up[component]),
                     down);
}

// Rotates about y by the series.
INLINE void rotate_lane_series(const struct rsh_lane_set *g, const struct rsh_rotation *t,
                               lanes *even, lanes *odd) {
    lanes a = lane_derivative(g, 0, *odd), b = lane_derivative(g, 1, *even),
          beta = lanes_splat(t->beta);
    lanes half = lanes_splat(0.5f * t->beta), first_a = a, first_b = b;
    if (t->method == RSH_METHOD_TAYLOR_2) {
        a = lanes_mad(half, lane_derivative(g, 0, first_b), a);
        b = lanes_mad(half, lane_derivative(g, 1, first_a), b);
    } else if (t->method == RSH_METHOD_TAYLOR_1_5) {
        a = lanes_mad(half, lanes_mul(*even, lanes_load(g->d2_diagonal[0])), a);
        b = lanes_mad(half, lanes_mul(*odd, lanes_load(g->d2_diagonal[1])), b);
    }
    *even = lanes_mad(beta, a, *even);
    *odd = lanes_mad(beta, b, *odd);
}

// Permutes the multiples to the lanes of the set, in the outer (0) or the inner (1) layout.
INLINE struct multiple_angle lane_multiples(const struct rsh_lane_set *g, int inner,
                                            struct multiple_angle a) {
    const indices p = indices_load(g->power[inner]);
    if (inner) return (struct multiple_angle){lanes_any(a.cosine, p), lanes_any(a.sine, p)};
    return (struct multiple_angle){lanes_within(a.cosine, p), lanes_within(a.sine, p)};
}

// A rotation, with the multiples of its angles.
struct angles {
    const struct rsh_rotation *t;
    struct multiple_angle alpha, beta, gamma;
};

// Rotates one set. `in` and `out` are the first of `block` channels of n coefficients each.
INLINE void rotate_set(const struct rsh_lane_set *g, struct lane_span span,
                       const struct angles *angles, int block, int n, const float *in, float *out) {
    const struct rsh_rotation *t = angles->t;
    const int count = (n < span.end ? n : span.end) - span.first;
    in += span.first;
    out += span.first;
    struct multiple_angle gamma = lane_multiples(g, 0, angles->gamma);
    lanes even[LANES_BLOCK], odd[LANES_BLOCK];
    for (int c = 0; c < block; c++) {
        struct lanes_source source = lanes_source_of(in + c * n, count);
        even[c] = lanes_gather(source, indices_load(g->even));
        odd[c] = lanes_gather(source, indices_load(g->odd));
        rotate_z(gamma, &even[c], &odd[c]);
    }
    if (t->method == RSH_METHOD_EXACT) {
        struct multiple_angle beta = lane_multiples(g, 1, angles->beta);
        exchange_lanes(g, span, 0, block, even, odd);
        for (int c = 0; c < block; c++) rotate_z(beta, &even[c], &odd[c]);
        exchange_lanes(g, span, 1, block, even, odd);
    } else if (t->method != RSH_METHOD_Z) {
        for (int c = 0; c < block; c++) rotate_lane_series(g, t, &even[c], &odd[c]);
    }
    if (t->method != RSH_METHOD_Z) {
        struct multiple_angle alpha = lane_multiples(g, 0, angles->alpha);
        for (int c = 0; c < block; c++) rotate_z(alpha, &even[c], &odd[c]);
    }
    for (int c = 0; c < block; c++) lanes_scatter(even[c], odd[c], g->natural, count, out + c * n);
}

// Rotates the first two sets, which all these orders have, with constant spans, and then the
// others.
INLINE void rotate_lane_channels(const struct angles *angles, int order, int block, const float *in,
                                 float *out) {
    const struct rsh_lane_set *g = rsh_lane_sets, *end = g + RSH_LANE_SETS;
    const int n = order * order;
    rotate_set(g++, (struct lane_span){0, 16, 2, 0}, angles, block, n, in, out);
    rotate_set(g++, (struct lane_span){16, 36, 3, 2}, angles, block, n, in, out);
    for (; g < end && g->first < n; g++) {
        const int next = g + 1 < end ? g[1].first : RSH_MAX_COEFFICIENTS;
        const struct lane_span span = {g->first, next, g->steps, g->offset};
        rotate_set(g, span, angles, block, n, in, out);
    }
}

void GLUE(rsh_rotate_lanes_, RSH_NAME)(const struct rsh_rotation *t, int order, int channels,
                                       const float *in, float *out) {
    if (order <= 6) {
        GLUE(rsh_rotate_pairs_, RSH_NAME)(t, order, channels, in, out);
        return;
    }
    const bool wide = order > 8;
    const int n = order * order;
    struct angles a;
    a.t = t;
    a.alpha = a.beta = a.gamma = multiples(t->cos_gamma, t->sin_gamma, wide);
    if (t->method != RSH_METHOD_Z) a.alpha = multiples(t->cos_alpha, t->sin_alpha, wide);
    // The exchange reverses the sense: a rotation about y by beta is one about z by -beta between
    // two exchanges.
    if (t->method == RSH_METHOD_EXACT) a.beta = multiples(t->cos_beta, -t->sin_beta, wide);
    for (; channels >= LANES_BLOCK;
         channels -= LANES_BLOCK, in += LANES_BLOCK * n, out += LANES_BLOCK * n)
        rotate_lane_channels(&a, order, LANES_BLOCK, in, out);
    for (; channels > 0; channels--, in += n, out += n) rotate_lane_channels(&a, order, 1, in, out);
}
