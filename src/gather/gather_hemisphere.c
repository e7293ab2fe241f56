// SPDX-License-Identifier: Apache-2.0
// A hemisphere of gather rays: irradiance, or incident radiance in harmonics [K05 (4.9)], with
// gradients of the kind that the options name. Without gradients in the interpolation they still
// bound the records' radii.
#include <string.h>

#include "gather/gather_gradients.h"
#include "gather/gather_guide.h"
#include "rsh/rsh.h"

// One jittered ray per cell, row by row.
static void make_rays(const struct gather *g, const struct gather_layout *l,
                      struct gather_scratch *scratch, const struct gather_site *site) {
    struct rng rng = rng_make(g->options->seed, RNG_GATHER, site->stream);
    struct gather_ray *out = scratch->rays;
    const float spread =
        g->options->texture_filter ? sqrtf(2.0f * PI_F / (float)gather_layout_rays(l)) : 0.0f;
    for (int j = 0; j < l->M; j++)
        for (int k = 0; k < l->N; k++, out++) {
            float u = sample_stratum(j, rng_float(&rng), l->M);
            float v = sample_stratum(k, rng_float(&rng), l->N);
            vec3 w =
                l->order ? sample_uniform_hemisphere(1.0f - u, v) : sample_cosine_hemisphere(u, v);
            size_t i = (size_t)(out - scratch->rays);
            scratch->x[i] = w.x;
            scratch->y[i] = w.y;
            scratch->z[i] = w.z;
            out->ray = scene_spawn(g->scene, site->p, site->ng, frame_to_world(&site->frame, w));
            out->item = (uint32_t)i;
            out->spread = spread;
            out->lit = NULL;
        }
}

// Even rays and guided ones; returns how many.
static size_t trace(const struct gather *g, const struct gather_layout *l,
                    struct gather_scratch *scratch, const struct gather_site *site) {
    make_rays(g, l, scratch, site);
    const size_t count = gather_layout_rays(l) + gather_guide_rays(g, l, site, scratch);
    gather_rays_guided(g, scratch, scratch->rays, count, site->stream);
    gather_guide_weigh(l, scratch);
    return count;
}

static void add_turn(vec3 grad[3], rgb turn, vec3 axis) {
    grad[0] = v3_mad(grad[0], turn.r, axis);
    grad[1] = v3_mad(grad[1], turn.g, axis);
    grad[2] = v3_mad(grad[2], turn.b, axis);
}

// E changes with the normal about the axis across each column by the integral of sin^2(theta).
static void turn_gradient(const struct gather_cells *cells, vec3 grad[3]) {
    const struct gather_layout *l = cells->layout;
    for (int k = 0; k < l->N; k++) {
        const struct gather_ray *ray = cells->scratch->rays + k;
        const vec3 axis = v3(-l->sin_k[k], l->cos_k[k], 0.0f);
        rgb turn = rgb_grey(0.0f);
        for (int j = 0; j < l->M; j++, ray += l->N) turn = rgb_mad(turn, ray->L, l->turn[j]);
        add_turn(grad, turn, axis);
    }
    // The others by the derivative of the cosine, each standing for pi / count of cos(theta) Omega.
    const size_t even = gather_layout_rays(l);
    const struct gather_scratch *s = cells->scratch;
    for (size_t i = even; i < even + s->guide.made; i++) {
        float share = PI_F / (float)even / s->z[i];
        add_turn(grad, rgb_scale(s->rays[i].L, share), v3(-s->y[i], s->x[i], 0.0f));
    }
}

static void irradiance_gradients(const struct gather_cells *cells, satin_gradients kind,
                                 vec3 grad[3]) {
    if (kind == SATIN_GRADIENTS_SOLID_ANGLE || kind == SATIN_GRADIENTS_DIFFERENCES)
        gather_solid_angle_irradiance(cells, kind == SATIN_GRADIENTS_DIFFERENCES, 0, grad);
    else {
        gather_stratified_irradiance(cells, kind == SATIN_GRADIENTS_WARD_HECKBERT, grad);
        gather_solid_angle_irradiance(cells, false, gather_layout_rays(cells->layout), grad);
    }
}

