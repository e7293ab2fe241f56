// SPDX-License-Identifier: Apache-2.0
// Evaluation of all harmonics in many directions, RSH_WIDTH directions per vector.
//
// Up to order GENTLE_ORDER: the Legendre functions of one m are polynomials in w = 2 (x^2 + y^2),
// those of odd l - m times z. Two recurrences in w, one for either parity, go two degrees per step;
// z is multiplied to the azimuth once per m. So a pair of functions (l, +-m) costs at most five
// operations, near l = m fewer, and w is exact to rounding near the poles, where functions are
// steep. Higher orders: rsh_eval_steep.h.
#include "rsh/rsh_batch.h"
#include "rsh/rsh_directions.h"
#include "rsh/rsh_eval_steep.h"
#include "rsh/rsh_tables.h"

// Vectors prepared ahead of their evaluation, which need not wait for the stores of the functions.
enum { AHEAD = 4, GENTLE_ORDER = 10 };

// x, y and z of the sphere, of unit length; t = z^2 and u = 1 - z^2, either right to rounding where
// it is small.
struct point {
    vf x, y, z, t, u;
};

// What s, 2 sqrt(z / (1 + z)) rounded, lacks in relation to itself.
INLINE vf stretch_error(vf z, vf s) {
    vf square = s * s;
    RSH_KEEP(square);  // so that the next line is fused, where it can be, and gives its rounding
    const vf lost = s * s - square;
    return ((4.0f * z - square) - square * z - (lost + lost * z)) / (8.0f * z + 1e-30f);
}

// `off` is what the length lacks of 1, `rest` what z lacks: m times the one and l (l + 1) / 2 times
// the other show in the functions.
INLINE struct point point_of(rsh_basis basis, struct directions v) {
    vf off = (1.0f - v.z) * (1.0f + v.z);
    off = 0.5f * ((off - v.x * v.x) - v.y * v.y);
    struct point p = {v.x, v.y, v.z, {0}, {0}};
    vf rest = off * v.z;
    vf scale = splat(1.0f);
    if (basis == RSH_HEMISPHERE) {
        scale = stretch(&p.z);
        const vf twice = p.z + p.z;
        rest = off * p.z;
        off = scale * (off + stretch_error(p.z + rest, scale));
        p.z = twice - 1.0f;
        rest = (twice - (p.z + 1.0f)) + (rest + rest);
    }
    p.x = v.x * scale + v.x * off;
    p.y = v.y * scale + v.y * off;
    vf change = (p.z + p.z) * rest;
    p.t = p.z * p.z + change;
    p.u = (1.0f - p.z * p.z) - change;
    p.z += rest;
    return p;
}

// Functions l = m .. order - 1 of one m, whose azimuth is given.
INLINE void eval_column(const float *norm, int order, int m, const struct point *v,
                        struct azimuth even, size_t count, float *out) {
    const float *from = rsh_half_from + m * RSH_MAX_ORDER,
                *fall = rsh_half_fall + m * RSH_MAX_ORDER;
    const struct azimuth odd = {even.c * v->z, even.s * v->z};
    const size_t shift = (size_t)m * count;
    float *to = out + (size_t)(m * (m + 1)) * count;
    // Of even and of odd l - m: the last function, and the one before or the last difference.
    vf p[2] = {splat(1.0f), splat(1.0f)}, p1[2] = {{0}, {0}};
#pragma GCC unroll 16
    for (int l = m; l < order; l++) {
        const int side = (l - m) & 1;
        if (l > m + 1 && m < RSH_POLAR) {
            p1[side] -= l > m + 3 ? (from[l] * v->u) * p[side] : from[l] * v->u;
            p[side] += fall[l] * p1[side];
        } else if (l > m + 1) {
            vf next = (v->t - from[l]) * p[side];
            if (l > m + 3) next -= fall[l] * p1[side];
            p1[side] = p[side];
            p[side] = next;
        }
        const vf value = p[side] * norm[m * RSH_MAX_ORDER + l];
        if (m > 0) store(to - shift, value * (side ? odd.s : even.s));
        store(to + shift, value * (side ? odd.c : even.c));
        to += (size_t)(2 * (l + 1)) * count;
    }
}

