// SPDX-License-Identifier: Apache-2.0
// Features: what a denoiser reads beside the light. Those of a mirror or a pane are of what it
// shows.
#include "shade/shade_eye.h"

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

float shade_find_features(const struct shade *shade, int x, int y, uint32_t index,
                          struct shade_features *out) {
    struct sampler sampler = shade_eye_sampler(shade->g, x, y, index, RNG_FEATURE);
    struct shade_eye eye;
    shade_eye_trace(shade, x, y, &sampler, &eye);
    *out = shade_features_of(&eye);
    return eye.camera.weight;
}
