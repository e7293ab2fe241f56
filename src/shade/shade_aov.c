// SPDX-License-Identifier: Apache-2.0
// Values of the first surface for `aov` integrators, as Mitsuba 3 defines them.
#include "shade/shade_aov.h"

// The change of uv on the tangent plane of s from the eye ray to the one through `film`: the least
// squares solution of du dp/du + dv dp/dv = dp. 0 if the ray misses the plane or uv is degenerate.
static vec2 uv_towards(const struct shade *shade, const struct interaction *s, vec2 film,
                       vec2 lens) {
    const struct ray ray = scene_camera_ray(shade->g->scene, shade->camera, film, lens, NULL);
    const float t = v3_dot(v3_sub(s->p, ray.o), s->ng) / v3_dot(ray.d, s->ng);
    const vec3 dp = v3_sub(v3_mad(ray.o, t, ray.d), s->p), u = s->dp_du, v = s->dp_dv;
    const float uu = v3_dot(u, u), uv = v3_dot(u, v), vv = v3_dot(v, v);
    const float pu = v3_dot(u, dp), pv = v3_dot(v, dp), det = uu * vv - uv * uv;
    const vec2 d = {(vv * pu - uv * pv) / det, (uu * pv - uv * pu) / det};
    return isfinite(d.x) && isfinite(d.y) ? d : (vec2){0.0f, 0.0f};
}

// The address of the values of a kind; NULL if the scene does not need them.
static float *value_of(const struct scene_aovs *aovs, enum aov_kind kind, float *out) {
    return aovs->first[kind] >= 0 ? out + aovs->first[kind] : NULL;
}

static void set_float(float *to, float value) {
    if (to) to[0] = value;
}

static void set_vec2(float *to, vec2 v) {
    if (to) to[0] = v.x, to[1] = v.y;
}

static void set_vec3(float *to, vec3 v) {
    if (to) to[0] = v.x, to[1] = v.y, to[2] = v.z;
}

static void put_partials(const struct shade *shade, const struct interaction *s,
                         const struct shade_camera_sample *camera, float *out) {
    const struct scene_aovs *aovs = &shade->g->scene->hints.aovs;
    float *dx = value_of(aovs, AOV_DUV_DX, out), *dy = value_of(aovs, AOV_DUV_DY, out);
    set_vec3(value_of(aovs, AOV_DP_DU, out), s->dp_du);
    set_vec3(value_of(aovs, AOV_DP_DV, out), s->dp_dv);
    if (!dx && !dy) return;
    // A sample represents a fraction of the pixel's area.
    const int spp = shade->g->options->spp;
    const float side = 1.0f / sqrtf((float)(spp > 1 ? spp : 1));
    const vec2 film = camera->film, right = {film.x + side, film.y},
               below = {film.x, film.y + side};
    set_vec2(dx, uv_towards(shade, s, right, camera->at));
    set_vec2(dy, uv_towards(shade, s, below, camera->at));
}

void shade_aov_light(const struct scene_aovs *aovs, rgb L, float *out) {
    // Linear sRGB to CIE XYZ (IEC 61966-2-1).
    set_vec3(value_of(aovs, AOV_LIGHT, out),
             v3(0.412453f * L.r + 0.357580f * L.g + 0.180423f * L.b, rgb_luminance(L),
                0.019334f * L.r + 0.119193f * L.g + 0.950227f * L.b));
}

void shade_aov(const struct shade *shade, const struct shading_point *p,
               const struct shade_camera_sample *camera, float *out) {
    const struct scene_aovs *aovs = &shade->g->scene->hints.aovs;
    const struct interaction *s = &p->interaction;
    if (p->lobes && p->brdf.model->slots & 1u << BRDF_SLOT_DIFFUSE) {
        const rgb c = p->brdf.diffuse;
        set_vec3(value_of(aovs, AOV_ALBEDO, out), v3(c.r, c.g, c.b));
    }
    set_float(value_of(aovs, AOV_DEPTH, out), s->t);
    set_vec3(value_of(aovs, AOV_POSITION, out), s->p);
    set_vec2(value_of(aovs, AOV_UV, out), s->uv);
    set_vec3(value_of(aovs, AOV_GEO_NORMAL, out), s->ng);
    set_vec3(value_of(aovs, AOV_SH_NORMAL, out), s->frame.n);
    set_float(value_of(aovs, AOV_PRIM_INDEX, out), (float)s->prim);
    set_float(value_of(aovs, AOV_SHAPE_INDEX, out), (float)(s->shape + 1));
    if (aovs->partials) put_partials(shade, s, camera, out);
}
