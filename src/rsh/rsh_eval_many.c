// SPDX-License-Identifier: Apache-2.0
// Evaluation of all harmonics in many directions, RSH_WIDTH directions per vector.
//
// Orders up to RSH_GENTLE: the Legendre functions of one m are polynomials in z^2, times z for odd
// l - m, and are computed as products of the factors of their roots. z is multiplied to the azimuth
// once per m. So a pair of functions (l, +-m) costs two products and one per root, the differences
// use adders that are otherwise idle, and no function depends on another. The factors of large
// roots are computed from z^2 - 1, which is exact to rounding near the poles, where functions are
// steep. Higher orders: rsh_eval_steep.h.
#include "rsh/rsh_batch.h"
#include "rsh/rsh_directions.h"
#include "rsh/rsh_eval_steep.h"
#include "rsh/rsh_tables.h"

// x, y and z on the sphere, of unit length; t = z^2 and u = z^2 - 1, each accurate to rounding
// where it is small.
struct eval_point {
    vf x, y, z, t, u;
};

// 2 sqrt(z / (1 + z)) as `stretch`, and the relative error of its rounded value, if z has the
// relative error `off`.
struct eval_scale {
    vf size, lack;
};

INLINE struct eval_scale scale_of(vf *height, vf off) {
    float z[W], inverse[W];
    store(z, *height);
    for (int i = 0; i < W; i++) {
        z[i] = z[i] > 0.0f ? z[i] : 0.0f;
        z[i] = z[i] < 1.0f ? z[i] : 1.0f;
        inverse[i] = 1.0f / sqrtf(z[i] + z[i] * z[i] + 1e-30f);
    }
    const vf h = load(z), y = load(inverse), s = (h + h) * y;
    vf square = s * s;
    RSH_KEEP(square);  // so that the next line is fused where that is possible, which gives the
                       // rounding of `square`
    const vf lost = s * s - square, more = off * h;
    const vf rest =
        (((4.0f * h - square) - square * h) - (lost + lost * h)) + more * (4.0f - square);
    *height = h;
    return (struct eval_scale){s, rest * (0.125f + 0.125f * h) * (y * y)};
}

// `off` is the error of the length and `rest` that of z: the functions show m times the first and l
// (l + 1) / 2 times the second.
INLINE struct eval_point eval_point_of(rsh_basis basis, struct directions v) {
    vf off = (1.0f - v.z) * (1.0f + v.z);
    off = 0.5f * ((off - v.x * v.x) - v.y * v.y);
    struct eval_point p = {v.x, v.y, v.z, {0}, {0}};
    vf rest = off * v.z;
    vf size = splat(1.0f);
    if (basis == RSH_HEMISPHERE) {
        const struct eval_scale scale = scale_of(&p.z, off);
        size = scale.size;
        const vf twice = p.z + p.z;
        rest = off * p.z;
        off = size * (off + scale.lack);
        p.z = twice - 1.0f;
        rest = (twice - (p.z + 1.0f)) + (rest + rest);
    }
    p.x = v.x * size + v.x * off;
    p.y = v.y * size + v.y * off;
    vf change = (p.z + p.z) * rest;
    p.t = p.z * p.z + change;
    p.u = (p.z * p.z - 1.0f) + change;
    p.z += rest;
    return p;
}

// Vectors that are evaluated together with the same constants, if there are registers for two.
enum { PAIR = RSH_WIDTH == 16 ? 2 : 1 };

// (x + i y)^m of `vectors` vectors.
struct eval_powers {
    struct azimuth of[PAIR];
};

INLINE struct eval_powers power_sum(int vectors, const struct eval_powers *a,
                                    const struct eval_powers *b) {
    struct eval_powers sum;
    for (int i = 0; i < vectors; i++)
        sum.of[i] = a == b ? azimuth_double(a->of[i]) : azimuth_add(a->of[i], b->of[i]);
    return sum;
}

// Where functions of some vectors of directions go: `count` values of each function.
struct eval_values {
    size_t count;
    float *out;
};

// Computes functions l = m .. order - 1 of one m, whose azimuth is given. `norm` are their factors.
INLINE void eval_column(const float *norm, int order, int m, int vectors,
                        const struct eval_point *v, const struct eval_powers *even,
                        struct eval_values values) {
    const size_t count = values.count;
    struct eval_powers odd;
    for (int i = 0; i < vectors; i++)
        odd.of[i] = azimuth_of(even->of[i].c * v[i].z, even->of[i].s * v[i].z);
    const size_t shift = (size_t)m * count;
    float *to = values.out + (size_t)(m * (m + 1)) * count;
#pragma GCC unroll 16
    for (int l = m; l < order; l++) {
        const int roots = (l - m) / 2;
        const float *root = rsh_gentle_root[m * RSH_GENTLE + l];
        vf value[PAIR];
        for (int i = 0; i < vectors; i++) value[i] = splat(norm[m * RSH_GENTLE + l]);
#pragma GCC unroll 4
        for (int k = 0; k < roots; k++) {
            vf r = splat(root[k]);
            RSH_KEEP(r);
            for (int i = 0; i < vectors; i++) value[i] *= k < roots / 2 ? v[i].u + r : v[i].t - r;
        }
        for (int i = 0; i < vectors; i++) {
            const struct azimuth a = (l - m) % 2 ? odd.of[i] : even->of[i];
            if (m > 0) store(to - shift + i * W, value[i] * a.s);
            store(to + shift + i * W, value[i] * a.c);
        }
        to += (size_t)(2 * (l + 1)) * count;
    }
}

