// SPDX-License-Identifier: Apache-2.0
// Path tracing with MIS of light and BRDF sampling: the reference, and the first pass `path`.
// Depths count path segments, as in Mitsuba 3; the longest path has max_depth segments. In
// progressive photon mapping, paths read indirect light and caustics from photons. They continue in
// the directions that these leave out and, where photons of indirect light are sparse, in all.
#include "gather/gather.h"

// The largest probability of survival, so that no path between perfect mirrors is endless.
static const float ROULETTE_MAX = 0.95f;

// The state of a path after its start.
struct path_walk {
    struct ray ray;
    rgb T;        // of direct light, which light samples can find too
    rgb caustic;  // of light that is met by a chain of specular surfaces, and of reflected light:
    rgb rest;     // T, without directions whose caustics or indirect light are from photons
    float eta;
    float length;                // from the eye
    bool indirect;               // whether the indirect light of the last surface is from photons
    int depth;                   // number of segments before the ray
    struct light_receiver from;  // the last surface with smooth lobes on the path
    float pdf_w;  // density of the BRDF sample by which `from` was left, per light sample there; 0:
                  // by a delta lobe, or there is none
    struct light_chain chain;  // chain of specular surfaces from there on
    bool emission;             // whether emitted light that the ray hits is added
    bool specular;             // whether all surfaces so far were ideal specular
};

// The emitted light that the ray hits, at a surface or from the environment, with its MIS weight
// against light samples at the start of the chain. *T is set to the throughput for it.
static rgb emitted(const struct gather *g, const struct path_walk *walk,
                   const struct interaction *hit, rgb *T) {
    const struct light_receiver *from = walk->pdf_w > 0.0f ? &walk->from : NULL;
    const struct gather_met_light met = gather_meet_light(g, &walk->chain, walk->ray.d, from, hit);
    *T = met.direct ? walk->T : walk->caustic;
    return met.direct ? rgb_scale(met.Le, mis_power(walk->pdf_w, met.light_pdf)) : met.Le;
}

// The number of light samples at a point that is `depth` segments from the eye. For each sample of
// progressive photon mapping new photons were traced too, so it takes all those of the options at
// the first point.
static int count_light_samples(const struct gather *g, int depth) {
    return g->sppm && depth == 1 ? g->options->light_samples : 1;
}

// Continues the path from `from` by a sample.
static void leave_point(const struct gather *g, const struct shading_point *from,
                        const struct brdf_sample *next, struct path_walk *walk) {
    const vec3 wo = v3_neg(walk->ray.d);
    walk->ray = scene_spawn(g->scene, from->interaction.p, from->interaction.ng,
                            frame_to_world(&from->frame, next->wi));
    if (next->pdf_w > 0.0f) {
        walk->T = walk->rest;  // light samples found direct light
        walk->from = gather_receiver(from);
        walk->pdf_w = next->pdf_w / (float)count_light_samples(g, walk->depth + 1);
        walk->chain = light_chain_begin(&walk->ray);
    } else {
        light_chain_pass(&walk->chain, g->scene, &from->interaction, wo, from->wo_l, next);
    }
}

// Continues from a point by reflection or transmission. False if the path ends there.
static bool bounce(const struct gather *g, const struct shading_point *from,
                   struct sampler *sampler, struct path_walk *walk) {
    struct brdf_sample next;
    float u_lobe = sampler_1d(sampler);
    vec2 u = sampler_2d(sampler);
    const unsigned lobes = rgb_black(walk->rest) ? BRDF_DELTA : BRDF_ALL;
    if (!brdf_sample_wi(&from->brdf, from->wo_l, u_lobe, u, lobes, BRDF_RADIANCE, &next))
        return false;
    leave_point(g, from, &next, walk);
    walk->T = rgb_mul(walk->T, next.weight);
    const rgb left = g->sppm ? photon_sppm_rest(from, &next) : next.weight;
    walk->caustic = rgb_mul(next.pdf_w > 0.0f ? walk->rest : walk->caustic, left);
    walk->rest = rgb_mul(walk->rest, walk->indirect ? left : next.weight);
    walk->eta *= next.eta;
    walk->emission = walk->emission || next.pdf_w > 0.0f || walk->depth == 0;
    walk->specular = walk->specular && !(next.pdf_w > 0.0f);
    walk->depth++;
    if (walk->depth >= g->options->rr_depth) {
        float survive = fminf(rgb_max(walk->T) * walk->eta * walk->eta, ROULETTE_MAX);
        if (!(sampler_1d(sampler) < survive)) return false;
        walk->T = rgb_scale(walk->T, 1.0f / survive);
        walk->caustic = rgb_scale(walk->caustic, 1.0f / survive);
        walk->rest = rgb_scale(walk->rest, 1.0f / survive);
    }
    return !rgb_black(walk->T);
}

