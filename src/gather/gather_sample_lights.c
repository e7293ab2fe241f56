// SPDX-License-Identifier: Apache-2.0
// Direct light at a point: light sampling, weighted against BRDF sampling by the power heuristic
// [Veach 1997, 9.2]. The reference path tracer, first hits and gather hits use the same estimator.
#include <limits.h>

#include "gather/gather.h"

// Up to this many lights are all sampled, although fewer samples were requested: the probabilities
// of a choice depend on shadows in a cell around the point, or not on shadows.
enum { FEW = 4 };

struct choice {
    struct light_visibility visibility;
    uint32_t light;
    float probability;
};

// f_r by set of lobes.
struct lobe_values {
    rgb f[3];
};

// False if all are 0.
static bool evaluate_brdf(const struct shading_point *p, struct gather_mis mis, vec3 wi,
                          struct lobe_values *out) {
    bool any = false;
    for (int i = 0; i < 3; i++) {
        const unsigned lobes = mis.set[i].lobes & p->lobes & BRDF_SMOOTH;
        out->f[i] = lobes ? brdf_eval(&p->brdf, p->wo_l, wi, lobes) : rgb_grey(0.0f);
        any |= !rgb_black(out->f[i]);
    }
    return any;
}

// The sum of f_r over the lobes, each with its weight against BRDF sampling.
static rgb weight_brdf(const struct shading_point *p, struct gather_mis mis, vec3 wi, float pdf,
                       bool delta, const struct lobe_values *values) {
    rgb sum = rgb_grey(0.0f);
    for (int i = 0; i < 3; i++) {
        const unsigned lobes = mis.set[i].lobes & p->lobes;
        const float ratio = mis.set[i].ratio;
        float weight = 1.0f;
        if (!(lobes & BRDF_SMOOTH)) continue;
        if (ratio > 0.0f && !delta)
            weight = mis_power(pdf, ratio * brdf_pdf(&p->brdf, p->wo_l, wi, lobes));
        sum = rgb_mad(sum, values->f[i], weight);
    }
    return sum;
}

// The contribution of the sample u of one light, without the probability of choosing the light. The
// weight against BRDF sampling includes that probability even if all lights are sampled, as
// gather_light_pdf does.
static rgb sample_light(const struct gather *g, const struct shading_point *p,
                        struct gather_mis mis, struct choice choice, vec2 u) {
    const struct satin_scene *scene = g->scene;
    const vec3 at = p->interaction.p;
    const rgb none = rgb_grey(0.0f);
    struct light_sample s;
    struct lobe_values values;
    if (!light_sample_draw(scene, choice.light, choice.visibility, at, u.x, u.y, &s)) return none;
    vec3 wi = frame_to_local(&p->frame, s.wi);
    if (!evaluate_brdf(p, mis, wi, &values)) return none;
    const vec3 straight = s.wi;
    if (!light_arrives(scene, at, p->interaction.ng, gather_panes(g, mis.depth), &s)) return none;
    if (!light_sample_read(scene, choice.visibility, &s)) return none;
    if (v3_dist2(straight, s.wi) > 0.0f) {  // panes have shifted it
        wi = frame_to_local(&p->frame, s.wi);
        evaluate_brdf(p, mis, wi, &values);
    }
    const rgb f = weight_brdf(p, mis, wi, s.pdf_w * choice.probability, s.delta, &values);
    return rgb_scale(rgb_mul(f, s.L), fabsf(wi.z) / s.pdf_w);
}

int gather_panes(const struct gather *g, int depth) {
    const int most = g->options->max_depth;
    return most < 0 ? INT_MAX : most - depth - 1;
}

// One sample of each light.
static rgb all_lights(const struct gather *g, const struct shading_point *p, struct gather_mis mis,
                      struct light_visibility visibility, struct sampler sampler) {
    rgb sum = rgb_grey(0.0f);
    const vec2 u = sampler_2d(&sampler);
    float probability[LIGHT_WEIGHTS_MAX];
    light_choose_probabilities(g->scene, p->interaction.p, visibility, probability);
    for (uint32_t i = 0; i < g->scene->light_count; i++) {
        struct choice choice = {visibility, i, probability[i]};
        if (choice.probability > 0.0f) sum = rgb_add(sum, sample_light(g, p, mis, choice, u));
    }
    return sum;
}

rgb gather_sample_lights(const struct gather *g, const struct shading_point *p,
                         struct gather_mis mis, struct gather_light_samples light_samples,
                         struct sampler sampler, float *variance) {
    rgb sum = rgb_grey(0.0f);
    const uint32_t light_count = g->scene->light_count, samples = (uint32_t)light_samples.count;
    if (variance) *variance = 0.0f;
    unsigned lobes = mis.set[0].lobes | mis.set[1].lobes | mis.set[2].lobes;
    lobes &= p->lobes & BRDF_SMOOTH;
    if (!lobes || light_count == 0) return sum;
    struct light_product product;  // not initialised, as only some of it is used
    const struct light_visibility visibility = gather_visibility(g, p, &product);
    sampler.index = light_samples.first;
    if (samples < light_count && light_count <= FEW)
        return all_lights(g, p, mis, visibility, sampler);
    float squares = 0.0f;
    for (uint32_t i = 0; i < samples; i++) {
        struct sampler s = {light_samples.first + i, sampler.seed, sampler.dimension};
        struct choice choice = {.visibility = visibility};
        vec2 u = sampler_2d(&s);
        choice.light =
            light_choose(g->scene, p->interaction.p, visibility, &u.x, &choice.probability);
        const rgb L = rgb_scale(sample_light(g, p, mis, choice, u), 1.0f / choice.probability);
        sum = rgb_add(sum, L);
        squares += sqrf(rgb_luminance(L));
    }
    const float n = (float)samples;
    sum = rgb_scale(sum, 1.0f / n);
    if (variance && samples > 1)
        *variance = fmaxf(squares - n * sqrf(rgb_luminance(sum)), 0.0f) / (n - 1.0f);
    return sum;
}

struct gather_met_light gather_meet_light(const struct gather *g, const struct light_chain *chain,
                                          vec3 d, const struct light_receiver *from,
                                          const struct interaction *hit) {
    struct gather_met_light met = {.Le = light_chain_emitted(chain, g->scene, hit, d)};
    struct light_connection to;
    met.direct = from && !rgb_black(met.Le) && light_chain_direct(chain, g->scene, d, hit, &to);
    if (!met.direct) return met;
    struct light_product product;
    const struct light_visibility visibility = guide_visibility_at(g->visibility, from, &product);
    met.light_pdf = gather_light_pdf(g, from->p, visibility, &to, hit);
    return met;
}

float gather_light_pdf(const struct gather *g, vec3 p, struct light_visibility visibility,
                       const struct light_connection *to, const struct interaction *hit) {
    const struct satin_scene *scene = g->scene;
    if (!hit && scene->environment < 0) return 0.0f;
    const uint32_t light = (uint32_t)(hit ? hit->light : scene->environment);
    const float choice = light_choose_probability(scene, p, visibility, light);
    if (!hit) return choice * light_environment_pdf(scene, visibility.product, to->d);
    return choice * light_connection_pdf(scene, p, to, hit);
}
