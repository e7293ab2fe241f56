// SPDX-License-Identifier: Apache-2.0
// Follows one photon: it scatters, and is stored where a smooth lobe could reflect it. Scattering
// ends by Russian roulette with the albedo, which keeps the photons' powers equal [Jensen 2001].
// Shading normals have the factor of the adjoint BSDF [Veach 1997, 5.3.2].
#include "photon/photon_path.h"

#include "base/array.h"

// Ends paths that a mirror with albedo 1 would continue for ever.
enum { BOUNCES_MAX = 1000 };

static bool append(struct photon_stored *photons, struct photon_hit hit, enum photon_class class) {
    void *items = photons->hit;
    if (!array_reserve(&items, &photons->capacity, photons->count + 1, sizeof hit)) return false;
    photons->hit = items;
    photons->hit[photons->count++] = hit;
    photons->stored[class]++;
    return true;
}

static bool is_valid_hit(const struct photon_hit *hit) {
    return v3_finite(hit->p) && rgb_finite(hit->power) &&
           fminf(hit->power.r, fminf(hit->power.g, hit->power.b)) >= 0.0f;
}

// A direct photon that glass has deflected is a caustic one.
static enum photon_class class_of(const struct photon_path *photon) {
    const bool deflected =
        photon->class == PHOTON_DIRECT && !light_chain_straight(&photon->chain, photon->ray.d);
    return deflected ? PHOTON_CAUSTIC : photon->class;
}

// See photon_hit; n is the geometric normal on the side of wi. The shading normal is that of a
// viewer on this side, whom maps direct invalid normals to. Where it faces away from wi, the
// surface reflects to the other side at most, which has other estimates.
static int8_t tilt_by_normal(const struct satin_scene *scene, const struct interaction *s, vec3 wi,
                             vec3 n) {
    const struct material_side *side = scene_draw_component(scene, s, n);
    struct frame frame = scene_component_frame(scene, side, s, n);
    struct brdf brdf;
    if (scene_bump_used(&side->bump[0]) && !scene_component_brdf(scene, side, s, n, &brdf, &frame))
        return 0;
    const vec3 m = v3_dot(frame.n, n) < 0.0f ? v3_neg(frame.n) : frame.n;
    const float in_s = v3_dot(wi, m), in_g = v3_dot(wi, n);
    if (!(in_g > 0.0f)) return 0;
    const bool behind = in_s < 0.0f && !brdf_transmits(&side->base);
    const float factor = behind ? 0.0f : minf(fabsf(in_s), PHOTON_TILT_MOST * in_g) / in_g;
    return (int8_t)lrintf((factor - 1.0f) / PHOTON_TILT_UNIT);
}

// Where a mask lets some photons pass, the others represent all that would hit a surface without
// holes.
static bool store_photon(const struct satin_scene *scene, struct photon_chunk *chunk,
                         const struct interaction *s, const struct photon_path *photon) {
    const vec3 wi = v3_neg(photon->ray.d), n = v3_dot(s->ng, wi) < 0.0f ? v3_neg(s->ng) : s->ng;
    const struct texture_lookup at = scene_interaction_texture_lookup(scene, s);
    const struct material *material = &scene->material[s->material];
    const float opacity = s->light < 0 ? scene_opacity_material(material, &at) : 1.0f;
    const enum photon_class class = class_of(photon);
    struct photon_hit hit = {.p = s->p,
                             .wi = photon_pack(wi),
                             .n = photon_pack(n),
                             .bounces = photon->bounces,
                             .last = photon->last,
                             .indirect = class == PHOTON_INDIRECT,
                             .tilt = tilt_by_normal(scene, s, wi, n)};
    for (int i = 0; i < PHOTON_CONSUMERS; i++) {
        if (!(photon->classes[i] >> class & 1u)) continue;
        hit.power = rgb_scale(photon->power, photon->factor[i]);
        if (opacity < 1.0f) hit.power = rgb_scale(hit.power, 1.0f / fmaxf(opacity, 0.05f));
        if (!is_valid_hit(&hit))
            chunk->refused++;
        else if (!append(&chunk->photons[i], hit, class))
            chunk->failed = true;
    }
    return !chunk->failed;
}

