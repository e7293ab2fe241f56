// SPDX-License-Identifier: Apache-2.0
// Rotation of orders up to 6 on lanes; one source for AVX2 and AVX-512: the build defines RSH_NAME,
// the suffix. rsh_tables.h describes the layout, which leaves no lane empty: orders up to 4 fill
// one vector, and bands 2 to 5 of order 6 fill two, while bands 0 and 1 are rotated in scalars.
// Lanes are pairs +m, -m, so that a rotation about z is a product of complex numbers.
//
// The time is limited by loads, of which the processor does one vector per cycle, and by latency.
// Therefore both vectors are rotated side by side, and indices that are used twice are held in
// registers. The factors are not, because other values would be spilled to the stack.
#include "rsh/rsh_inline.h"
#include "rsh/rsh_lanes.h"
#include "rsh/rsh_rotate_lanes.h"
#include "rsh/rsh_tables.h"

// Set 0 is for orders up to 4, set 1 for orders 5 and 6.
#define VECTORS(set) (1 + (set))
#define STEPS(set) (2 + (set))
#define FIRST(set) (4 * (set))
enum { MOST_VECTORS = 2, MOST_STEPS = 3 };

enum { ALPHA, BETA, GAMMA, ANGLES };

// A rotation about z: cosine and sine of the multiple of the angle in each lane.
struct spin {
    lanes cosine[MOST_VECTORS], sine[MOST_VECTORS];
};

// The exchange of y and z.
struct pair_exchange {
    indices source[MOST_VECTORS][MOST_STEPS];
    lanes factor[MOST_VECTORS][MOST_STEPS];
};

// One value for each angle, in the lanes of rsh_pair_multiples.
INLINE lanes three(float alpha, float beta, float gamma) {
    return lanes_choose_of(RSH_PAIR_ALPHA, lanes_splat(alpha),
                           lanes_choose_of(RSH_PAIR_BETA, lanes_splat(beta), lanes_splat(gamma)));
}

// Computes the multiples of all angles at once and permutes them to the lanes that use them. The
// exchange reverses the sense: a rotation about y by beta is one about z by -beta between two
// exchanges.
INLINE void multiply(const struct rsh_rotation *t, int set, struct spin *spins) {
    const struct rsh_pair_multiples *m = &rsh_pair_multiples;
    const lanes c1 = three(t->cos_alpha, t->cos_beta, t->cos_gamma);
    const lanes s1 = three(t->sin_alpha, -t->sin_beta, t->sin_gamma);
    const lanes twice = lanes_nmad(s1, s1, lanes_mul(c1, c1));
    lanes c = lanes_load(m->cosine[2]), s = lanes_load(m->sine[2]);
    for (int k = 1; k >= 0; k--) {
        c = lanes_mad(c, twice, lanes_load(m->cosine[k]));
        s = lanes_mad(s, twice, lanes_load(m->sine[k]));
    }
    c = lanes_mul(c, lanes_choose_of(RSH_PAIR_ODD, c1, lanes_splat(1.0f)));
    s = lanes_mul(s, lanes_choose_of(RSH_PAIR_ODD, s1, lanes_mul(c1, s1)));
    for (int a = GAMMA; a >= ALPHA; a--)
        for (int i = 0; i < VECTORS(set); i++) {
            const indices p = indices_load(rsh_pair_sets[set].lanes[i].multiple[a]);
            spins[a].cosine[i] = lanes_any(c, p);
            spins[a].sine[i] = lanes_any(s, p);
        }
}

INLINE void rotate_pairs_z(const struct spin *spin, int set, lanes *v) {
    lanes w[MOST_VECTORS];
    for (int i = 0; i < VECTORS(set); i++) w[i] = lanes_mul(spin->sine[i], lanes_swap_pairs(v[i]));
    for (int i = 0; i < VECTORS(set); i++) v[i] = lanes_mad_sub(spin->cosine[i], v[i], w[i]);
}

INLINE struct pair_exchange load_exchange(int set) {
    struct pair_exchange e;
    for (int k = 0; k < STEPS(set); k++)
        for (int i = 0; i < VECTORS(set); i++) {
            const struct rsh_pair_lanes *p = &rsh_pair_sets[set].lanes[i];
            e.source[i][k] = indices_held(indices_load(p->source[k]));
            e.factor[i][k] = lanes_load(p->factor[k]);
        }
    return e;
}

INLINE void swap(const struct pair_exchange *e, int set, lanes *v) {
    lanes sum[MOST_VECTORS];
    for (int k = 0; k < STEPS(set); k++)
        for (int i = 0; i < VECTORS(set); i++) {
            const lanes w = lanes_any(v[i], e->source[i][k]);
            sum[i] = k ? lanes_mad(w, e->factor[i][k], sum[i]) : lanes_mul(w, e->factor[i][k]);
        }
    for (int i = 0; i < VECTORS(set); i++) v[i] = sum[i];
}

