// SPDX-License-Identifier: Apache-2.0
// Follows one photon: it scatters, and is stored where a smooth lobe could reflect it. Scattering
// ends by Russian roulette with the albedo, which keeps the photons' powers equal [Jensen 2001].
// Shading normals have the factor of the adjoint BSDF [Veach 1997, 5.3.2], which can make a photon
// much stronger than others: then it is split.
#include "photon/photon_path.h"

#include "base/array.h"
#include "base/sampling.h"

enum {
    BOUNCES_MAX = 1000,  // ends paths that a mirror with albedo 1 would continue for ever
    SPLIT_MOST = 64      // a bound of time alone: photons grow so much once in thousands of bounces
};

// Normals whose cosine is larger count as equal: of the directions by the cosine about one of them,
// one in 2,500 has a cosine about the other that is over 1.5 times larger.
static const float TILTED_COSINE = 0.9998f;

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

// The scene and what the paths of a chunk have in common.
struct photon_walk {
    const struct satin_scene *scene;
    unsigned lobes;  // that scatter
    int bounces;     // the last one that is stored; < 0: no limit
    float unit;      // the largest component of the power with which the path began
    struct rng *rng;
    struct photon_chunk *chunk;
};

// Where a photon is scattered.
struct path_surface {
    const struct interaction *s;
    vec3 wi, n;  // n: the normal of the surface on the side of wi
    struct brdf brdf;
    struct frame frame;
};

static double luminous(const struct photon_path *photon) {
    return (double)rgb_luminance(photon->power);
}

// Whether directions are drawn about the surface's normal too: where a photon meets a smooth lobe
// about another normal. What transmits is left out, as half of its directions are on the other
// side.
static bool is_tilted(const struct path_surface *at, unsigned lobes) {
    return lobes == BRDF_ALL && fabsf(v3_dot(at->frame.n, at->n)) < TILTED_COSINE &&
           brdf_lobes(&at->brdf) & BRDF_SMOOTH && !brdf_transmits(&at->brdf);
}

// Draws the direction of a photon that is scattered about a tilted normal. The cosine about that
// normal is small where that about the surface's need not be, and their ratio has no limit. So half
// of the directions of smooth lobes are drawn by the cosine about the surface's normal.
static bool draw_tilted(const struct path_surface *at, const float u[3], struct brdf_sample *out) {
    const vec3 wi_l = frame_to_local(&at->frame, at->wi);
    const vec2 direction = {u[1], u[2]};
    float pdf_surface;
    if (u[0] < 0.5f) {
        const struct frame flat = frame_from_normal(at->n);
        const vec3 wo = frame_to_world(&flat, sample_cosine_hemisphere(u[1], u[2]));
        const vec3 wo_l = frame_to_local(&at->frame, wo);
        *out = (struct brdf_sample){.wi = wo_l, .lobe = BRDF_DIFFUSE, .eta = 1.0f};
        out->pdf_w = brdf_pdf(&at->brdf, wi_l, wo_l, BRDF_ALL);
        // The viewer is where the photon goes, and the slopes of a map shadow where it comes from.
        out->weight = rgb_scale(brdf_eval(&at->brdf, wo_l, wi_l, BRDF_SMOOTH), fabsf(wo_l.z));
        pdf_surface = v3_dot(wo, at->n) / PI_F;
    } else {
        const float u_lobe = sample_rest(u[0], 0.5f);
        if (!brdf_sample_wi(&at->brdf, wi_l, u_lobe, direction, BRDF_ALL, BRDF_POWER, out))
            return false;
        out->weight = rgb_scale(out->weight, out->lobe & BRDF_DELTA ? 2.0f : out->pdf_w);
        if (out->lobe & BRDF_DELTA) return true;
        pdf_surface = v3_dot(frame_to_world(&at->frame, out->wi), at->n) / PI_F;
    }
    const float pdf = 0.5f * (out->pdf_w + fmaxf(pdf_surface, 0.0f));
    if (!(pdf > 0.0f)) return false;
    out->weight = rgb_scale(out->weight, 1.0f / pdf);
    return true;
}

// Draws the scattered direction, in the frame, and its weight.
static bool draw_scattered(const struct photon_walk *walk, const struct path_surface *at,
                           struct brdf_sample *out) {
    const float u_lobe = rng_float(walk->rng), x = rng_float(walk->rng), y = rng_float(walk->rng);
    if (is_tilted(at, walk->lobes)) return draw_tilted(at, (float[]){u_lobe, x, y}, out);
    return brdf_sample_wi(&at->brdf, frame_to_local(&at->frame, at->wi), u_lobe, (vec2){x, y},
                          walk->lobes, BRDF_POWER, out);
}

