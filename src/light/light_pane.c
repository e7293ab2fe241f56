// SPDX-License-Identifier: Apache-2.0
// Light through panes: which specular chains preserve the direction of light, and shadow rays that
// follow such chains. A shadow ray towards a direction, such as the sky's, is refracted at each
// surface like any ray; a shadow ray towards a point is aimed again until it hits the point.
#include "light/light.h"

enum {
    PANES_MAX = 32,  // largest number of surfaces that a shadow ray passes
    AIMS = 3  // each reduces the miss by a factor of distance over the pane's shift, some hundred
};
// A shadow ray that misses by less than this fraction of its length is accepted: a tenth of what
// counts as parallel.
static const float AIMED = 1e-4f;

// Directions that differ by less are parallel [rad]. Panes of real scenes are parallel to 1e-5 by
// the six digits of their corners, and a lens or a waved pane deflects most light by more than
// 1e-2.
static const float PARALLEL = 1e-3f;

static bool is_parallel(vec3 a, vec3 b) { return v3_dist2(a, b) < PARALLEL * PARALLEL; }

// Whether the surface may belong to a pane: it is flat, or a thin sheet of any form, and not
// blended with other BRDFs, which rays pass at random.
static bool may_be_pane(const struct satin_scene *scene, const struct interaction *s, vec3 wo) {
    if (s->light >= 0) return false;
    struct scene_component component[MATERIAL_COMPONENTS_MAX];
    if (scene_components(scene, s, wo, component) != 1) return false;
    if (component[0].side->base.model->thin) return true;
    const enum shape_kind kind = scene->shape[s->shape].kind;
    return kind == SHAPE_DISK || (kind == SHAPE_MESH && is_parallel(s->frame.n, s->ng));
}

// Whether the shading normals of some triangle of the mesh do not vary. Those of drinking glasses
// and lenses vary, so that shadow rays need not test what they hit there.
static bool has_flat_triangle(const struct mesh *mesh) {
    if (!mesh->normal) return mesh->triangle_count > 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *index = mesh->index + 3 * (size_t)i;
        vec3 n[3];
        for (int k = 0; k < 3; k++) {
            const float *normal = mesh->normal + 3 * (size_t)index[k];
            n[k] = v3(normal[0], normal[1], normal[2]);
        }
        if (is_parallel(n[0], n[1]) && is_parallel(n[0], n[2])) return true;
    }
    return false;
}

bool light_has_panes(const struct satin_scene *scene) {
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->kind == SHAPE_INSTANCE) continue;
        const struct material_side *side = &scene->material[shape->material].front;
        const struct brdf *b = &side->base;
        if (side->component[0] || !(b->model->lobes & BRDF_DELTA) || !brdf_transmits(b)) continue;
        const bool flat = shape->kind == SHAPE_DISK ||
                          (shape->kind == SHAPE_MESH && has_flat_triangle(&shape->mesh));
        if (flat || b->model->thin) return true;
    }
    return false;
}

// ---- Chains -------------------------------------------------------------------------------------

struct light_chain light_chain_begin(vec3 d) {
    return (struct light_chain){
        .d = d, .transmits = true, .sagittal_rate = 1.0f, .tangential_rate = 1.0f};
}

void light_chain_advance(struct light_chain *chain, float length) {
    chain->sagittal += chain->sagittal_rate * length;
    chain->tangential += chain->tangential_rate * length;
}

// By Snell's law sin(theta) / eta is preserved; its derivative gives the tangential rate.
static void pass_pane(struct light_chain *chain, vec3 wo_l, const struct brdf_sample *next) {
    chain->crossed++;
    chain->sagittal_rate /= next->eta;
    chain->tangential_rate *= sqrf(wo_l.z) / (next->eta * fmaxf(sqrf(next->wi.z), 1e-12f));
}

void light_chain_pass(struct light_chain *chain, const struct satin_scene *scene,
                      const struct interaction *s, vec3 wo, vec3 wo_l,
                      const struct brdf_sample *next) {
    if (!chain->transmits) return;
    const bool through = (next->lobe & BRDF_DELTA) && wo_l.z * next->wi.z < 0.0f;
    chain->transmits = through && chain->crossed < PANES_MAX && may_be_pane(scene, s, wo);
    if (chain->transmits) pass_pane(chain, wo_l, next);
}

bool light_chain_straight(const struct light_chain *chain, vec3 d) {
    return chain->transmits && is_parallel(chain->d, d);
}

rgb light_chain_emitted(const struct light_chain *chain, const struct satin_scene *scene,
                        const struct interaction *hit, vec3 d) {
    return light_at_hit(scene, hit, !hit && light_chain_straight(chain, d) ? chain->d : d);
}

vec3 light_chain_beside(const struct light_chain *chain, vec3 p, vec3 q) {
    if (!chain->crossed) return p;
    return v3_mad(q, -v3_dot(v3_sub(q, p), chain->d), chain->d);
}

float light_chain_density(const struct light_chain *chain, float dist) {
    return chain->crossed ? chain->sagittal * chain->tangential / (dist * dist) : 1.0f;
}

// ---- Shadow rays --------------------------------------------------------------------------------

// The state of a shadow ray that passes through panes.
struct pane_path {
    const struct satin_scene *scene;
    int panes;  // number of surfaces that it may still pass
    struct light_chain chain;
    rgb T;
    vec3 p, ng;  // the last surface
};

