// SPDX-License-Identifier: Apache-2.0
// A hemisphere of gather rays: computes irradiance, or incident radiance in harmonics [K05 (4.9)],
// with the gradients that the options select. If the interpolation uses no gradients, they still
// limit the records' radii.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "gather/gather_cluster_rays.h"
#include "gather/gather_gradients.h"
#include "gather/gather_lobe_rays.h"
#include "rsh/rsh.h"

// A lobe that is sharper than the solid angle of a ray is hit by few neighbouring rays, and there
// dominates the whole hemisphere, as the reflection of a lamp in a polished ceiling. For records it
// is made as wide as that solid angle, because facets of roughness alpha spread light by about 2
// alpha to each side [after Kaplanyan and Dachsbacher 2013]. The effect vanishes as rays become
// many. This is the limit, which applies to 20 rays and fewer.
static const float ALPHA_LEAST_MOST = 0.3f;

float gather_alpha_least(const struct gather_site *site, float spread) {
    return site->record ? minf(0.5f * spread, ALPHA_LEAST_MOST) : 0.0f;
}

// ---- Memory -------------------------------------------------------------------------------------

struct gather_hemisphere *gather_hemisphere_new(size_t rays) {
    struct gather_hemisphere *h = calloc(1, sizeof *h);
    if (!h) return NULL;
    const size_t capacity = rays + rays / 2;
    h->ray = array_new(capacity, sizeof *h->ray);
    h->L = array_new(capacity, sizeof *h->L);
    h->x = array_new(13 * capacity, sizeof *h->x);
    if (!h->ray || !h->L || !h->x) {
        gather_hemisphere_free(h);
        return NULL;
    }
    h->y = h->x + capacity;
    h->z = h->y + capacity;
    h->r = h->z + capacity;
    h->g = h->r + capacity;
    h->b = h->g + capacity;
    h->weight = h->b + capacity;
    h->work = h->weight + capacity;
    return h;
}

void gather_hemisphere_free(struct gather_hemisphere *hemisphere) {
    if (!hemisphere) return;
    free(hemisphere->ray);
    free(hemisphere->L);
    free(hemisphere->x);
    free(hemisphere);
}

struct gather_worker *gather_workers_new(struct parallel *pool, size_t rays) {
    const int count = pool ? parallel_threads(pool) : 1;
    struct gather_worker *workers = calloc((size_t)count, sizeof *workers);
    for (int i = 0; workers && i < count; i++) {
        workers[i].scratch = gather_scratch_new(pool, i);
        workers[i].hemisphere = gather_hemisphere_new(rays);
        workers[i].singles = gather_singles_new();
        if (workers[i].scratch && workers[i].hemisphere && workers[i].singles) continue;
        gather_workers_free(workers, count);
        return NULL;
    }
    return workers;
}

void gather_workers_free(struct gather_worker *workers, int count) {
    for (int i = 0; workers && i < count; i++) {
        gather_scratch_free(workers[i].scratch);
        gather_hemisphere_free(workers[i].hemisphere);
        gather_singles_free(workers[i].singles);
    }
    free(workers);
}

// ---- Tracing ------------------------------------------------------------------------------------

void gather_hemisphere_begin(struct gather_hemisphere *h, const struct gather_layout *layout,
                             const struct frame *frame) {
    h->layout = layout;
    h->frame = *frame;
    h->stratified = h->count = h->all = gather_layout_rays(layout);
}