// How much more of a photon's power the shading normal takes than the surface: the factor of the
// adjoint BSDF that does not depend on the scattered direction.
static float factor_in(const struct path_surface *at) {
    return fabsf(v3_dot(at->wi, at->frame.n)) / fabsf(v3_dot(at->wi, at->n));
}

// The number of photons into which one is split before it is scattered, so that those which go on
// have the power with which the path began.
static int split_count(const struct photon_walk *walk, const struct path_surface *at,
                       const struct photon_path *photon) {
    const float power = rgb_max(photon->power) * fmaxf(factor_in(at), 1.0f);
    return power < 1.5f * walk->unit ? 1 : (int)fminf(rintf(power / walk->unit), SPLIT_MOST);
}

// Scatters the photon. False if it is absorbed, or refused because its power is not finite.
static bool scatter(const struct photon_walk *walk, const struct path_surface *at,
                    struct photon_path *photon) {
    struct brdf_sample sample;
    if (!draw_scattered(walk, at, &sample)) return false;
    const vec3 wo = frame_to_world(&at->frame, sample.wi);
    const float adjoint = factor_in(at) * fabsf(v3_dot(wo, at->n)) / fabsf(v3_dot(wo, at->frame.n));
    const rgb power = rgb_scale(rgb_mul(photon->power, sample.weight), adjoint);
    if (!rgb_finite(power)) {
        walk->chunk->refused++;
        return false;
    }
    const float after = rgb_max(power);
    if (!(after > 0.0f)) return false;
    const float survival = fminf(after / walk->unit, 1.0f);
    if (rng_float(walk->rng) >= survival) return false;
    if (!(sample.lobe & BRDF_DELTA))
        photon->class = PHOTON_INDIRECT;
    else if (photon->class == PHOTON_DIRECT)
        light_chain_pass(&photon->chain, walk->scene, at->s, at->wi,
                         frame_to_local(&at->frame, at->wi), &sample);
    photon->power = rgb_scale(power, 1.0f / survival);
    photon->ray = scene_spawn(walk->scene, at->s->p, at->s->ng, wo);
    return true;
}

// Stores the photon where it hits. False if it ends there.
static bool arrive(const struct photon_walk *walk, struct photon_path *photon, int bounce,
                   struct path_surface *at, struct interaction *s) {
    if (!scene_intersect(walk->scene, &photon->ray, s)) {
        walk->chunk->power.escaped += luminous(photon);
        return false;
    }
    photon->bounces = (uint8_t)(bounce < PHOTON_BOUNCES_MOST ? bounce : PHOTON_BOUNCES_MOST);
    photon->last = bounce == walk->bounces;
    at->s = s;
    at->wi = v3_neg(photon->ray.d);
    at->n = v3_dot(s->ng, at->wi) < 0.0f ? v3_neg(s->ng) : s->ng;
    if (photon->wanted >> class_of(photon) & 1u && stores_photons(walk->scene, s, at->wi) &&
        !store_photon(walk->scene, walk->chunk, s, photon))
        return false;
    if (scene_brdf(walk->scene, s, at->wi, &at->brdf, &at->frame)) return true;
    walk->chunk->power.absorbed += luminous(photon);
    return false;
}

static void follow(const struct photon_walk *walk, struct photon_path photon, int bounce) {
    const int most = walk->bounces < 0 ? BOUNCES_MAX : walk->bounces;
    for (; bounce <= most; bounce++) {
        struct interaction s;
        struct path_surface at;
        if (!arrive(walk, &photon, bounce, &at, &s)) return;
        const int count = split_count(walk, &at, &photon);
        photon.power = rgb_scale(photon.power, 1.0f / (float)count);
        const double before = luminous(&photon);
        bool goes_on = false;
        for (int i = 0; i < count; i++) {
            struct photon_path scattered = photon;
            goes_on = scatter(walk, &at, &scattered);
            walk->chunk->power.absorbed += goes_on ? before - luminous(&scattered) : before;
            if (i == count - 1)
                photon = scattered;
            else if (goes_on)
                follow(walk, scattered, bounce + 1);
        }
        if (!goes_on) return;
    }
    walk->chunk->power.ended += luminous(&photon);
}

void photon_path_follow(const struct satin_scene *scene, bool caustic, int bounces,
                        struct photon_path photon, struct rng *rng, struct photon_chunk *chunk) {
    const struct photon_walk walk = {
        scene, caustic ? BRDF_DELTA : BRDF_ALL, bounces, rgb_max(photon.power), rng, chunk};
    follow(&walk, photon, 0);
}
