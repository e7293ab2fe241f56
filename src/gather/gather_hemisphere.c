// SPDX-License-Identifier: Apache-2.0
// A hemisphere of gather rays: irradiance with Ward and Heckbert's gradients, or incident radiance
// in harmonics with stratification-based gradients [K05 4.3.1]. Sample directions are jittered per
// cell; the gradients' weights are taken at the cells' fixed walls, which is what makes them
// converge (docs/equations.md, errata 1).
#include <string.h>

#include "gather/gather_layout.h"
#include "gather/gather_scratch.h"
#include "rsh/rsh.h"

// One jittered ray per cell, row by row.
static void make_rays(const struct gather *g, const struct gather_layout *l,
                      struct gather_scratch *scratch, const struct gather_site *site) {
    struct rng rng = rng_make(g->options->seed, RNG_GATHER, site->stream);
    struct gather_ray *out = scratch->rays;
    for (int j = 0; j < l->M; j++)
        for (int k = 0; k < l->N; k++, out++) {
            float u = ((float)j + rng_float(&rng)) / (float)l->M;
            float v = ((float)k + rng_float(&rng)) / (float)l->N;
            vec3 w = l->order ? sample_uniform_hemisphere(fmaxf(1.0f - u, 0.0f), v)
                              : sample_cosine_hemisphere(u, v);
            size_t i = (size_t)(out - scratch->rays);
            scratch->x[i] = w.x;
            scratch->y[i] = w.y;
            scratch->z[i] = w.z;
            out->ray = scene_spawn(g->scene, site->p, site->ng, frame_to_world(&site->frame, w));
            out->item = (uint32_t)i;
            out->sees_lights = false;
        }
}

static void distances(const struct gather_scratch *scratch, size_t count, float *R, float *r_min) {
    double sum = 0.0;
    float least = INFINITY;
    for (size_t i = 0; i < count; i++) {
        float r = scratch->rays[i].r;
        sum += 1.0 / (double)r;  // a miss adds 0
        least = fminf(least, r);
    }
    *R = sum > 0.0 ? (float)((double)count / sum) : INFINITY;
    *r_min = least;
}

// (L_jk - L_neighbour) / min(r_jk, r_neighbour): how fast the wall between two cells carries light
// across.
static rgb wall_change(const struct gather_ray *a, const struct gather_ray *b) {
    float r = fminf(a->r, b->r);
    return isfinite(r) && r > 0.0f ? rgb_scale(rgb_sub(a->L, b->L), 1.0f / r) : rgb_grey(0.0f);
}

static void add_gradient(vec3 grad[3], rgb value, vec3 direction) {
    grad[0] = v3_mad(grad[0], value.r, direction);
    grad[1] = v3_mad(grad[1], value.g, direction);
    grad[2] = v3_mad(grad[2], value.b, direction);
}

// Local gradients of one column k; cells are [j * N + k].
static void irradiance_column(const struct gather_layout *l, const struct gather_ray *cell, int k,
                              struct gather_irradiance *out) {
    const int before = k ? k - 1 : l->N - 1;
    rgb along_u = rgb_grey(0.0f), along_v = rgb_grey(0.0f), turn = rgb_grey(0.0f);
    for (int j = 0; j < l->M; j++) {
        const struct gather_ray *here = &cell[j * l->N + k];
        if (j > 0) along_u = rgb_mad(along_u, wall_change(here, here - l->N), l->wall_u[j]);
        along_v = rgb_mad(along_v, wall_change(here, &cell[j * l->N + before]), l->wall_v[j]);
        turn = rgb_mad(turn, here->L, l->turn[j]);
    }
    add_gradient(out->grad_t, along_u, v3(l->cos_k[k], l->sin_k[k], 0.0f));
    add_gradient(out->grad_t, along_v, v3(-l->sin_w[k], l->cos_w[k], 0.0f));
    add_gradient(out->grad_r, turn, v3(-l->sin_k[k], l->cos_k[k], 0.0f));
}

