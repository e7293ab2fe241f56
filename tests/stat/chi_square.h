// SPDX-License-Identifier: Apache-2.0
// Pearson's chi-square test of a sampler of directions against the density that it claims.
//
// The sphere is cut into rings about an axis (put it where the density peaks, with narrow rings
// there) and sectors; one more cell takes the samples that fail. The expected count of a cell is
// the integral of the density over it, by Gauss' rule on a square that is split until the result
// converges, so peaks and edges inside a cell are found. Cells that expect fewer than 5 are pooled.
#ifndef STAT_CHI_SQUARE_H
#define STAT_CHI_SQUARE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/frame.h"
#include "base/rng.h"

enum { CHI_RINGS_MAX = 32, CHI_SECTORS = 16 };

struct chi_sampler {
    // Draws a direction from four numbers in [0, 1); false if the sample fails.
    bool (*sample)(const void *ctx, const float u[4], vec3 *w);
    double (*pdf_w)(const void *ctx, vec3 w);
    const void *ctx;
};

struct chi_result {
    double mass;       // integral of the density
    double statistic;  // sum of (observed - expected)^2 / expected
    int freedom;       // degrees of freedom; 0 if everything fell into one cell
    double p;          // probability of a larger statistic if the sampler is right
};

// Upper tail of the chi-square distribution: the regularised incomplete gamma function
// Q(k / 2, x / 2), by its series below the mean and by Lentz' continued fraction above.
static inline double chi_tail(double x, int freedom) {
    double a = 0.5 * freedom, y = 0.5 * x;
    if (!(y > 0.0) || freedom < 1) return 1.0;
    double scale = exp(a * log(y) - y - lgamma(a));
    if (y < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (int n = 1; n < 10000 && term > 1e-16 * sum; n++) sum += term *= y / (a + n);
        return 1.0 - scale * sum;
    }
    double b = y + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
    for (int n = 1; n < 10000; n++) {
        double f = -n * (n - a);
        b += 2.0;
        d = 1.0 / (f * d + b);
        c = b + f / c;
        h *= c * d;
        if (fabs(c * d - 1.0) < 1e-14) break;
    }
    return scale * h;
}

// The least p that each of `tests` independent tests must have so that all right samplers pass
// together with probability 1 - significance (Sidak).
static inline double chi_threshold(double significance, int tests) {
    return -expm1(log1p(-significance) / tests);
}

// Rings about `axis` that double in width from `width` [rad] on, up to half the sphere; returns
// their number. edge[CHI_RINGS_MAX + 1].
static inline int chi_rings(double width, double *edge) {
    int n = 0;
    double x = width;
    for (edge[n++] = 0.0; x < 0.7 && n < CHI_RINGS_MAX - 4; x *= 2.0) edge[n++] = x;
    for (int i = 1; i <= 4; i++, n++) edge[n] = edge[n - i] + (M_PI - edge[n - i]) * i / 4;
    return n - 1;
}

// Integral of the density over [t0, t1] x [p0, p1] of angle to the axis and azimuth; `whole` is a
// first estimate.
static inline double chi_cell(const struct chi_sampler *s, const struct frame *f, double t0,
                              double t1, double p0, double p1, double whole, int depth) {
    static const double x[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
    static const double w[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double part[4], sum = 0.0, dt = 0.5 * (t1 - t0), dp = 0.5 * (p1 - p0);
    for (int q = 0; q < 4; q++) {
        part[q] = 0.0;
        for (int i = 0; i < 9; i++) {
            double t = t0 + dt * ((q & 1) + x[i % 3]), p = p0 + dp * ((q >> 1) + x[i / 3]);
            vec3 l = v3((float)(sin(t) * cos(p)), (float)(sin(t) * sin(p)), (float)cos(t));
            part[q] += w[i % 3] * w[i / 3] * dt * dp * sin(t) *
                       s->pdf_w(s->ctx, v3_unit(frame_to_world(f, l)));
        }
        sum += part[q];
    }
    if (depth <= 0 || fabs(sum - whole) < 2e-7) return sum;
    sum = 0.0;
    for (int q = 0; q < 4; q++) {
        double ta = t0 + dt * (q & 1), pa = p0 + dp * (q >> 1);
        sum += chi_cell(s, f, ta, ta + dt, pa, pa + dp, part[q], depth - 1);
    }
    return sum;
}

// Cell counts: rings * CHI_SECTORS, then the failures.
static inline void chi_observe(const struct chi_sampler *s, const struct frame *f,
                               const double *edge, int rings, size_t samples, uint64_t seed,
                               double *count) {
    for (size_t i = 0; i < samples; i++) {
        struct rng rng = rng_make(seed, RNG_TEST, i);
        float u[4];
        vec3 w;
        for (int k = 0; k < 4; k++) u[k] = rng_float(&rng);
        if (!s->sample(s->ctx, u, &w)) {
            count[rings * CHI_SECTORS]++;
            continue;
        }
        vec3 l = frame_to_local(f, w);
        double t = atan2(hypot((double)l.x, (double)l.y), (double)l.z);
        double p = atan2((double)l.y, (double)l.x);
        int ring = 0, sector = (int)floor((p / (2.0 * M_PI) + 1.0) * CHI_SECTORS) % CHI_SECTORS;
        while (ring + 1 < rings && t >= edge[ring + 1]) ring++;
        count[ring * CHI_SECTORS + sector]++;
    }
}

// Tests `samples` draws in rings about the unit `axis`.
static inline struct chi_result chi_test(const struct chi_sampler *s, vec3 axis, const double *edge,
                                         int rings, size_t samples, uint64_t seed) {
    double observed[CHI_RINGS_MAX * CHI_SECTORS + 1] = {0};
    double expected[CHI_RINGS_MAX * CHI_SECTORS + 1];
    const struct frame f = frame_from_normal(axis);
    struct chi_result r = {0};
    for (int i = 0; i < rings * CHI_SECTORS; i++) {
        double p0 = 2.0 * M_PI * (i % CHI_SECTORS) / CHI_SECTORS,
               p1 = p0 + 2.0 * M_PI / CHI_SECTORS;
        double t0 = edge[i / CHI_SECTORS], t1 = edge[i / CHI_SECTORS + 1];
        expected[i] = chi_cell(s, &f, t0, t1, p0, p1, -1.0, 10);
        r.mass += expected[i];
    }
    expected[rings * CHI_SECTORS] = fmax(1.0 - r.mass, 0.0);
    chi_observe(s, &f, edge, rings, samples, seed, observed);
    double pool_observed = 0.0, pool_expected = 0.0;
    int cells = 0;
    for (int i = 0; i <= rings * CHI_SECTORS; i++) {
        double e = expected[i] * (double)samples;
        if (e < 5.0) {
            pool_observed += observed[i], pool_expected += e;
            continue;
        }
        r.statistic += (observed[i] - e) * (observed[i] - e) / e;
        cells++;
    }
    // Cells that are still rare after pooling must not have many samples: they count as expecting
    // 5.
    if (pool_observed > 0.0 || pool_expected > 0.0) {
        double e = fmax(pool_expected, 5.0);
        if (pool_expected >= 5.0 || pool_observed > e)
            r.statistic += (pool_observed - e) * (pool_observed - e) / e, cells++;
    }
    r.freedom = cells - 1;
    r.p = r.freedom > 0 ? chi_tail(r.statistic, r.freedom) : r.statistic < 1.0;
    return r;
}

#endif
