// SPDX-License-Identifier: Apache-2.0
// What an eye ray sees beside the light: the first surface, and features, which a denoiser reads.
// Those of a mirror or a pane are of what it shows.
#include "shade/shade_eye.h"

struct shade_surface shade_surface_of(const struct shading_point *p) {
    const rgb albedo = p->lobes ? brdf_albedo(&p->brdf, p->wo_l, BRDF_ALL) : rgb_grey(0.0f);
    return (struct shade_surface){albedo, shade_facing_normal(p), p->interaction.t, 1.0f};
}

float shade_find_surface(const struct shade *shade, int x, int y, uint32_t index,
                         struct shade_surface *first, struct shade_surface *shown) {
    const struct satin_scene *scene = shade->g->scene;
    const struct sampler begin = shade_eye_sampler(shade->g, x, y, index, RNG_FEATURE);
    struct sampler sampler = begin;
    struct shade_camera_sample camera;
    const struct ray ray = shade_eye_ray(shade, x, y, &sampler, &camera);
    struct interaction s;
    *first = (struct shade_surface){.alpha = shade_coverage(shade, false)};
    if (shown) *shown = *first;
    if (!scene_intersect(scene, &ray, &s)) return camera.weight;
    struct shading_point point;
    s.footprint = shade->sharpness * camera.spread * s.t;
    scene_shading_point_of(scene, scene_draw_component(scene, &s, v3_neg(ray.d)), &s, ray.d,
                           &point);
    *first = shade_surface_of(&point);
    if (shown) *shown = *first;
    if (!shown || point.lobes & BRDF_SMOOTH) return camera.weight;
    struct shade_eye eye;
    sampler = begin;
    shade_eye_trace(shade, x, y, &sampler, &eye);
    shade_find_shown(&eye, shown);
    return camera.weight;
}

void shade_features_add(const struct shading_point *p, rgb T, struct shade_features *sum) {
    const rgb albedo = brdf_albedo(&p->brdf, p->wo_l, BRDF_ALL);
    sum->albedo = rgb_fma(sum->albedo, T, albedo);
    sum->normal = rgb_mad(sum->normal, shade_facing_normal(p), rgb_max(T));
}

struct shade_features shade_features_of(const struct shade_eye *eye) {
    struct shade_features sum = {0};
    if (eye->hit && (eye->first.lobes & BRDF_SMOOTH)) {
        shade_features_add(&eye->first, rgb_grey(1.0f), &sum);
        return sum;
    }
    for (int i = 0; i < eye->count; i++)
        shade_features_add(&eye->vertex[i].point, eye->vertex[i].T, &sum);
    return sum;
}

void shade_find_shown(const struct shade_eye *eye, struct shade_surface *out) {
    if (!eye->hit || (eye->first.lobes & BRDF_SMOOTH) || eye->count == 0) return;
    const struct shade_vertex *most = eye->vertex;
    for (int i = 1; i < eye->count; i++)
        if (rgb_max(eye->vertex[i].T) > rgb_max(most->T)) most = &eye->vertex[i];
    *out = shade_surface_of(&most->point);
    out->albedo = rgb_mul(out->albedo, most->T);
    out->depth = most->distance;
}

float shade_find_features(const struct shade *shade, int x, int y, uint32_t index,
                          struct shade_features *out) {
    struct sampler sampler = shade_eye_sampler(shade->g, x, y, index, RNG_FEATURE);
    struct shade_eye eye;
    shade_eye_trace(shade, x, y, &sampler, &eye);
    *out = shade_features_of(&eye);
    return eye.camera.weight;
}