void gather_hemisphere_irradiance(const struct gather *g, const struct gather_layout *layout,
                                  struct gather_scratch *scratch, const struct gather_site *site,
                                  struct gather_irradiance *out) {
    const size_t count = gather_layout_rays(layout);
    make_rays(g, layout, scratch, site);
    gather_rays(g, scratch, scratch->rays, count, site->stream);
    *out = (struct gather_irradiance){.rays = (uint32_t)count};
    for (size_t i = 0; i < count; i++) out->E = rgb_add(out->E, scratch->rays[i].L);
    out->E = rgb_scale(out->E, PI_F / (float)count);
    distances(scratch, count, &out->R, &out->r_min);
    for (int k = 0; k < layout->N; k++) irradiance_column(layout, scratch->rays, k, out);
    for (int c = 0; c < 3; c++) {
        out->grad_t[c] = frame_to_world(&site->frame, out->grad_t[c]);
        out->grad_r[c] = frame_to_world(&site->frame, out->grad_r[c]);
    }
}

// Adds to gradient vectors dx, dy the change through one kind of wall in row j: sums over k by
// trigonometric function first, then times the row's theta parts.
static void radiance_row(const struct gather_layout *l, struct gather_scratch *scratch,
                         const float *trig, const float *row, float *dx, float *dy) {
    const int n = l->order, n2 = n * n, trigs = l->trig_count, N = l->N;
    float sum[2][3 * (2 * RSH_MAX_ORDER - 1)];
    for (int axis = 0; axis < 2; axis++) {
        memset(sum[axis], 0, sizeof sum[axis]);
        float *value = scratch->wall + axis * 3 * N;
        rsh_accumulate(N, trigs, trig, value, value + N, value + 2 * N, sum[axis]);
    }
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < n; i++)
            for (int m = -i; m <= i; m++) {
                int index = i * (i + 1) + m, t = c * trigs + m + n - 1;
                dx[c * n2 + index] += row[index] * sum[0][t];
                dy[c * n2 + index] += row[index] * sum[1][t];
            }
}

static void put_wall(float *wall, int N, int k, rgb value, float x, float y) {
    wall[0 * N + k] = value.r * x;
    wall[1 * N + k] = value.g * x;
    wall[2 * N + k] = value.b * x;
    wall[3 * N + k] = value.r * y;
    wall[4 * N + k] = value.g * y;
    wall[5 * N + k] = value.b * y;
}

static void radiance_gradients(const struct gather_layout *l, struct gather_scratch *scratch,
                               float *dx, float *dy) {
    const int N = l->N, n2 = l->order * l->order;
    const struct gather_ray *cell = scratch->rays;
    memset(dx, 0, sizeof *dx * 3 * (size_t)n2);
    memset(dy, 0, sizeof *dy * 3 * (size_t)n2);
    for (int j = 0; j < l->M; j++) {
        const struct gather_ray *here = cell + (size_t)j * (size_t)N;
        if (j > 0) {
            for (int k = 0; k < N; k++)
                put_wall(scratch->wall, N, k, wall_change(here + k, here + k - N), l->cos_k[k],
                         l->sin_k[k]);
            radiance_row(l, scratch, l->trig_u, l->row_u + j * n2, dx, dy);
        }
        for (int k = 0; k < N; k++)
            put_wall(scratch->wall, N, k, wall_change(here + k, here + (k ? k - 1 : N - 1)),
                     -l->sin_w[k], l->cos_w[k]);
        radiance_row(l, scratch, l->trig_v, l->row_v + j * n2, dx, dy);
    }
}

void gather_hemisphere_radiance(const struct gather *g, const struct gather_layout *layout,
                                struct gather_scratch *scratch, const struct gather_site *site,
                                struct gather_radiance *out) {
    const size_t count = gather_layout_rays(layout), n2 = (size_t)(layout->order * layout->order);
    make_rays(g, layout, scratch, site);
    gather_rays(g, scratch, scratch->rays, count, site->stream);
    const float weight = 2.0f * PI_F / (float)count;
    for (size_t i = 0; i < count; i++) {
        rgb L = rgb_scale(scratch->rays[i].L, weight);
        scratch->r[i] = L.r;
        scratch->g[i] = L.g;
        scratch->b[i] = L.b;
    }
    memset(out->lambda, 0, sizeof *out->lambda * 3 * n2);
    rsh_project(layout->basis == SATIN_HSH ? RSH_HEMISPHERE : RSH_SPHERE, layout->order, (int)count,
                scratch->x, scratch->y, scratch->z, scratch->r, scratch->g, scratch->b,
                out->lambda);
    distances(scratch, count, &out->R, &out->r_min);
    out->rays = (uint32_t)count;
    if (out->dx) radiance_gradients(layout, scratch, out->dx, out->dy);
}