// The light that is known at a point without continuing the path; whether indirect light is, is
// noted in the walk.
static rgb known_light(const struct gather *g, const struct shading_point *p,
                       struct path_walk *walk, struct sampler sampler) {
    const int depth = walk->depth + 1;
    const int count = count_light_samples(g, depth);
    const struct gather_mis both = {depth, {{BRDF_ALL, 1.0f / (float)count}}};
    const struct gather_light_samples samples = {count, sampler.index * (uint32_t)count};
    const rgb direct = gather_sample_lights(g, p, both, samples, sampler, NULL);
    walk->indirect = false;
    if (!g->sppm || !(p->lobes & BRDF_REFLECT)) return direct;
    return rgb_add(direct, photon_sppm_radiance(g->sppm, p, depth, walk->length, &walk->indirect));
}

// The radiance of a path, and the first hit: `first` for a gather ray, `eye` for an eye ray.
static rgb follow_path(const struct gather *g, struct path_walk walk, struct sampler *sampler,
                       struct gather_first *first, struct gather_eye_hit *eye) {
    const int max_depth = g->options->max_depth;
    rgb L = rgb_grey(0.0f);
    struct shading_point from = {0};
    do {
        struct interaction s;
        bool hit = scene_intersect(g->scene, &walk.ray, &s);
        if (first) *first = hit ? (struct gather_first){s.t, s.ng} : GATHER_NOTHING;
        if (walk.emission) {
            rgb T;
            const rgb Le = emitted(g, &walk, hit ? &s : NULL, &T);
            L = rgb_fma(L, T, Le);
            if (eye && walk.specular) eye->emission = rgb_fma(eye->emission, walk.T, Le);
        }
        const bool last = max_depth >= 0 && walk.depth + 1 >= max_depth;
        if (!hit || (last && (!eye || eye->hit))) break;

        scene_shading_point_make(g->scene, &s, walk.ray.d, &from);
        if (first && !(from.lobes & BRDF_SMOOTH)) first->ng = GATHER_NOTHING.ng;
        first = NULL;
        if (eye && !eye->hit) {
            eye->hit = true;
            eye->point = from;
        }
        if (eye && walk.specular && (from.lobes & BRDF_SMOOTH) && rgb_black(eye->T)) {
            eye->smooth = from;
            eye->T = walk.T;
        }
        if (last || !from.lobes) break;
        walk.length += s.t;
        if (!rgb_black(walk.rest))
            L = rgb_fma(L, walk.rest, known_light(g, &from, &walk, *sampler));
        sampler->dimension += 2;
    } while (bounce(g, &from, sampler, &walk));
    return L;
}

rgb gather_path(const struct gather *g, struct ray ray, struct sampler *sampler,
                struct gather_first *first) {
    struct path_walk walk = {.ray = ray,
                             .T = rgb_grey(1.0f),
                             .caustic = rgb_grey(1.0f),
                             .rest = rgb_grey(1.0f),
                             .eta = 1.0f,
                             .depth = 1};
    return follow_path(g, walk, sampler, first, NULL);
}

rgb gather_path_eye(const struct gather *g, struct ray ray, struct sampler *sampler,
                    struct gather_eye_hit *eye) {
    const satin_options *o = g->options;
    struct path_walk walk = {.ray = ray,
                             .T = rgb_grey(1.0f),
                             .caustic = rgb_grey(1.0f),
                             .rest = rgb_grey(1.0f),
                             .eta = 1.0f,
                             .emission = o->hide_emitters <= 0 && o->max_depth != 0,
                             .specular = true};
    eye->hit = false;
    eye->T = rgb_grey(0.0f);
    eye->emission = rgb_grey(0.0f);
    return follow_path(g, walk, sampler, NULL, eye);
}