// Makes one jittered ray per stratum, row by row.
static void make_stratified_rays(const struct gather *g, const struct gather_site *site,
                                 struct gather_hemisphere *h) {
    const struct gather_layout *l = h->layout;
    struct rng rng = rng_make(g->options->seed, RNG_GATHER, site->stream);
    const float spread =
        g->options->texture_filter ? sqrtf(2.0f * PI_F / (float)h->stratified) : 0.0f;
    size_t i = 0;
    for (int j = 0; j < l->M; j++)
        for (int k = 0; k < l->N; k++, i++) {
            struct gather_ray *out = &h->ray[i];
            float u = sample_stratum(j, rng_float(&rng), l->M);
            float v = sample_stratum(k, rng_float(&rng), l->N);
            vec3 w =
                l->order ? sample_uniform_hemisphere(1.0f - u, v) : sample_cosine_hemisphere(u, v);
            h->x[i] = w.x;
            h->y[i] = w.y;
            h->z[i] = w.z;
            out->ray = scene_spawn(g->scene, site->p, site->ng, frame_to_world(&site->frame, w));
            out->item = (uint32_t)i;
            out->spread = spread;
            out->alpha_least = gather_alpha_least(site, spread);
            out->lit = NULL;
        }
}

void gather_hemisphere_trace(const struct gather *g, const struct gather_layout *layout,
                             const struct gather_site *site, struct gather_scratch *scratch,
                             struct gather_hemisphere *h) {
    struct gather_cluster_rays clusters;
    gather_hemisphere_begin(h, layout, &site->frame);
    make_stratified_rays(g, site, h);
    gather_cluster_rays_add(g, site, h, &clusters);
    gather_lobe_rays_add(g, site, &clusters, h);
    gather_rays_guided(g, scratch, h->ray, h->all, site->stream, &clusters.near);
    for (size_t i = 0; i < h->all; i++)
        h->L[i] = i < h->count ? rgb_scale(h->ray[i].L, gather_cluster_rays_weight(&clusters, h, i))
                               : h->ray[i].L;
    if (!layout->order) return;
    const float solid_angle = 2.0f * PI_F / (float)h->stratified;
    for (size_t i = 0; i < h->all; i++) {
        const rgb L = rgb_scale(h->L[i], solid_angle);
        h->r[i] = L.r;
        h->g[i] = L.g;
        h->b[i] = L.b;
    }
}

// ---- Irradiance ---------------------------------------------------------------------------------

// A rotation of the normal about the axis across a column changes E by the integral of
// sin^2(theta).
static void rotation_gradient(const struct gather_hemisphere *h, vec3 grad[3]) {
    const struct gather_layout *l = h->layout;
    for (int k = 0; k < l->N; k++) {
        const rgb *L = h->L + k;
        const vec3 axis = v3(-l->sin_k[k], l->cos_k[k], 0.0f);
        rgb change = rgb_grey(0.0f);
        for (int j = 0; j < l->M; j++, L += l->N) change = rgb_mad(change, *L, l->rotation[j]);
        gather_gradient_add(grad, change, axis);
    }
    // Guided rays: by the derivative of the cosine, each for pi / stratified of cos(theta) Omega.
    for (size_t i = h->stratified; i < h->count; i++) {
        float weight = PI_F / (float)h->stratified / h->z[i];
        gather_gradient_add(grad, rgb_scale(h->L[i], weight), v3(-h->y[i], h->x[i], 0.0f));
    }
}

static void irradiance_gradients(const struct gather_hemisphere *h, satin_gradients kind,
                                 vec3 grad[3]) {
    if (kind == SATIN_GRADIENTS_SOLID_ANGLE || kind == SATIN_GRADIENTS_DIFFERENCES)
        gather_solid_angle_irradiance(h, kind == SATIN_GRADIENTS_DIFFERENCES, 0, grad);
    else {
        gather_stratified_irradiance(h, kind == SATIN_GRADIENTS_WARD_HECKBERT, grad);
        gather_solid_angle_irradiance(h, false, h->stratified, grad);
    }
}

void gather_hemisphere_irradiance(const struct gather_hemisphere *h, satin_gradients gradients,
                                  struct cache_irradiance_value *out) {
    *out = (struct cache_irradiance_value){.rays = (uint32_t)h->count};
    for (size_t i = 0; i < h->count; i++) out->E = rgb_add(out->E, h->L[i]);
    out->E = rgb_scale(out->E, PI_F / (float)h->stratified);
    irradiance_gradients(h, gradients, out->grad_t);
    rotation_gradient(h, out->grad_r);
    for (int c = 0; c < 3; c++) {
        out->grad_t[c] = frame_to_world(&h->frame, out->grad_t[c]);
        out->grad_r[c] = frame_to_world(&h->frame, out->grad_r[c]);
    }
}

