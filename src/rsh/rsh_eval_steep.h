// SPDX-License-Identifier: Apache-2.0
// Evaluation at orders whose functions are so steep near the poles that the rounding of z itself is
// visible. The recurrences use u = 1 - |z|, which is computed in double; for m < RSH_STEEP they are
// recurrences of differences.
#ifndef RSH_EVAL_STEEP_H
#define RSH_EVAL_STEEP_H

#include "rsh/rsh_directions.h"
#include "rsh/rsh_tables.h"

// A point of evaluation: the direction as given, u = 1 - |z| and the sign of z on the sphere, and
// the factor that maps x and y to the sphere: size (1 + grow), where grow is tiny.
struct steep_point {
    vf x, y, u, sign, size, grow;
};

INLINE struct azimuth next_azimuth(struct azimuth a, const struct steep_point *v) {
    return (struct azimuth){v->size * (v->x * a.c - v->y * a.s),
                            v->size * (v->x * a.s + v->y * a.c)};
}

// In double, because degree l multiplies the error of u by l (l + 1) / 2 and that of the factor by
// m. Lengths are corrected as in rsh_eval.
INLINE struct steep_point steep_point_of(rsh_basis basis, struct directions v) {
    float x[W], y[W], z[W], u[W], sign[W], size[W], grow[W];
    store(x, v.x);
    store(y, v.y);
    store(z, v.z);
    for (int i = 0; i < W; i++) {
        if (basis == RSH_HEMISPHERE) {
            z[i] = z[i] > 0.0f ? z[i] : 0.0f;
            z[i] = z[i] < 1.0f ? z[i] : 1.0f;
        }
        double a = (double)x[i], b = (double)y[i], c = (double)z[i];
        double off = 0.5 - 0.5 * (a * a + b * b + c * c);
        c += c * off;
        size[i] = 1.0f;
        grow[i] = (float)off;
        if (basis == RSH_HEMISPHERE) {
            // 2 sqrt(z / (1 + z)), and the error of its square.
            size[i] = 2.0f * sqrtf(z[i] / (1.0f + z[i]));
            double square = (double)size[i] * (double)size[i];
            grow[i] += (float)(4.0 * c - square * (1.0 + c)) / (8.0f * z[i] + 1e-30f);
            c = 2.0 * c - 1.0;
        }
        u[i] = (float)(1.0 - fabs(c));
        sign[i] = copysignf(1.0f, (float)c);
    }
    return (struct steep_point){v.x, v.y, load(u), load(sign), load(size), load(grow)};
}

// The two factors of functions (l, +-m) that depend on m alone, for even and for odd l - m.
// Everything below is a function of |z|.
struct parity_factors {
    struct azimuth of[2];
};

INLINE struct parity_factors parity_factors_of(struct azimuth a, int m,
                                               const struct steep_point *v) {
    vf right = 1.0f + (float)m * v->grow;
    a.c *= right;
    a.s *= right;
    return (struct parity_factors){{a, {a.c * v->sign, a.s * v->sign}}};
}

// Computes l = m .. order - 1 for one m. As |z| = 1 - u, the recurrence is p - u p - b p1, which
// keeps the accuracy of u near the pole.
INLINE void steep_column(int order, int m, vf u, struct parity_factors a, size_t count,
                         float *out) {
    const float *norm = rsh_norm + m * RSH_MAX_ORDER, *b = rsh_recurrence + m * RSH_MAX_ORDER;
    const size_t shift = (size_t)m * count, two = 2 * count;
    float *to = out + (size_t)(m * (m + 1)) * count;
    vf p1 = {0}, p = splat(1.0f);
    for (int l = m; l < order; l += 2) {
        put_pair(to, shift, p * norm[l], a.of[0]);
        if (l + 1 == order) break;
        p1 = (p - u * p) - b[l + 1] * p1;
        to += (size_t)(l + 1) * two;
        put_pair(to, shift, p1 * norm[l + 1], a.of[1]);
        if (l + 2 >= order) break;
        p = (p1 - u * p1) - b[l + 2] * p;
        to += (size_t)(l + 2) * two;
    }
}

// Computes all m < RSH_STEEP together, by differences in u.
INLINE void steep_small(int order, vf u, const struct parity_factors *a, size_t count, float *out) {
    vf q[RSH_STEEP], d[RSH_STEEP];
    for (int m = 0; m < RSH_STEEP; m++) {
        q[m] = splat(1.0f);
        d[m] = (vf){0};
    }
    for (int l = 0; l < order; l++)
        for (int m = 0; m < RSH_STEEP && m <= l; m++) {
            const int at = m * RSH_MAX_ORDER + l;
            if (l > m) {
                d[m] -= (rsh_curvature[at] * u) * q[m];
                q[m] += rsh_keep[at] * d[m];
            }
            put_pair(out + (size_t)(l * (l + 1)) * count, (size_t)m * count, q[m] * rsh_pole[at],
                     a[m].of[(l - m) & 1]);
        }
}

// Computes all functions of one vector of directions.
INLINE void steep_vector(rsh_basis basis, int order, const struct steep_point *v, size_t count,
                         float *out) {
    struct azimuth a = {splat(basis == RSH_HEMISPHERE ? sqrtf(2.0f) : 1.0f), {0}};
    struct parity_factors factors[RSH_STEEP];
    for (int m = 0; m < RSH_STEEP; m++, a = next_azimuth(a, v))
        factors[m] = parity_factors_of(a, m, v);
    steep_small(order, v->u, factors, count, out);
    for (int m = RSH_STEEP; m < order; m++, a = next_azimuth(a, v))
        steep_column(order, m, v->u, parity_factors_of(a, m, v), count, out);
}

#endif