// All functions of one vector of directions; a function of its own per order, which leaves nothing
// to branch on.
INLINE void eval_vector(const float *norm, int order, const struct point *p, size_t count,
                        float *out) {
#define COLUMN(m, first)               \
    const struct azimuth a##m = first; \
    eval_column(norm, order, m, p, a##m, count, out)
    COLUMN(0, azimuth_of(splat(1.0f), splat(0.0f)));
    COLUMN(1, azimuth_of(p->x, p->y));
    COLUMN(2, azimuth_double(a1));
    COLUMN(3, azimuth_add(a2, a1));
    COLUMN(4, azimuth_double(a2));
    COLUMN(5, azimuth_add(a4, a1));
    COLUMN(6, azimuth_double(a3));
    COLUMN(7, azimuth_add(a6, a1));
    COLUMN(8, azimuth_double(a4));
    COLUMN(9, azimuth_add(a8, a1));
#undef COLUMN
}

#define EVAL(order)                                                                              \
    static __attribute__((noinline)) void eval_##order(const float *norm, const struct point *p, \
                                                       size_t count, float *out) {               \
        eval_vector(norm, order, p, count, out);                                                 \
    }
EVAL(1)
EVAL(2)
EVAL(3)
EVAL(4)
EVAL(5)
EVAL(6)
EVAL(7)
EVAL(8)
EVAL(9)
EVAL(10)
#undef EVAL

INLINE void eval_gentle(rsh_basis basis, int order, size_t vectors, const struct directions *v,
                        size_t count, float *out) {
    static void (*const eval[GENTLE_ORDER])(const float *, const struct point *, size_t,
                                            float *) = {eval_1, eval_2, eval_3, eval_4, eval_5,
                                                        eval_6, eval_7, eval_8, eval_9, eval_10};
    const float *norm = rsh_half_norm + (int)basis * RSH_MAX_ORDER * RSH_MAX_ORDER;
    struct point p[AHEAD];
    for (size_t i = 0; i < vectors; i++) p[i] = point_of(basis, v[i]);
    for (size_t i = 0; i < vectors; i++) eval[order - 1](norm, &p[i], count, out + i * W);
}

INLINE void eval_steep(rsh_basis basis, int order, size_t vectors, const struct directions *v,
                       size_t count, float *out) {
    struct steep_point p[AHEAD];
    for (size_t i = 0; i < vectors; i++) p[i] = steep_point_of(basis, v[i]);
    for (size_t i = 0; i < vectors; i++) steep_vector(basis, order, &p[i], count, out + i * W);
}

INLINE void eval_vectors(rsh_basis basis, int order, size_t vectors, const struct directions *v,
                         size_t count, float *out) {
    if (order > GENTLE_ORDER)
        eval_steep(basis, order, vectors, v, count, out);
    else if (basis == RSH_HEMISPHERE)
        eval_gentle(RSH_HEMISPHERE, order, vectors, v, count, out);
    else
        eval_gentle(RSH_SPHERE, order, vectors, v, count, out);
}

void GLUE(rsh_eval_many_, RSH_NAME)(rsh_basis basis, int order, size_t count, const float *x,
                                    const float *y, const float *z, float *out) {
    const float *const d[3] = {x, y, z};
    if (count < W) {
        float few[RSH_MAX_COEFFICIENTS * W];
        const struct directions v = load_directions(d, 0, count);
        eval_vectors(basis, order, 1, &v, W, few);
        for (int k = 0; k < order * order; k++)
            memcpy(out + (size_t)k * count, few + k * W, count * sizeof *out);
        return;
    }
    for (size_t first = 0; first < count;) {
        // The last vector may begin among directions that are done already.
        struct directions v[AHEAD];
        size_t vectors = (count - first) / W;
        if (vectors == 0) first = count - W;
        vectors = vectors < 1 ? 1 : vectors > AHEAD ? AHEAD : vectors;
        for (size_t i = 0; i < vectors; i++) v[i] = load_directions(d, first + i * W, W);
        eval_vectors(basis, order, vectors, v, count, out + first);
        first += vectors * W;
    }
}
