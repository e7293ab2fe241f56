// SPDX-License-Identifier: Apache-2.0
// Fixed angles and weights of a stratified hemisphere. Rows have equal projected solid angle for
// irradiance, theta_j- = asin sqrt(j / M), or equal solid angle for radiance, theta_j- = acos(1 - j
// / M) [K05 (4.9), 4.3.2].
#include "gather/gather_layout.h"

#include <stdlib.h>

#include "base/array.h"
#include "rsh/rsh.h"

static double boundary_angle(const struct gather_layout *l, double j) {
    return l->order ? acos(fmax(0.0, 1.0 - j / l->M)) : asin(sqrt(fmin(1.0, j / l->M)));
}

static void azimuths(struct gather_layout *l) {
    const double step = 2.0 * 3.14159265358979323846 / l->N;
    for (int k = 0; k < l->N; k++) {
        l->cos_k[k] = (float)cos(step * (k + 0.5));
        l->sin_k[k] = (float)sin(step * (k + 0.5));
        l->cos_w[k] = (float)cos(step * k);
        l->sin_w[k] = (float)sin(step * k);
    }
}

static void irradiance_rows(struct gather_layout *l) {
    const double step = 2.0 * 3.14159265358979323846 / l->N;
    for (int j = 0; j < l->M; j++) {
        double lo = boundary_angle(l, j), hi = boundary_angle(l, j + 1);
        l->boundary_u[j] = (float)(step * cos(lo) * cos(lo) * sin(lo));
        l->boundary_v[j] = (float)(sin(hi) - sin(lo));
        l->boundary_h[j] = (float)((hi - lo) * cos(0.5 * (lo + hi)));
        l->rotation[j] = (float)(step * ((hi - lo) / 2.0 - (sin(2.0 * hi) - sin(2.0 * lo)) / 4.0));
    }
}

// Half the integral of the cosine law's boundary term along the edge from r1 to r2, n . (r1 x r2)
// int dt / |r|^2, differentiated twice by the position of the centre in the tangent plane.
static void edge_hessian(const double r1[3], const double r2[3], float out[3]) {
    static const double node[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                  0.9602898564975363};
    static const double weight[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                    0.1012285362903763};  // Gauss and Legendre, half of each
    const double e[3] = {r2[0] - r1[0], r2[1] - r1[1], r2[2] - r1[2]};
    const double height = r1[0] * r2[1] - r1[1] * r2[0], slope[2] = {-e[1], e[0]};
    double first[2] = {0}, second[3] = {0};  // derivatives of int dt / |r|^2
    for (int i = 0; i < 8; i++) {
        double t = 0.5 + 0.5 * (i < 4 ? node[i] : -node[i - 4]), w = 0.5 * weight[i % 4];
        double x = r1[0] + t * e[0], y = r1[1] + t * e[1], z = r1[2] + t * e[2];
        double r2_ = x * x + y * y + z * z, r4 = r2_ * r2_, r6 = r4 * r2_;
        first[0] += w * 2.0 * x / r4;
        first[1] += w * 2.0 * y / r4;
        second[0] += w * (8.0 * x * x / r6 - 2.0 / r4);
        second[1] += w * 8.0 * x * y / r6;
        second[2] += w * (8.0 * y * y / r6 - 2.0 / r4);
    }
    out[0] = (float)(0.5 * (height * second[0] + 2.0 * slope[0] * first[0]));
    out[1] = (float)(0.5 * (height * second[1] + slope[0] * first[1] + slope[1] * first[0]));
    out[2] = (float)(0.5 * (height * second[2] + 2.0 * slope[1] * first[1]));
}

// Adds the term of the edges that join the ends of a boundary to those of its neighbours at other
// distances: they run along the line of sight, where the term is 0 but its derivatives are not.
// Each boundary has the part of such an edge from its own end to infinity.
static void add_ends(const double r1[3], const double r2[3], float out[3]) {
    out[0] += (float)(r1[0] * r1[1] - r2[0] * r2[1]);
    out[1] += (float)(0.5 * (r2[0] * r2[0] - r2[1] * r2[1] - r1[0] * r1[0] + r1[1] * r1[1]));
    out[2] += (float)(r2[0] * r2[1] - r1[0] * r1[1]);
}

static void local_direction(double theta, double phi, double out[3]) {
    out[0] = sin(theta) * cos(phi);
    out[1] = sin(theta) * sin(phi);
    out[2] = cos(theta);
}