// Passes the surface s that a ray along d has hit, and sets *d to the direction behind it. False if
// the ray is stopped.
static bool pass_surface(struct pane_path *path, const struct interaction *s, vec3 *d) {
    const vec3 wo = v3_neg(*d);
    struct brdf b;
    struct frame frame;
    struct brdf_sample lobe[2];
    if (path->chain.crossed >= path->panes || path->chain.crossed >= PANES_MAX) return false;
    if (!may_be_pane(path->scene, s, wo) || !scene_brdf(path->scene, s, wo, &b, &frame))
        return false;
    if (!(brdf_lobes(&b) & BRDF_DELTA)) return false;
    const vec3 wo_l = frame_to_local(&frame, wo);
    const int lobes = brdf_delta(&b, wo_l, BRDF_RADIANCE, lobe);
    for (int i = 0; i < lobes; i++) {
        if (!(lobe[i].wi.z * wo_l.z < 0.0f)) continue;
        light_chain_advance(&path->chain, s->t);
        pass_pane(&path->chain, wo_l, &lobe[i]);
        path->T = rgb_mul(path->T, lobe[i].weight);
        path->p = s->p;
        path->ng = s->ng;
        *d = frame_to_world(&frame, lobe[i].wi);
        return !rgb_black(path->T);
    }
    return false;
}

static struct pane_path pane_path_begin(const struct satin_scene *scene, int panes, vec3 d) {
    return (struct pane_path){
        .scene = scene, .panes = panes, .chain = light_chain_begin(d), .T = rgb_grey(1.0f)};
}

// Continues from the hit s of a ray along d to the first surface that is not of a pane, in *s; *hit
// is false if there is none. Returns false if the ray is stopped before that.
static bool pane_path_continue(struct pane_path *path, struct interaction *s, vec3 *d, bool *hit) {
    for (*hit = true; *hit;) {
        if (s->light >= 0) break;
        if (!pass_surface(path, s, d)) return false;
        struct ray ray = scene_spawn(path->scene, path->p, path->ng, *d);
        *hit = scene_intersect(path->scene, &ray, s);
    }
    return is_parallel(path->chain.d, *d);
}

// Follows a ray towards a sample's point, behind the pane of which s is a surface. *miss is set to
// the distance by which the end of the path misses the point; the path may end on another point of
// the same light. False if the ray is stopped before.
static bool pane_path_to_point(struct pane_path *path, struct interaction s, vec3 d,
                               const struct light_sample *to, vec3 *miss) {
    while (pass_surface(path, &s, &d)) {
        const vec3 left = v3_sub(to->p, path->p);
        const float along = v3_dot(left, d);
        const bool outside = is_parallel(path->chain.d, d);
        struct ray ray = scene_spawn(path->scene, path->p, path->ng, d);
        if (outside) {
            if (!(along > 0.0f)) return false;
            *miss = v3_sub(v3_mul(d, along), left);
            ray = scene_spawn_to(path->scene, path->p, path->ng, v3_add(to->p, *miss), to->n);
        }
        if (scene_intersect(path->scene, &ray, &s) && !(outside && s.light == (int32_t)to->light))
            continue;
        light_chain_advance(&path->chain, along);
        return outside;
    }
    return false;
}

// Tests a light sample at a point. Panes shift the light, as if it were visible from beside p: the
// sample is drawn again from there.
static bool arrives_from_point(const struct satin_scene *scene, vec3 p, vec3 ng, int panes,
                               struct interaction first, struct light_sample *s) {
    struct ray ray = light_shadow_ray(scene, p, ng, s);
    vec3 beside = v3(0, 0, 0);
    struct pane_path path;
    for (int i = 0;; i++) {
        vec3 miss = v3(0, 0, 0);
        path = pane_path_begin(scene, panes, ray.d);
        if (!pane_path_to_point(&path, first, ray.d, s, &miss)) return false;
        if (i + 1 == AIMS || v3_dot(miss, miss) <= sqrf(AIMED * s->dist)) break;
        beside = v3_add(beside, miss);
        if (!light_sample_wi(scene, s->light, v3_add(p, beside), s->u, s->v, s)) return false;
        ray = scene_spawn(scene, p, ng, s->wi);
        if (!scene_intersect(scene, &ray, &first)) return false;
    }
    s->L = rgb_mul(s->L, path.T);
    s->pdf_w *= light_chain_density(&path.chain, s->dist);
    return true;
}

bool light_arrives(const struct satin_scene *scene, vec3 p, vec3 ng, int panes,
                   struct light_sample *s) {
    struct ray ray = light_shadow_ray(scene, p, ng, s);
    if (!scene->panes || panes <= 0) return !scene_occluded(scene, &ray);
    struct interaction first;
    if (!scene_intersect(scene, &ray, &first)) return true;
    if (isfinite(s->dist)) return arrives_from_point(scene, p, ng, panes, first, s);
    struct pane_path path = pane_path_begin(scene, panes, s->wi);
    vec3 d = s->wi;
    bool hit;
    if (!pane_path_continue(&path, &first, &d, &hit) || hit) return false;
    s->L = rgb_mul(s->L, path.T);
    return true;
}

bool light_find(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d, int panes,
                struct light_found *out) {
    struct interaction *hit = &out->hit;
    struct ray ray = scene_spawn(scene, p, ng, d);
    struct pane_path path = pane_path_begin(scene, panes, d);
    bool met = scene_intersect(scene, &ray, hit);
    if (met && !pane_path_continue(&path, hit, &d, &met)) return false;
    if (met) light_chain_advance(&path.chain, hit->t);
    if (!met && scene->environment < 0) return false;
    const rgb L = light_chain_emitted(&path.chain, scene, met ? hit : NULL, d);
    out->chain = path.chain;
    out->L = rgb_mul(path.T, L);
    out->environment = !met;
    return true;
}