// Whether the surface's side towards wi has a smooth lobe, whatever its colour: a density estimate
// beside a black texel needs the photons on it.
static bool stores_photons(const struct satin_scene *scene, const struct interaction *s, vec3 wi) {
    const struct material *m = &scene->material[s->material];
    bool behind = v3_dot(wi, s->frame.n) < 0.0f;
    struct scene_component component[MATERIAL_COMPONENTS_MAX];
    int count = scene_components(scene, s, wi, component);
    for (int i = 0; i < count; i++) {
        const struct material_side *side = component[i].side;
        unsigned lobes = side->base.model->lobes;
        if (behind && (!m->two_sided || side->one_sided))
            lobes &= brdf_transmits(&side->base) ? BRDF_DIFFUSE : 0u;
        if (lobes & BRDF_REFLECT) return true;
    }
    return false;
}

// Scatters the photon at s. False if it is absorbed, or refused because its power is not finite.
static bool scatter(const struct satin_scene *scene, const struct interaction *s, unsigned lobes,
                    struct rng *rng, struct photon_path *photon, uint64_t *refused) {
    vec3 wi = v3_neg(photon->ray.d);
    struct brdf b;
    struct frame frame;
    if (!scene_brdf(scene, s, wi, &b, &frame)) return false;
    float u_lobe = rng_float(rng), u = rng_float(rng), v = rng_float(rng);
    struct brdf_sample sample;
    if (!brdf_sample_wi(&b, frame_to_local(&frame, wi), u_lobe, (vec2){u, v}, lobes, BRDF_POWER,
                        &sample))
        return false;
    vec3 wo = frame_to_world(&frame, sample.wi);
    float in_s = fabsf(v3_dot(wi, frame.n)), in_g = fabsf(v3_dot(wi, s->ng)),
          out_s = fabsf(v3_dot(wo, frame.n)), out_g = fabsf(v3_dot(wo, s->ng));
    float adjoint = in_s * out_g / (in_g * out_s);
    rgb power = rgb_scale(rgb_mul(photon->power, sample.weight), adjoint);
    float before = rgb_max(photon->power), after = rgb_max(power);
    if (!rgb_finite(power)) {
        ++*refused;
        return false;
    }
    if (!(after > 0.0f)) return false;
    float survival = fminf(after / before, 1.0f);
    if (rng_float(rng) >= survival) return false;
    if (!(sample.lobe & BRDF_DELTA))
        photon->class = PHOTON_INDIRECT;
    else if (photon->class == PHOTON_DIRECT)
        light_chain_pass(&photon->chain, scene, s, wi, frame_to_local(&frame, wi), &sample);
    photon->power = rgb_scale(power, 1.0f / survival);
    photon->ray = scene_spawn(scene, s->p, s->ng, wo);
    return true;
}

static double luminous(const struct photon_path *photon) {
    return (double)rgb_luminance(photon->power);
}

void photon_path_follow(const struct satin_scene *scene, bool caustic, int bounces,
                        struct photon_path photon, struct rng *rng, struct photon_chunk *chunk) {
    const unsigned lobes = caustic ? BRDF_DELTA : BRDF_ALL;
    const int most = bounces < 0 ? BOUNCES_MAX : bounces;
    for (int bounce = 0; bounce <= most; bounce++) {
        struct interaction s;
        if (!scene_intersect(scene, &photon.ray, &s)) {
            chunk->power.escaped += luminous(&photon);
            return;
        }
        photon.bounces = (uint8_t)(bounce < PHOTON_BOUNCES_MOST ? bounce : PHOTON_BOUNCES_MOST);
        photon.last = bounce == bounces;
        if (photon.wanted >> class_of(&photon) & 1u &&
            stores_photons(scene, &s, v3_neg(photon.ray.d)) &&
            !store_photon(scene, chunk, &s, &photon))
            return;
        const double before = luminous(&photon);
        const bool goes_on = scatter(scene, &s, lobes, rng, &photon, &chunk->refused);
        chunk->power.absorbed += goes_on ? before - luminous(&photon) : before;
        if (!goes_on) return;
    }
    chunk->power.ended += luminous(&photon);
}
