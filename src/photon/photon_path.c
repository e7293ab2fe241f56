// SPDX-License-Identifier: Apache-2.0
// Follows one photon: it scatters, and is stored where a smooth lobe could reflect it. Scattering
// ends by Russian roulette with the albedo, which keeps the photons' powers equal [Jensen 2001].
// The adjoint BSDF of shading normals (photon_scatter.c) can make a photon much stronger than
// others: then it is split.
#include "photon/photon_path.h"

#include "base/array.h"
#include "photon/photon_scatter.h"

enum {
    BOUNCES_MAX = 1000,  // ends paths that a mirror with albedo 1 would continue for ever
    // Bounds of time alone, of one photon and of all of a path: photons grow so much once in
    // thousands of bounces.
    SPLIT_MOST = 64,
    SPLIT_PATH_MOST = 4096
};
// Photons with more than so many times the power they should have are split.
#define STRONG 1.5f

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

// The class of a photon that hits s. It is a caustic one if a chain brings it that light samples at
// s do not find.
static enum photon_class class_at(const struct satin_scene *scene, const struct photon_path *photon,
                                  const struct interaction *s) {
    if (photon->class != PHOTON_DIRECT) return photon->class;
    const bool direct =
        light_chain_brings_direct(&photon->chain, scene, photon->light, photon->ray.d, s);
    return direct ? PHOTON_DIRECT : PHOTON_CAUSTIC;
}

// See photon_hit; n is the geometric normal on the side of wi. The shading normal is that of a
// viewer on this side, whom maps direct invalid normals to. Where it faces away from wi, the
// surface reflects to the other side at most, which has other estimates.
static int8_t tilt_by_normal(const struct satin_scene *scene, const struct interaction *s, vec3 wi,
                             vec3 n) {
    const struct material_side *side = scene_draw_component(scene, s, n);
    struct frame frame = scene_component_frame(scene, side, s, n);
    struct brdf brdf;
    float shadowing = 1.0f;
    if (scene_bump_used(&side->bump[0])) {
        if (!scene_component_brdf(scene, side, s, n, &brdf, &frame)) return 0;
        if (!brdf_transmits(&brdf))
            shadowing = brdf_bump_shadowing(&brdf, frame_to_local(&frame, wi));
    }
    const vec3 m = v3_dot(frame.n, n) < 0.0f ? v3_neg(frame.n) : frame.n;
    const float in_s = v3_dot(wi, m), in_g = v3_dot(wi, n);
    if (!(in_g > 0.0f)) return 0;
    const bool behind = in_s < 0.0f && !brdf_transmits(&side->base);
    return photon_pack_tilt(behind ? 0.0f : shadowing * fabsf(in_s) / in_g);
}