void gather_hemisphere_irradiance(const struct gather *g, const struct gather_layout *layout,
                                  struct gather_scratch *scratch, const struct gather_site *site,
                                  struct gather_irradiance *out) {
    const size_t count = trace(g, layout, scratch, site);
    *out = (struct gather_irradiance){.rays = (uint32_t)count};
    for (size_t i = 0; i < count; i++) out->E = rgb_add(out->E, scratch->rays[i].L);
    out->E = rgb_scale(out->E, PI_F / (float)gather_layout_rays(layout));
    const struct gather_cells cells = {layout, &site->frame, scratch};
    irradiance_gradients(&cells, g->options->irradiance_gradients, out->grad_t);
    turn_gradient(&cells, out->grad_r);
    for (int c = 0; c < 3; c++) {
        out->grad_t[c] = frame_to_world(&site->frame, out->grad_t[c]);
        out->grad_r[c] = frame_to_world(&site->frame, out->grad_r[c]);
    }
}

static void radiance_gradients(const struct gather_cells *cells, satin_gradients kind, float *dx,
                               float *dy) {
    const size_t n2 = (size_t)(cells->layout->order * cells->layout->order);
    memset(dx, 0, sizeof *dx * 3 * n2);
    memset(dy, 0, sizeof *dy * 3 * n2);
    if (kind == SATIN_GRADIENTS_SOLID_ANGLE || kind == SATIN_GRADIENTS_DIFFERENCES)
        gather_solid_angle_radiance(cells, kind == SATIN_GRADIENTS_DIFFERENCES, 0, dx, dy);
    else {
        gather_stratified_radiance(cells, dx, dy);
        gather_solid_angle_radiance(cells, false, gather_layout_rays(cells->layout), dx, dy);
    }
}

// What is projected when every second cell counts negatively: signal cancels, noise does not.
static void project_noise(const struct gather_layout *l, struct gather_scratch *scratch,
                          float weight, float *noise) {
    const size_t n2 = (size_t)(l->order * l->order);
    const size_t even = gather_layout_rays(l), count = even + scratch->guide.made;
    float sum[3 * RSH_MAX_COEFFICIENTS] = {0};
    for (int j = 0; j < l->M; j++)
        for (int k = 0; k < l->N; k++) {
            size_t i = (size_t)(j * l->N + k);
            float L = weight * rgb_luminance(scratch->rays[i].L);
            scratch->r[i] = (j + k) & 1 ? -L : L;
        }
    for (size_t i = even; i < count; i++) {
        float L = weight * rgb_luminance(scratch->rays[i].L);
        scratch->r[i] = i & 1 ? -L : L;
    }
    for (size_t i = 0; i < count; i++) scratch->g[i] = scratch->b[i] = 0.0f;
    rsh_project(l->basis == SATIN_HSH ? RSH_HEMISPHERE : RSH_SPHERE, l->order, (int)count,
                scratch->x, scratch->y, scratch->z, scratch->r, scratch->g, scratch->b, sum);
    memcpy(noise, sum, n2 * sizeof *noise);
}

void gather_hemisphere_radiance(const struct gather *g, const struct gather_layout *layout,
                                struct gather_scratch *scratch, const struct gather_site *site,
                                struct gather_radiance *out) {
    const size_t n2 = (size_t)(layout->order * layout->order);
    const size_t count = trace(g, layout, scratch, site);
    const float weight = 2.0f * PI_F / (float)gather_layout_rays(layout);
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
    out->rays = (uint32_t)count;
    const struct gather_cells cells = {layout, &site->frame, scratch};
    if (out->dx) radiance_gradients(&cells, g->options->radiance_gradients, out->dx, out->dy);
    if (out->noise) project_noise(layout, scratch, weight, out->noise);  // overwrites radiance
}

rgb gather_hemisphere_reflected(const struct gather_layout *layout,
                                const struct gather_scratch *scratch, const struct brdf *brdf,
                                vec3 wo, unsigned lobes) {
    const size_t even = gather_layout_rays(layout), count = even + scratch->guide.made;
    rgb sum = rgb_grey(0.0f);
    for (size_t i = 0; i < count; i++) {
        const vec3 wi = v3(scratch->x[i], scratch->y[i], scratch->z[i]);
        const rgb f = brdf_eval(brdf, wo, wi, lobes);
        sum = rgb_fma(sum, rgb_scale(f, wi.z), scratch->rays[i].L);
    }
    return rgb_scale(sum, 2.0f * PI_F / (float)even);
}