// Computes all functions of one vector of directions or two. There is one function per order, so
// that it has no conditional jumps. Directions are prepared here and not ahead, because stores take
// longer than everything else.
INLINE void eval_gentle(rsh_basis basis, int order, int vectors, const float *const d[3],
                        size_t count, float *out) {
    const bool hemisphere = basis == RSH_HEMISPHERE;
    const float *norm = rsh_gentle_norm + (hemisphere ? RSH_GENTLE * RSH_GENTLE : 0);
    struct eval_point p[PAIR];
    struct eval_powers w0, w1;
    for (int i = 0; i < vectors; i++) {
        const struct directions v = load_directions(d, (size_t)(i * W), W);
        p[i] = hemisphere ? eval_point_of(RSH_HEMISPHERE, v) : eval_point_of(RSH_SPHERE, v);
        w0.of[i] = azimuth_of(splat(1.0f), splat(0.0f));
        w1.of[i] = azimuth_of(p[i].x, p[i].y);
    }
    const struct eval_values values = {count, out};
#define COLUMN(m) eval_column(norm, order, m, vectors, p, &w##m, values)
#define NEXT(m, i, j)                                                 \
    const struct eval_powers w##m = power_sum(vectors, &w##i, &w##j); \
    COLUMN(m)
    COLUMN(0);
    COLUMN(1);
    NEXT(2, 1, 1);
    NEXT(3, 2, 1);
    NEXT(4, 2, 2);
    NEXT(5, 4, 1);
    NEXT(6, 3, 3);
    NEXT(7, 6, 1);
    NEXT(8, 4, 4);
    NEXT(9, 8, 1);
#undef NEXT
#undef COLUMN
}

typedef void evaluation(rsh_basis basis, const float *const d[3], size_t count, float *out);

#define EVAL(name, order, vectors)                                                       \
    static __attribute__((noinline)) void name(rsh_basis basis, const float *const d[3], \
                                               size_t count, float *out) {               \
        eval_gentle(basis, order, vectors, d, count, out);                               \
    }
EVAL(one_1, 1, 1)
EVAL(one_2, 2, 1)
EVAL(one_3, 3, 1)
EVAL(one_4, 4, 1)
EVAL(one_5, 5, 1)
EVAL(one_6, 6, 1)
EVAL(one_7, 7, 1)
EVAL(one_8, 8, 1)
EVAL(one_9, 9, 1)
EVAL(one_10, 10, 1)
#if RSH_WIDTH == 16
EVAL(pair_1, 1, 2)
EVAL(pair_2, 2, 2)
EVAL(pair_3, 3, 2)
EVAL(pair_4, 4, 2)
EVAL(pair_5, 5, 2)
EVAL(pair_6, 6, 2)
EVAL(pair_7, 7, 2)
EVAL(pair_8, 8, 2)
EVAL(pair_9, 9, 2)
EVAL(pair_10, 10, 2)
#endif
#undef EVAL

// Evaluates one vector of directions, or PAIR of them.
INLINE void eval_vectors(rsh_basis basis, int order, int vectors, const float *const d[3],
                         size_t count, float *out) {
    static evaluation *const gentle[PAIR][RSH_GENTLE] = {
        {one_1, one_2, one_3, one_4, one_5, one_6, one_7, one_8, one_9, one_10},
#if RSH_WIDTH == 16
        {pair_1, pair_2, pair_3, pair_4, pair_5, pair_6, pair_7, pair_8, pair_9, pair_10},
#endif
    };
    if (order <= RSH_GENTLE) {
        gentle[vectors - 1][order - 1](basis, d, count, out);
        return;
    }
    for (int i = 0; i < vectors; i++) {
        const struct steep_point p = steep_point_of(basis, load_directions(d, (size_t)(i * W), W));
        steep_vector(basis, order, &p, count, out + i * W);
    }
}

// Evaluates fewer directions than a vector holds.
static void eval_few(rsh_basis basis, int order, size_t count, const float *const d[3],
                     float *out) {
    float few[RSH_MAX_COEFFICIENTS * W], padded[3][W];
    const struct directions v = load_directions(d, 0, count);
    const float *const all[3] = {padded[0], padded[1], padded[2]};
    store(padded[0], v.x);
    store(padded[1], v.y);
    store(padded[2], v.z);
    eval_vectors(basis, order, 1, all, W, few);
    for (int k = 0; k < order * order; k++)
        memcpy(out + (size_t)k * count, few + k * W, count * sizeof *out);
}

void GLUE(rsh_eval_many_, RSH_NAME)(rsh_basis basis, int order, size_t count, const float *x,
                                    const float *y, const float *z, float *out) {
    if (count < W) {
        eval_few(basis, order, count, (const float *const[3]){x, y, z}, out);
        return;
    }
    for (size_t first = 0; first < count;) {
        // The last vector may overlap directions that are already done.
        const int vectors = count - first >= PAIR * W ? PAIR : 1;
        if (count - first < W) first = count - W;
        const float *const d[3] = {x + first, y + first, z + first};
        eval_vectors(basis, order, vectors, d, count, out + first);
        first += (size_t)(vectors * W);
    }
}
