// SPDX-License-Identifier: Apache-2.0
// Computes one sample of one pixel by the selected integrator.
#include "shade/shade.h"

#include <stdlib.h>

#include "shade/shade_aov.h"
#include "shade/shade_two_pass.h"

satin_status shade_init(struct shade *shade, const struct gather *g, struct cache_reader records,
                        struct shade_missing missing, struct parallel *pool) {
    const satin_options *o = g->options;
    struct shade s = {.g = g, .camera = &g->scene->camera, .records = records, .missing = missing};
    scene_film_filter_make(&g->scene->film, &s.filter);
    // The footprint of a pixel is divided among its samples.
    if (o->texture_filter) s.sharpness = 1.0f / sqrtf((float)(o->spp > 1 ? o->spp : 1));
    s.gather = gather_layout_new(missing.hemisphere, o->radiance_basis, 0);
    s.worker_count = parallel_threads(pool);
    if (s.gather) s.worker = gather_workers_new(pool, gather_layout_rays(s.gather));
    if (!s.worker) {
        shade_destroy(&s);
        return SATIN_ERROR_MEMORY;
    }
    *shade = s;
    return SATIN_OK;
}

void shade_destroy(struct shade *shade) {
    gather_layout_free(shade->gather);
    gather_workers_free(shade->worker, shade->worker_count);
    *shade = (struct shade){0};
}

// Sets the channels that are not light, from the first surface.
static void surface_channels(const struct shade *shade, const struct shading_point *p,
                             const struct shade_camera_sample *camera, struct shade_sample *out) {
    const struct shade_surface surface = shade_surface_of(p);
    out->layer[SHADE_ALBEDO] = surface.albedo;
    out->layer[SHADE_NORMAL] = surface.normal;
    out->depth = surface.depth;
    out->shown = surface;
    out->shape = p->interaction.shape + 1;
    out->instance = p->interaction.instance;
    if (shade->g->scene->hints.aovs.count) shade_aov(shade, p, camera, out->aov);
}

float shade_coverage(const struct shade *shade, bool hit) {
    return hit || (shade->g->scene->environment >= 0 && shade->g->options->hide_emitters <= 0);
}

// Sets the channels of the scene that depend on the sum of the light.
static void set_light_channels(const struct shade *shade, struct shade_sample *out) {
    const struct scene_aovs *aovs = &shade->g->scene->hints.aovs;
    if (aovs->moment) shade_aov_light(aovs, out->beauty, out->aov);
}

// Integrator photons: all light at the point from the photon map, while emitted and mirrored light
// is added separately.
static void add_photon_radiance(struct shade_lighting *lighting) {
    const struct gather *g = lighting->shade->g;
    const struct shading_point *p = &lighting->vertex->point;
    float radius;
    const int bounces = photon_bounces_left(g->options, lighting->vertex->depth);
    rgb L = photon_radiance(g->maps, g->scene, p, BRDF_REFLECT, bounces, &radius);
    rgb *layer = &lighting->out->layer[SHADE_INDIRECT_DIFFUSE];
    *layer = rgb_fma(*layer, lighting->vertex->T, L);
}

// Without final gathering, all light at the point is what gather rays read there.
static void add_first_pass(struct shade_lighting *lighting) {
    const struct shade_vertex *v = lighting->vertex;
    const rgb L = gather_first_pass(lighting->shade->g, lighting->worker->gather.scratch, &v->point,
                                    v->depth, lighting->sampler);
    lighting->worker->counts.points++;
    shade_add_uncached(lighting, SHADE_INDIRECT_DIFFUSE, L);
}

static void path_sample(const struct shade *shade, int x, int y, uint32_t index,
                        struct shade_sample *out) {
    struct sampler sampler = shade_eye_sampler(shade->g, x, y, index, RNG_PATH);
    struct shade_camera_sample camera;
    struct gather_eye_hit seen;
    struct ray ray = shade_eye_ray(shade, x, y, &sampler, &camera);
    out->beauty = gather_path_eye(shade->g, ray, &sampler, &seen);
    out->layer[SHADE_EMISSION] = seen.emission;
    out->uncached = rgb_sub(out->beauty, seen.emission);
    if (seen.hit) surface_channels(shade, &seen.point, &camera, out);
    if (shade->g->options->denoise && !rgb_black(seen.T))
        shade_features_add(&seen.smooth, seen.T, &out->features);
    out->alpha = shade_coverage(shade, seen.hit);
    set_light_channels(shade, out);
    out->weight = camera.weight;
}

void shade_pixel(const struct shade *shade, struct shade_worker *worker, int x, int y,
                 uint32_t index, struct shade_sample_counts samples, struct shade_sample *out) {
    const satin_options *o = shade->g->options;
    *out = (struct shade_sample){0};
    worker->counts.samples++;
    if (gather_traces_paths(o)) {
        path_sample(shade, x, y, index, out);
        return;
    }
    struct shade_eye eye;
    struct sampler sampler = shade_eye_sampler(shade->g, x, y, index, RNG_PIXEL);
    shade_eye_trace(shade, x, y, &sampler, &eye);
    if (eye.hit) surface_channels(shade, &eye.first, &eye.camera, out);
    if (o->denoise) out->features = shade_features_of(&eye);
    if (o->noise_filter) shade_find_shown(&eye, &out->shown);
    out->alpha = shade_coverage(shade, eye.hit);
    out->layer[SHADE_EMISSION] = eye.emission;
    for (int i = 0; i < eye.count; i++) {
        uint64_t pixel = rng_mix((uint64_t)sampler.seed + (uint64_t)i);
        // The i-th vertex has its own dimensions, independent of those used before.
        struct sampler own = {index, sampler.seed, 64u * (uint32_t)(i + 1)};
        struct shade_lighting lighting = {
            shade, &eye.vertex[i],   worker, own, samples, rng_mix(pixel + index), pixel,
            out,   LIGHT_ALL_VISIBLE};
        if (o->integrator == SATIN_PHOTONS)
            add_photon_radiance(&lighting);
        else if (o->integrator == SATIN_TWO_PASS && !o->final_gather)
            add_first_pass(&lighting);
        else
            shade_vertex_two_pass(&lighting);
    }
    for (int layer = SHADE_DIRECT; layer <= SHADE_EMISSION; layer++)
        out->beauty = rgb_add(out->beauty, out->layer[layer]);
    set_light_channels(shade, out);
    out->weight = eye.camera.weight;
}

rgb shade_emission(const struct shade *shade, int x, int y, uint32_t index, float *weight) {
    const struct sampler begin = shade_eye_sampler(shade->g, x, y, index, RNG_RIM);
    struct sampler sampler = begin;
    rgb Le;
    if (shade_eye_emission(shade, x, y, &sampler, &Le, weight)) return Le;
    struct shade_eye eye;
    sampler = begin;
    shade_eye_trace(shade, x, y, &sampler, &eye);
    *weight = eye.camera.weight;
    return eye.emission;
}
