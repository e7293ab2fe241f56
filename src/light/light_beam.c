// SPDX-License-Identifier: Apache-2.0
// Beams: light that leaves a rectangle or a disk only along its normal. So it gives the same
// irradiance at any distance in front of the shape, and none elsewhere. Rays do not hit it by
// chance: the light sample of a point is its projection onto the shape.
#include "light/light_kinds.h"

// The texture coordinates of q in the shape's plane. False if q is outside of the shape.
static bool locate(const struct light *light, const struct shape *shape, vec3 q, vec2 *uv) {
    if (shape->kind == SHAPE_DISK) {
        vec3 l = mat4_point(&shape->to_object, q);
        float r = sqrtf(l.x * l.x + l.y * l.y);
        *uv = (vec2){r, azimuth_fraction(l.y, l.x)};
        return r <= 1.0f;
    }
    const struct light_face *face = light->face;
    const vec2 st = light_face_coordinates(face, q);
    if (!(st.x >= 0.0f && st.x <= 1.0f && st.y >= 0.0f && st.y <= 1.0f)) return false;
    if (light->texture) *uv = light_face_uv(face, &shape->mesh, st.x, st.y);
    return true;
}

bool light_beam_sample(const struct satin_scene *scene, const struct light *light, vec3 p,
                       struct light_sample *out) {
    const struct shape *shape = &scene->shape[light->shape];
    float height = v3_dot(v3_sub(p, light->position), light->direction);
    vec3 q = v3_mad(p, -height, light->direction);
    vec2 uv = {0.0f, 0.0f};
    if (!(height > 0.0f) || !locate(light, shape, q, &uv)) return false;
    struct texture_lookup at = scene_texture_at(uv);
    *out = (struct light_sample){
        .wi = v3_neg(light->direction),
        .p = q,
        .n = light->direction,
        .dist = height,
        .L = light->texture ? scene_texture_eval(light->texture, &at) : light->value,
        .pdf_w = 1.0f,
        .delta = true};
    return true;
}

float light_beam_estimate(const struct satin_scene *scene, const struct light *light, vec3 p) {
    struct light_sample sample;
    return light_beam_sample(scene, light, p, &sample) ? light->strength : 0.0f;
}

satin_status light_beam_prepare(struct satin_scene *scene, struct light *light) {
    satin_status status = light_area_prepare(scene, light);
    if (status != SATIN_OK) return status;
    const struct shape *shape = &scene->shape[light->shape];
    struct light_point point = light_area_point(scene, light, 0.5f, 0.5f);
    light->position = point.p;
    light->direction = point.n;
    light->power = light->strength;  // all the light travels in one direction
    light->strength = light->power / shape->area;
    return SATIN_OK;
}