// Boundaries run along the azimuth, and from the horizon to the pole; the stratum before the
// boundary is on its left.
static void hessian_rows(struct gather_layout *l) {
    const double half = 3.14159265358979323846 / l->N;
    for (int j = 0; j < l->M; j++) {
        double lo = boundary_angle(l, j), hi = boundary_angle(l, j + 1), from[3], to[3];
        local_direction(hi, -half, from);
        local_direction(hi, half, to);
        edge_hessian(from, to, l->hessian_u[j]);
        add_ends(from, to, l->hessian_u[j]);
        local_direction(hi, 0.0, from);
        local_direction(lo, 0.0, to);
        edge_hessian(from, to, l->hessian_v[j]);
        add_ends(from, to, l->hessian_v[j]);
    }
}

static void evaluate(const struct gather_layout *l, double theta, double phi, float *y) {
    float w[3] = {(float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)),
                  (float)cos(theta)};
    rsh_eval(brdf_rsh_basis(l->basis), l->order, w, y);
}

// The factor of every harmonic that depends on theta: its value where its trigonometric factor is
// 1, at phi = 0 for m >= 0 and at phi = pi / (2 |m|) for m < 0.
static void theta_factors(const struct gather_layout *l, double theta, double weight, float *row,
                          float *scratch) {
    const int n = l->order;
    for (int m = -(n - 1); m < n; m++) {
        evaluate(l, theta, m < 0 ? 3.14159265358979323846 / (2.0 * -m) : 0.0, scratch);
        for (int i = abs(m); i < n; i++) {
            int index = i * (i + 1) + m;
            row[index] = (float)(weight * (double)scratch[index]);
        }
    }
}

static bool radiance_rows(struct gather_layout *l) {
    const int n = l->order;
    const double step = 2.0 * 3.14159265358979323846 / l->N;
    float *scratch = array_new((size_t)(n * n), sizeof *scratch);
    if (!scratch) return false;
    for (int j = 0; j < l->M; j++) {
        double lo = boundary_angle(l, j), hi = boundary_angle(l, j + 1);
        size_t at = (size_t)j * (size_t)(n * n);
        theta_factors(l, lo, step * cos(lo) * sin(lo), l->row_u + at, scratch);
        theta_factors(l, 0.5 * (lo + hi), hi - lo, l->row_v + at, scratch);
    }
    for (int k = 0; k < l->N; k++)
        for (int m = -(n - 1); m < n; m++) {
            double centre = step * (k + 0.5), boundary = step * k;
            size_t at = (size_t)k * (size_t)l->trig_count + (size_t)(m + n - 1);
            l->trig_u[at] = (float)(m < 0 ? sin(-m * centre) : cos(m * centre));
            l->trig_v[at] = (float)(m < 0 ? sin(-m * boundary) : cos(m * boundary));
        }
    free(scratch);
    return true;
}

struct gather_layout *gather_layout_new(int rays, satin_basis basis, int order) {
    struct gather_layout *l = calloc(1, sizeof *l);
    if (!l) return NULL;
    // Nearly square strata: N / M is about pi for projected and 4 for uniform solid angle [K05
    // 4.3.1].
    double ratio = order ? 4.0 : 3.14159265358979323846;
    l->order = order;
    l->basis = basis;
    l->M = (int)fmax(2.0, floor(sqrt(rays / ratio) + 0.5));
    l->N = (int)fmax(4.0, floor((double)rays / l->M + 0.5));
    l->trig_count = order ? 2 * order - 1 : 0;
    size_t M = (size_t)l->M, N = (size_t)l->N, n2 = (size_t)(order * order);
    size_t trig = N * (size_t)l->trig_count;
    float *block = array_new(4 * N + 10 * M + 2 * trig + 2 * M * n2, sizeof *block);
    if (!block) {
        free(l);
        return NULL;
    }
    float *hessian_u, *hessian_v;
    float **table[] = {&l->cos_k,      &l->sin_k,      &l->cos_w,    &l->sin_w,  &l->boundary_u,
                       &l->boundary_v, &l->boundary_h, &l->rotation, &l->trig_u, &l->trig_v,
                       &l->row_u,      &l->row_v,      &hessian_u,   &hessian_v};
    size_t size[] = {N, N, N, N, M, M, M, M, trig, trig, M * n2, M * n2, 3 * M, 3 * M};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        *table[i] = block;
        block += size[i];
    }
    l->hessian_u = (float(*)[3])hessian_u;
    l->hessian_v = (float(*)[3])hessian_v;
    azimuths(l);
    irradiance_rows(l);
    hessian_rows(l);
    if (order && !radiance_rows(l)) {
        gather_layout_free(l);
        return NULL;
    }
    return l;
}

void gather_layout_free(struct gather_layout *layout) {
    if (!layout) return;
    free(layout->cos_k);  // all tables are one block, which begins here
    free(layout);
}

size_t gather_layout_rays(const struct gather_layout *layout) {
    return (size_t)layout->M * (size_t)layout->N;
}
