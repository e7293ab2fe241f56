// SPDX-License-Identifier: Apache-2.0
// Chains of specular surfaces, and which of them bring direct light.
#include "light/light_pane_ray.h"

struct light_chain light_chain_begin(const struct ray *ray) {
    return (struct light_chain){.o = ray->o, .d = ray->d, .transmits = true};
}

void light_chain_pass(struct light_chain *chain, const struct satin_scene *scene,
                      const struct interaction *s, vec3 wo, vec3 wo_l,
                      const struct brdf_sample *next) {
    bool curved;
    if (!chain->transmits) return;
    const bool through = (next->lobe & BRDF_DELTA) && wo_l.z * next->wi.z < 0.0f;
    chain->transmits =
        through && chain->crossed < PANES_MAX && light_may_be_pane(scene, s, wo, &curved);
    if (!chain->transmits) return;
    chain->curved = chain->curved || curved;
    chain->crossed++;
}

// Whether a chain from or to infinity, whose other end is along d, brings direct light.
static bool is_straight(const struct light_chain *chain, vec3 d) {
    return chain->transmits && !chain->curved && light_is_parallel(chain->d, d);
}

// Whether a connection between p and q begins along d, as far as the rounding of positions shows.
static bool is_same_path(const struct satin_scene *scene, const struct light_connection *found,
                         vec3 d, vec3 p, vec3 q) {
    const float rounding = scene_rounding(scene, p) + scene_rounding(scene, q);
    const float most = PARALLEL + 8.0f * rounding / sqrtf(v3_dist2(p, q));
    return v3_dist2(found->d, d) < sqrf(most);
}

bool light_chain_direct(const struct light_chain *chain, const struct satin_scene *scene, vec3 d,
                        const struct interaction *hit, struct light_connection *out) {
    *out = (struct light_connection){
        .d = chain->d, .exit = d, .T = rgb_grey(1.0f), .crossed = chain->crossed, .spread = 1.0f};
    if (!chain->transmits) return false;
    if (chain->crossed == 0) return true;
    if (!hit) return is_straight(chain, d);
    if (hit->light < 0) return false;
    const struct light_end end = {hit->p, (uint32_t)hit->light};
    return light_connect(scene, chain->o, &end, NULL, out) &&
           is_same_path(scene, out, chain->d, chain->o, hit->p);
}

bool light_chain_brings_direct(const struct light_chain *chain, const struct satin_scene *scene,
                               uint32_t light, vec3 d, const struct interaction *s) {
    if (!chain->transmits) return false;
    if (chain->crossed == 0) return true;
    if (!light_is_local(&scene->light[light])) return is_straight(chain, d);
    const vec3 back = v3_neg(d);
    const struct light_end end = {chain->o, light};
    struct light_connection found;
    return light_connect(scene, scene_spawn(scene, s->p, s->ng, back).o, &end, NULL, &found) &&
           is_same_path(scene, &found, back, s->p, chain->o);
}

rgb light_chain_emitted(const struct light_chain *chain, const struct satin_scene *scene,
                        const struct interaction *hit, vec3 d) {
    return light_at_hit(scene, hit, !hit && is_straight(chain, d) ? chain->d : d);
}

bool light_find(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d, int panes,
                struct light_found *out) {
    struct interaction *hit = &out->hit;
    const struct ray first = scene_spawn(scene, p, ng, d);
    struct pane_ray ray = light_pane_ray_begin(scene, first.o, d, panes);
    bool met = scene_intersect(scene, &first, hit);
    if (met && !light_pane_ray_continue(&ray, hit, &met)) return false;
    if (!met && scene->environment < 0) return false;
    const struct light_chain chain = {first.o, d, true, ray.curved, ray.crossed};
    const struct interaction *end = met ? hit : NULL;
    out->environment = !met;
    out->L = rgb_mul(ray.T, light_chain_emitted(&chain, scene, end, ray.ray.d));
    return light_chain_direct(&chain, scene, ray.ray.d, end, &out->connection);
}