// ---- Radiance -----------------------------------------------------------------------------------

static void radiance_gradients(const struct gather_hemisphere *h, satin_gradients kind, float *dx,
                               float *dy) {
    const size_t n2 = (size_t)(h->layout->order * h->layout->order);
    memset(dx, 0, sizeof *dx * 3 * n2);
    memset(dy, 0, sizeof *dy * 3 * n2);
    if (kind == SATIN_GRADIENTS_SOLID_ANGLE || kind == SATIN_GRADIENTS_DIFFERENCES)
        gather_solid_angle_radiance(h, kind == SATIN_GRADIENTS_DIFFERENCES, 0, dx, dy);
    else {
        gather_stratified_radiance(h, dx, dy);
        gather_solid_angle_radiance(h, false, h->stratified, dx, dy);
    }
}

static void project(const struct gather_hemisphere *h, const float *r, const float *g,
                    const float *b, float *lambda) {
    const struct gather_layout *l = h->layout;
    const rsh_samples samples = {h->all, h->x, h->y, h->z, r, g, b};
    rsh_project(brdf_rsh_basis(l->basis), l->order, &samples, lambda);
}

static void project_weighted(const struct gather_hemisphere *h, float *lambda) {
    if (h->all == h->count) {
        project(h, h->r, h->g, h->b, lambda);
        return;
    }
    float *r = h->work, *g = r + h->all, *b = g + h->all;
    for (size_t i = 0; i < h->all; i++) {
        r[i] = h->weight[i] * h->r[i];
        g[i] = h->weight[i] * h->g[i];
        b[i] = h->weight[i] * h->b[i];
    }
    project(h, r, g, b, lambda);
}

// Projects with negative weight for every second stratum: the signal cancels, the noise does not.
static void project_noise(const struct gather_hemisphere *h, float *noise) {
    const struct gather_layout *l = h->layout;
    const float weight = 2.0f * PI_F / (float)h->stratified;
    float *value = h->work, *zero = h->work + h->all;
    float sum[3 * RSH_MAX_COEFFICIENTS] = {0};
    for (size_t i = 0; i < h->all; i++) {
        value[i] = weight * gather_hemisphere_weight(h, i) * rgb_luminance(h->L[i]);
        zero[i] = 0.0f;
    }
    for (int j = 0; j < l->M; j++)
        for (int k = 1 - j % 2; k < l->N; k += 2) value[j * l->N + k] *= -1.0f;
    for (size_t i = h->stratified | 1; i < h->all; i += 2) value[i] *= -1.0f;
    project(h, value, zero, zero, sum);
    memcpy(noise, sum, (size_t)(l->order * l->order) * sizeof *noise);
}

void gather_hemisphere_radiance(const struct gather_hemisphere *h, satin_gradients gradients,
                                struct gather_radiance *out) {
    const size_t n2 = (size_t)(h->layout->order * h->layout->order);
    memset(out->lambda, 0, sizeof *out->lambda * 3 * n2);
    project_weighted(h, out->lambda);
    out->rays = (uint32_t)h->all;
    if (out->dx) radiance_gradients(h, gradients, out->dx, out->dy);
    if (out->noise) project_noise(h, out->noise);
}

rgb gather_hemisphere_reflected(const struct gather_hemisphere *h, const struct brdf *brdf, vec3 wo,
                                unsigned lobes) {
    rgb sum = rgb_grey(0.0f);
    for (size_t i = 0; i < h->all; i++) {
        const vec3 wi = v3(h->x[i], h->y[i], h->z[i]);
        const rgb f = brdf_eval(brdf, wo, wi, lobes);
        sum = rgb_fma(sum, rgb_scale(f, gather_hemisphere_weight(h, i) * wi.z), h->L[i]);
    }
    return rgb_scale(sum, 2.0f * PI_F / (float)h->stratified);
}
