// SPDX-License-Identifier: Apache-2.0
// Lights for the integrators: choosing one for a point, sampling a direction towards it, and the
// densities that multiple importance sampling needs. Units and parameters are Mitsuba 3's.
#include "base/sampling.h"
#include "light/light_tree.h"

// The fraction of choices that is uniform over all lights, because the estimates ignore shadows and
// facing, or know the visibility only approximately.
#define UNIFORM 0.25f
#define UNIFORM_VISIBILITY 0.1f

// Makes a lamp black that coincides with another one, which hides it (scene_trace.c).
static void darken_if_hidden(const struct satin_scene *scene, struct light *light) {
    if (light->kind != LIGHT_AREA && light->kind != LIGHT_BEAM) return;
    if (scene->shape[light->shape].light == (int32_t)(light - scene->light)) return;
    light->value = rgb_grey(0.0f);
    light->texture = NULL;
}

satin_status light_prepare(struct satin_scene *scene, struct log log) {
    scene->light_cdf = NULL;
    light_find_panes(scene);
    if (scene->light_count == 0) return SATIN_OK;
    float *power = arena_array(&scene->arena, scene->light_count, sizeof *power);
    float *cdf = arena_array(&scene->arena, (size_t)scene->light_count + 1, sizeof *cdf);
    satin_status status = power && cdf ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->light_count && status == SATIN_OK; i++) {
        struct light *light = &scene->light[i];
        darken_if_hidden(scene, light);
        switch (light->kind) {
            case LIGHT_AREA:
                status = light_area_prepare(scene, light);
                break;
            case LIGHT_BEAM:
                status = light_beam_prepare(scene, light);
                break;
            case LIGHT_CONSTANT:
            case LIGHT_ENVMAP:
                status = light_environment_prepare(scene, light);
                break;
            case LIGHT_POINT:
            case LIGHT_SPOT:
            case LIGHT_PROJECTOR:
                light_point_prepare(light);
                break;
            case LIGHT_DIRECTIONAL:
                light->strength = rgb_luminance(light->value);
                light->power =
                    light->strength * light_bounds_projected_area(scene, light->direction);
                break;
        }
        light->power = fmaxf(light->power, 1e-30f);
        power[i] = light->power;
    }
    if (status != SATIN_OK) return log_fail(log, status, "not enough memory for the lights");
    sample_cdf_build(power, scene->light_count, cdf);
    scene->light_cdf = cdf;
    if (scene->light_count <= LIGHT_WEIGHTS_MAX) return SATIN_OK;
    status = light_tree_build(scene);
    return status == SATIN_OK ? status : log_fail(log, status, "not enough memory for the lights");
}

// ---- Choice -----------------------------------------------------------------------------------

float light_estimate(const struct satin_scene *scene, const struct light *light, vec3 p) {
    switch (light->kind) {
        case LIGHT_AREA:
            return light_area_estimate(scene, light, p);
        case LIGHT_BEAM:
            return light_beam_estimate(scene, light, p);
        case LIGHT_POINT:
        case LIGHT_SPOT:
        case LIGHT_PROJECTOR:
            return light_point_estimate(light, p);
        case LIGHT_DIRECTIONAL:
        case LIGHT_CONSTANT:
        case LIGHT_ENVMAP:
            return light->strength;
    }
    return 0.0f;
}

void light_choose_probabilities(const struct satin_scene *scene, vec3 p,
                                struct light_visibility visibility,
                                float probability[LIGHT_WEIGHTS_MAX]) {
    const float *fraction = visibility.fraction;
    uint32_t n = scene->light_count, lit = 0;
    float sum = 0.0f;
    for (uint32_t i = 0; i < n; i++) {
        probability[i] =
            light_estimate(scene, &scene->light[i], p) * (fraction ? fraction[i] : 1.0f);
        sum += probability[i];
        lit += probability[i] > 0.0f;
    }
    const float uniform = fraction ? UNIFORM_VISIBILITY : UNIFORM;
    float least = lit ? uniform / (float)lit : 0.0f;
    float scale = (1.0f - uniform) / sum;
    if (!(sum > 0.0f) || !isfinite(scale)) {  // no light contributes at p, so the choice does not
                                              // matter
        for (uint32_t i = 0; i < n; i++) probability[i] = 1.0f / (float)n;
        return;
    }
    for (uint32_t i = 0; i < n; i++)
        if (probability[i] > 0.0f) probability[i] = probability[i] * scale + least;
}