// Where a mask lets some photons pass, the others represent all that would hit a surface without
// holes.
static bool store_photon(const struct satin_scene *scene, struct photon_chunk *chunk,
                         const struct interaction *s, const struct photon_path *photon,
                         enum photon_class class) {
    const vec3 wi = v3_neg(photon->ray.d), n = v3_dot(s->ng, wi) < 0.0f ? v3_neg(s->ng) : s->ng;
    const struct texture_lookup at = scene_interaction_texture_lookup(scene, s);
    const struct material *material = &scene->material[s->material];
    const float opacity = s->light < 0 ? scene_opacity_material(material, &at) : 1.0f;
    struct photon_hit hit = {.p = s->p,
                             .wi = photon_pack(wi),
                             .n = photon_pack(n),
                             .bounces = photon->bounces,
                             .last = photon->last,
                             .indirect = class == PHOTON_INDIRECT,
                             .path = photon->path,
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
    unsigned lobes;                         // that scatter
    int bounces;                            // the last one that is stored; < 0: no limit
    const struct light_openings *openings;  // towards which photons are scattered; may be NULL
    struct rng *rng;
    struct photon_chunk *chunk;
    struct photon_power *power;  // of the chunk's paths from the same light
    int *parts;                  // photons into which those of the path were split so far
};

static double luminous(const struct photon_path *photon) {
    return (double)rgb_luminance(photon->power);
}

// The number of photons into which one is split before it is scattered, so that those which go on
// have the power with which the path began. Delta lobes alone would send all of them to one point.
static int split_count(const struct photon_walk *walk, const struct photon_surface *at,
                       const struct photon_path *photon) {
    if (!(walk->lobes & at->side->base.model->lobes & BRDF_SMOOTH)) return 1;
    float factor = 1.0f;
    for (int i = 0; i < at->facets; i++)
        factor = fmaxf(factor, photon_factor_in(at, &at->facet[i].frame));
    const float power = rgb_max(photon->power) * factor;
    if (power < STRONG * photon->unit || *walk->parts >= SPLIT_PATH_MOST) return 1;
    const int count = (int)fminf(rintf(power / photon->unit), SPLIT_MOST);
    *walk->parts += count;
    return count;
}

// Scatters the photon to a direction that was drawn. False if it is absorbed, or refused because
// its power is not finite.
static bool scatter_to(const struct photon_walk *walk, const struct photon_surface *at,
                       const struct photon_scattered *to, struct photon_path *photon) {
    const float factor_out = fabsf(v3_dot(to->wo, at->n)) / fabsf(v3_dot(to->wo, to->frame.n));
    const rgb power = rgb_scale(rgb_mul(photon->power, to->sample.weight),
                                photon_factor_in(at, &to->frame) * factor_out);
    if (!rgb_finite(power)) {
        walk->chunk->refused++;
        return false;
    }
    const float after = rgb_max(power);
    if (!(after > 0.0f)) return false;
    const float survival = fminf(after / photon->unit, 1.0f);
    if (rng_float(walk->rng) >= survival) return false;
    if (!(to->sample.lobe & BRDF_DELTA))
        photon->class = PHOTON_INDIRECT;
    else if (photon->class == PHOTON_DIRECT)
        light_chain_pass(&photon->chain, walk->scene, at->s, at->wi,
                         frame_to_local(&to->frame, at->wi), &to->sample);
    photon->power = rgb_scale(power, 1.0f / survival);
    photon->ray = scene_spawn(walk->scene, at->s->p, at->s->ng, to->wo);
    return true;
}

// Scatters the photon. Directions to the openings are also drawn by `entering` other samples, and
// weighted with these by the balance heuristic.
static bool scatter(const struct photon_walk *walk, const struct photon_surface *at, int entering,
                    struct photon_path *photon) {
    struct photon_scattered to;
    if (!photon_scatter(at, walk->lobes, walk->rng, &to)) return false;
    if (entering > 0 && !(to.sample.lobe & BRDF_DELTA)) {
        const float aimed = light_openings_pdf(walk->openings, at->s->p, to.wo);
        if (aimed > 0.0f) {
            const float own = photon_scatter_pdf(at, to.wo);
            photon->power = rgb_scale(photon->power, own / (own + (float)entering * aimed));
            photon->unit = photon->entering;
        }
    }
    return scatter_to(walk, at, &to, photon);
}

// Stores the photon where it hits. False if it ends there.
static bool arrive(const struct photon_walk *walk, struct photon_path *photon, int bounce,
                   struct photon_surface *at, struct interaction *s) {
    if (!scene_intersect(walk->scene, &photon->ray, s)) {
        walk->power->escaped += luminous(photon);
        return false;
    }
    photon->bounces = (uint8_t)(bounce < PHOTON_BOUNCES_MOST ? bounce : PHOTON_BOUNCES_MOST);
    photon->last = bounce == walk->bounces;
    const vec3 wi = v3_neg(photon->ray.d);
    if (stores_photons(walk->scene, s, wi)) {
        const enum photon_class class = class_at(walk->scene, photon, s);
        if (photon->wanted >> class & 1u &&
            !store_photon(walk->scene, walk->chunk, s, photon, class))
            return false;
    }
    if (photon_surface_make(walk->scene, s, wi, at)) return true;
    walk->power->absorbed += luminous(photon);
    return false;
}

// ---- Openings -----------------------------------------------------------------------------------

static void follow(const struct photon_walk *walk, struct photon_path photon, int bounce);

// The number of samples of directions to the openings: that of photons which arrive there, if all
// of them are visible and nothing else is. 0: it is not one of the strong photons outside.
static int entering_count(const struct photon_walk *walk, const struct photon_surface *at,
                          const struct photon_path *photon) {
    if (!walk->openings || !(photon->unit > STRONG * photon->entering)) return 0;
    const struct brdf *brdf = &at->facet[0].brdf;
    if (!(brdf_lobes(brdf) & BRDF_SMOOTH) || brdf_transmits(brdf)) return 0;
    if (!light_openings_faced(walk->openings, at->s->p)) return 0;
    const vec3 w = light_openings_direction(walk->openings, at->s->p, 0.5f, 0.5f);
    const float pdf = light_openings_pdf(walk->openings, at->s->p, w);
    const float fraction = pdf > 0.0f ? fminf(1.0f / (PI_F * pdf), 1.0f) : 1.0f;
    const float count = ceilf(rgb_max(photon->power) * fraction / photon->entering);
    return (int)fminf(fmaxf(count, 1.0f), SPLIT_MOST);
}

// Scatters a photon to the openings, and follows what comes in there.
static void follow_entering(const struct photon_walk *walk, const struct photon_surface *at,
                            int count, const struct photon_path *photon, int bounce) {
    for (int i = 0; i < count; i++) {
        struct photon_path entering = *photon;
        struct photon_scattered to;
        const float u = rng_float(walk->rng), v = rng_float(walk->rng);
        to.wo = light_openings_direction(walk->openings, at->s->p, u, v);
        const float aimed = light_openings_pdf(walk->openings, at->s->p, to.wo);
        const float pdf = (float)count * aimed + photon_scatter_pdf(at, to.wo);
        entering.unit = photon->entering;
        if (!(aimed > 0.0f) || !photon_scatter_along(at, pdf, &to) ||
            !scatter_to(walk, at, &to, &entering))
            continue;
        walk->power->absorbed -= luminous(&entering);
        follow(walk, entering, bounce + 1);
    }
}

// ---- The whole path -----------------------------------------------------------------------------

static void follow(const struct photon_walk *walk, struct photon_path photon, int bounce) {
    const int most = walk->bounces < 0 ? BOUNCES_MAX : walk->bounces;
    for (; bounce <= most; bounce++) {
        struct interaction s;
        struct photon_surface at;
        if (!arrive(walk, &photon, bounce, &at, &s)) return;
        const int entering = entering_count(walk, &at, &photon);
        if (entering > 0) follow_entering(walk, &at, entering, &photon, bounce);
        const int count = split_count(walk, &at, &photon);
        photon.power = rgb_scale(photon.power, 1.0f / (float)count);
        const double before = luminous(&photon);
        bool goes_on = false;
        for (int i = 0; i < count; i++) {
            struct photon_path scattered = photon;
            goes_on = scatter(walk, &at, entering, &scattered);
            walk->power->absorbed += goes_on ? before - luminous(&scattered) : before;
            if (i == count - 1)
                photon = scattered;
            else if (goes_on)
                follow(walk, scattered, bounce + 1);
        }
        if (!goes_on) return;
    }
    walk->power->ended += luminous(&photon);
}

void photon_path_follow(const struct satin_scene *scene, bool caustic, int bounces,
                        const struct light_openings *openings, struct photon_path photon,
                        struct rng *rng, struct photon_chunk *chunk) {
    int parts = 0;
    const struct photon_walk walk = {.scene = scene,
                                     .lobes = caustic ? BRDF_DELTA : BRDF_ALL,
                                     .bounces = bounces,
                                     .openings = openings,
                                     .rng = rng,
                                     .chunk = chunk,
                                     .power = &chunk->power[photon_power_index(photon.light)],
                                     .parts = &parts};
    follow(&walk, photon, 0);
}
