// SPDX-License-Identifier: Apache-2.0
// Surfaces of panes, and rays that pass them.
#include "light/light_pane_ray.h"

// ---- Which surfaces are panes' ------------------------------------------------------------------

bool light_is_flat(const struct mesh *mesh, uint32_t triangle) {
    if (!mesh->normal) return true;
    const uint32_t *index = mesh->index + 3 * (size_t)triangle;
    vec3 n[3];
    for (int k = 0; k < 3; k++) {
        const float *normal = mesh->normal + 3 * (size_t)index[k];
        n[k] = v3(normal[0], normal[1], normal[2]);
    }
    return light_is_parallel(n[0], n[1]) && light_is_parallel(n[0], n[2]);
}

bool light_may_be_pane(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                       bool *curved) {
    *curved = false;
    if (s->light >= 0) return false;
    struct scene_component component[MATERIAL_COMPONENTS_MAX];
    if (scene_components(scene, s, wo, component) != 1) return false;
    if (component[0].side->base.model->thin) return true;
    const struct shape *shape = &scene->shape[s->shape];
    if (shape->kind == SHAPE_DISK) return true;
    if (shape->kind == SHAPE_MESH && light_is_parallel(s->frame.n, s->ng) &&
        (!shape->deflects_little || light_is_flat(&shape->mesh, s->prim)))
        return true;
    return *curved = shape->deflects_little;
}

// ---- Rays through panes -------------------------------------------------------------------------

struct pane_ray light_pane_ray_begin(const struct satin_scene *scene, vec3 o, vec3 d, int panes) {
    return (struct pane_ray){.scene = scene,
                             .ray = {o, 0.0f, d, INFINITY},
                             .T = rgb_grey(1.0f),
                             .eta = 1.0f,
                             .panes = panes < PANES_MAX ? panes : PANES_MAX};
}

void light_pane_ray_advance(struct pane_ray *ray, float length) {
    for (int i = 0; i < 2; i++) ray->dp[i] = v3_mad(ray->dp[i], length, ray->dd[i]);
}

// The derivatives behind a surface with normal m on the side of the ray, whose refracted direction
// is d / eta + (cos / eta - cos_t) m.
static void refract_bundle(struct pane_ray *ray, const struct interaction *s, vec3 m, float side,
                           bool curved, const struct brdf_sample *next) {
    const vec3 d = ray->ray.d;
    const float cosine = -v3_dot(d, m), cosine_t = fmaxf(fabsf(next->wi.z), 1e-6f);
    const float mu = cosine / next->eta - cosine_t, on_plane = v3_dot(d, s->ng);
    for (int i = 0; i < 2; i++) {
        const vec3 dp = v3_mad(ray->dp[i], -v3_dot(ray->dp[i], s->ng) / on_plane, d);
        const vec3 dd = ray->dd[i];
        const vec3 dm = curved ? v3_mul(scene_normal_change(ray->scene, s, dp), side) : v3(0, 0, 0);
        const float dcosine = -(v3_dot(dd, m) + v3_dot(d, dm));
        const float dmu = dcosine * (1.0f / next->eta - cosine / (sqrf(next->eta) * cosine_t));
        ray->dp[i] = dp;
        ray->dd[i] = v3_mad(v3_mad(v3_mul(dd, 1.0f / next->eta), mu, dm), dmu, m);
    }
}

bool light_pane_ray_pass(struct pane_ray *ray, const struct interaction *s) {
    const vec3 wo = v3_neg(ray->ray.d);
    struct brdf b;
    struct frame frame;
    struct brdf_sample lobe[2];
    bool curved;
    if (ray->crossed >= ray->panes || !light_may_be_pane(ray->scene, s, wo, &curved)) return false;
    if (!scene_brdf(ray->scene, s, wo, &b, &frame) || !(brdf_lobes(&b) & BRDF_DELTA)) return false;
    const vec3 wo_l = frame_to_local(&frame, wo);
    const int lobes = brdf_delta(&b, wo_l, BRDF_RADIANCE, lobe);
    for (int i = 0; i < lobes; i++) {
        if (!(lobe[i].wi.z * wo_l.z < 0.0f)) continue;
        const float side = wo_l.z < 0.0f ? -1.0f : 1.0f;
        if (ray->bundle) {
            light_pane_ray_advance(ray, s->t);
            refract_bundle(ray, s, v3_mul(frame.n, side),
                           v3_dot(frame.n, s->frame.n) < 0.0f ? -side : side, curved, &lobe[i]);
        }
        ray->crossed++;
        ray->eta *= lobe[i].eta;
        ray->curved = ray->curved || curved;
        ray->T = rgb_mul(ray->T, lobe[i].weight);
        ray->ray = scene_spawn(ray->scene, s->p, s->ng, frame_to_world(&frame, lobe[i].wi));
        return !rgb_black(ray->T);
    }
    return false;
}

bool light_pane_ray_continue(struct pane_ray *ray, struct interaction *s, bool *met) {
    for (*met = true; *met && s->light < 0;) {
        if (!light_pane_ray_pass(ray, s)) return false;
        *met = scene_intersect(ray->scene, &ray->ray, s);
    }
    return true;
}