// D, the derivative of the rotation about y.
INLINE lanes pair_derivative(const struct rsh_pair_lanes *p, lanes v) {
    const lanes down = lanes_mul(lanes_any(v, indices_load(p->down)), lanes_load(p->from_down));
    return lanes_mad(lanes_any(v, indices_load(p->up)), lanes_load(p->from_up), down);
}

// Rotates about y by the series.
INLINE lanes rotate_pair_series(const struct rsh_pair_lanes *p, const struct rsh_rotation *t,
                                lanes v) {
    const lanes half = lanes_splat(0.5f * t->beta);
    lanes a = pair_derivative(p, v);
    if (t->method == RSH_METHOD_TAYLOR_2)
        a = lanes_mad(half, pair_derivative(p, a), a);
    else if (t->method == RSH_METHOD_TAYLOR_1_5)
        a = lanes_mad(half, lanes_mul(v, lanes_load(p->d2_diagonal)), a);
    return lanes_mad(lanes_splat(t->beta), a, v);
}

INLINE void rotate_vectors(const struct rsh_rotation *t, const struct spin *spins, int set,
                           lanes *v) {
    rotate_pairs_z(&spins[GAMMA], set, v);
    if (t->method == RSH_METHOD_Z) return;
    if (t->method == RSH_METHOD_EXACT) {
        const struct pair_exchange e = load_exchange(set);
        swap(&e, set, v);
        rotate_pairs_z(&spins[BETA], set, v);
        swap(&e, set, v);
    } else {
        for (int i = 0; i < VECTORS(set); i++)
            v[i] = rotate_pair_series(&rsh_pair_sets[set].lanes[i], t, v[i]);
    }
    rotate_pairs_z(&spins[ALPHA], set, v);
}

// Rotates bands 0 and 1; band 1 is (y, z, x).
INLINE void rotate_head(const struct rsh_rotation *t, const float *in, float *out) {
    const float y = in[1], z = in[2], x = in[3];
    float c = t->cos_beta, s = t->sin_beta;
    if (t->method != RSH_METHOD_EXACT) {
        c = t->method >= RSH_METHOD_TAYLOR_1_5 ? 1.0f - 0.5f * t->beta * t->beta : 1.0f;
        s = t->beta;
    }
    const float x1 = t->cos_gamma * x - t->sin_gamma * y, y1 = t->sin_gamma * x + t->cos_gamma * y;
    const float x2 = c * x1 + s * z;
    const bool z_only = t->method == RSH_METHOD_Z;
    out[0] = in[0];
    out[1] = z_only ? y1 : t->sin_alpha * x2 + t->cos_alpha * y1;
    out[2] = z_only ? z : c * z - s * x1;
    out[3] = z_only ? x1 : t->cos_alpha * x2 - t->sin_alpha * y1;
}

INLINE void rotate_pairs(const struct rsh_rotation *t, int set, int order, int channels,
                         const float *in, float *out) {
    const int n = order * order, count = n - FIRST(set);
    const struct rsh_pair_set *g = &rsh_pair_sets[set];
    struct spin spins[ANGLES];
    multiply(t, set, spins);
    for (int c = 0; c < channels; c++, in += n, out += n) {
        const struct lanes_source source = lanes_source_of(in + FIRST(set), count);
        lanes v[MOST_VECTORS];
        for (int i = 0; i < VECTORS(set); i++)
            v[i] = lanes_gather(source, indices_load(g->lanes[i].index));
        rotate_vectors(t, spins, set, v);
        if (set > 0) rotate_head(t, in, out);
        lanes_scatter(v[0], v[set], g->natural, count, out + FIRST(set));
    }
}

// Order 6 has a form without conditional jumps; the others have one function each.
static __attribute__((noinline)) void rotate_four(const struct rsh_rotation *t, int order,
                                                  int channels, const float *in, float *out) {
    rotate_pairs(t, 0, order, channels, in, out);
}

static __attribute__((noinline)) void rotate_six(const struct rsh_rotation *t, int order,
                                                 int channels, const float *in, float *out) {
    rotate_pairs(t, 1, order, channels, in, out);
}

static __attribute__((noinline)) void rotate_exact(const struct rsh_rotation *t, int channels,
                                                   const float *in, float *out) {
    struct rsh_rotation exact = *t;
    exact.method = RSH_METHOD_EXACT;
    rotate_pairs(&exact, 1, 6, channels, in, out);
}

static __attribute__((noinline)) void rotate_exact_one(const struct rsh_rotation *t,
                                                       const float *in, float *out) {
    struct rsh_rotation exact = *t;
    exact.method = RSH_METHOD_EXACT;
    rotate_pairs(&exact, 1, 6, 1, in, out);
}

void GLUE(rsh_rotate_pairs_, RSH_NAME)(const struct rsh_rotation *t, int order, int channels,
                                       const float *in, float *out) {
    if (order <= 4)
        rotate_four(t, order, channels, in, out);
    else if (order == 5 || t->method != RSH_METHOD_EXACT)
        rotate_six(t, order, channels, in, out);
    else if (channels != 1)
        rotate_exact(t, channels, in, out);
    else
        rotate_exact_one(t, in, out);
}
