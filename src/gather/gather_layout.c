// SPDX-License-Identifier: Apache-2.0
// Fixed angles and weights of a stratified hemisphere. Rows have equal projected solid angle
// (irradiance, theta_j- = asin sqrt(j / M)) or equal solid angle (radiance, theta_j- = acos(1 - j /
// M)) [K05 (4.9), 4.3.2].
#include "gather/gather_layout.h"

#include <stdlib.h>

#include "base/array.h"
#include "rsh/rsh.h"

static double wall_angle(const struct gather_layout *l, double j) {
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
        double lo = wall_angle(l, j), hi = wall_angle(l, j + 1);
        l->wall_u[j] = (float)(step * cos(lo) * cos(lo) * sin(lo));
        l->wall_v[j] = (float)(sin(hi) - sin(lo));
        l->wall_h[j] = (float)((hi - lo) * cos(0.5 * (lo + hi)));
        l->turn[j] = (float)(step * ((hi - lo) / 2.0 - (sin(2.0 * hi) - sin(2.0 * lo)) / 4.0));
    }
}

static void evaluate(const struct gather_layout *l, double theta, double phi, float *y) {
    float w[3] = {(float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)),
                  (float)cos(theta)};
    rsh_eval(l->basis == SATIN_HSH ? RSH_HEMISPHERE : RSH_SPHERE, l->order, w, y);
}

// The theta part of every harmonic: its value where its trigonometric factor is 1 (at phi = 0 for m
// >= 0, at phi = pi / (2 |m|) for m < 0).
static void theta_parts(const struct gather_layout *l, double theta, double weight, float *row,
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
        double lo = wall_angle(l, j), hi = wall_angle(l, j + 1);
        size_t at = (size_t)j * (size_t)(n * n);
        theta_parts(l, lo, step * cos(lo) * sin(lo), l->row_u + at, scratch);
        theta_parts(l, 0.5 * (lo + hi), hi - lo, l->row_v + at, scratch);
    }
    for (int k = 0; k < l->N; k++)
        for (int m = -(n - 1); m < n; m++) {
            double centre = step * (k + 0.5), wall = step * k;
            size_t at = (size_t)k * (size_t)l->trig_count + (size_t)(m + n - 1);
            l->trig_u[at] = (float)(m < 0 ? sin(-m * centre) : cos(m * centre));
            l->trig_v[at] = (float)(m < 0 ? sin(-m * wall) : cos(m * wall));
        }
    free(scratch);
    return true;
}

struct gather_layout *gather_layout_new(int rays, satin_basis basis, int order) {
    struct gather_layout *l = calloc(1, sizeof *l);
    if (!l) return NULL;
    // Square-ish cells: N / M near pi for projected, near 4 for uniform solid angle [K05 4.3.1].
    double ratio = order ? 4.0 : 3.14159265358979323846;
    l->order = order;
    l->basis = basis;
    l->M = (int)fmax(2.0, floor(sqrt(rays / ratio) + 0.5));
    l->N = (int)fmax(4.0, floor((double)rays / l->M + 0.5));
    l->trig_count = order ? 2 * order - 1 : 0;
    size_t M = (size_t)l->M, N = (size_t)l->N, n2 = (size_t)(order * order);
    size_t trig = N * (size_t)l->trig_count;
    float *block = array_new(4 * N + 4 * M + 2 * trig + 2 * M * n2, sizeof *block);
    if (!block) {
        free(l);
        return NULL;
    }
    float **part[] = {&l->cos_k,  &l->sin_k, &l->cos_w,  &l->sin_w,  &l->wall_u, &l->wall_v,
                      &l->wall_h, &l->turn,  &l->trig_u, &l->trig_v, &l->row_u,  &l->row_v};
    size_t size[] = {N, N, N, N, M, M, M, M, trig, trig, M * n2, M * n2};
    for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
        *part[i] = block;
        block += size[i];
    }
    azimuths(l);
    irradiance_rows(l);
    if (order && !radiance_rows(l)) {
        gather_layout_free(l);
        return NULL;
    }
    return l;
}

void gather_layout_free(struct gather_layout *layout) {
    if (!layout) return;
    free(layout->cos_k);  // the start of the one block
    free(layout);
}

size_t gather_layout_rays(const struct gather_layout *layout) {
    return (size_t)layout->M * (size_t)layout->N;
}