uint32_t light_choose(const struct satin_scene *scene, vec3 p, struct light_visibility visibility,
                      float *u, float *probability) {
    uint32_t n = scene->light_count, i = 0;
    if (n == 1) {
        *probability = 1.0f;
        return 0;
    }
    if (scene->light_tree) return light_tree_choose(scene, p, u, probability);
    float weight[LIGHT_WEIGHTS_MAX];
    light_choose_probabilities(scene, p, visibility, weight);
    uint32_t last = 0;
    for (; i < n; i++) {
        if (!(weight[i] > 0.0f)) continue;
        last = i;
        if (*u < weight[i]) break;
        *u -= weight[i];
    }
    *u = minf(*u / weight[last], SAMPLE_BELOW_ONE);
    *probability = weight[last];
    return last;
}

float light_choose_probability(const struct satin_scene *scene, vec3 p,
                               struct light_visibility visibility, uint32_t light) {
    if (scene->light_count == 1) return 1.0f;
    if (scene->light_tree) return light_tree_probability(scene, p, light);
    float weight[LIGHT_WEIGHTS_MAX];
    light_choose_probabilities(scene, p, visibility, weight);
    return weight[light];
}

// ---- Sampling ---------------------------------------------------------------------------------

bool light_sample_wi(const struct satin_scene *scene, uint32_t i, vec3 p, float u, float v,
                     struct light_sample *out) {
    return light_sample_visible(scene, i, LIGHT_ALL_VISIBLE, p, u, v, out);
}

static bool draw(const struct satin_scene *scene, uint32_t i, struct light_visibility visibility,
                 vec3 p, float u, float v, struct light_sample *out) {
    const struct light *light = &scene->light[i];
    switch (light->kind) {
        case LIGHT_AREA:
            return light_area_sample(scene, light, p, u, v, out);
        case LIGHT_BEAM:
            return light_beam_sample(scene, light, p, out);
        case LIGHT_POINT:
        case LIGHT_SPOT:
        case LIGHT_PROJECTOR:
            return light_point_sample(light, p, out);
        case LIGHT_DIRECTIONAL:
            *out = (struct light_sample){.wi = v3_neg(light->direction),
                                         .dist = INFINITY,
                                         .L = light->value,
                                         .pdf_w = 1.0f,
                                         .delta = true};
            return true;
        case LIGHT_CONSTANT:
        case LIGHT_ENVMAP:
            return light_environment_draw(scene, visibility.product, u, v, out);
    }
    return false;
}

bool light_sample_draw(const struct satin_scene *scene, uint32_t i,
                       struct light_visibility visibility, vec3 p, float u, float v,
                       struct light_sample *out) {
    if (!draw(scene, i, visibility, p, u, v, out)) return false;
    out->light = i;
    out->u = u;
    out->v = v;
    return true;
}

bool light_sample_read(const struct satin_scene *scene, struct light_visibility visibility,
                       struct light_sample *s) {
    return !s->unread || light_environment_read(scene, visibility.product, s);
}

bool light_sample_visible(const struct satin_scene *scene, uint32_t i,
                          struct light_visibility visibility, vec3 p, float u, float v,
                          struct light_sample *out) {
    return light_sample_draw(scene, i, visibility, p, u, v, out) &&
           light_sample_read(scene, visibility, out);
}

float light_pdf(const struct satin_scene *scene, vec3 p, vec3 wi, const struct interaction *s) {
    if (s->light < 0 || scene->light[s->light].kind != LIGHT_AREA) return 0.0f;
    return light_area_pdf(scene, &scene->light[s->light], p, wi, s);
}

rgb light_emitted(const struct satin_scene *scene, const struct interaction *s, vec3 w) {
    if (s->light < 0 || !(v3_dot(s->ng, w) > 0.0f)) return rgb_grey(0.0f);
    const struct light *light = &scene->light[s->light];
    if (light->kind != LIGHT_AREA) return rgb_grey(0.0f);
    struct texture_lookup at = scene_interaction_texture_lookup(scene, s);
    return light->texture ? scene_texture_eval(light->texture, &at) : light->value;
}

rgb light_at_hit(const struct satin_scene *scene, const struct interaction *hit, vec3 d) {
    return hit ? light_emitted(scene, hit, v3_neg(d)) : light_environment(scene, d);
}

struct ray light_shadow_ray(const struct satin_scene *scene, vec3 p, vec3 ng,
                            const struct light_sample *s) {
    if (isfinite(s->dist)) return scene_spawn_to(scene, p, ng, s->p, s->n);
    return scene_spawn(scene, p, ng, s->wi);
}
