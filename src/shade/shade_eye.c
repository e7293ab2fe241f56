// SPDX-License-Identifier: Apache-2.0
// Eye rays through ideal specular surfaces: E S* x and E S* L of the path table.
#include "shade/shade_eye.h"

enum {
    // At the first specular surfaces, up to this number, both reflection and refraction are
    // followed.
    SPLIT_DEPTH = 2,
    EYE_DEPTH = 64  // specular surfaces in a row after which the ray ends
};

// Branches with a throughput below this undergo Russian roulette.
static const float SPLIT_LEAST = 0.02f;

struct eye_path {
    struct ray ray;
    rgb T;
    float distance;
    int depth, splits;
};

struct sampler shade_eye_sampler(const struct gather *g, int x, int y, uint32_t index,
                                 enum rng_stream stream) {
    uint64_t pixel = (uint64_t)(uint32_t)y << 32 | (uint32_t)x;
    uint64_t key = rng_mix(pixel ^ (rng_mix(g->options->seed) + (uint64_t)stream));
    return (struct sampler){index, (uint32_t)(key >> 32), 0};
}

struct ray shade_eye_ray(const struct shade *shade, int x, int y, struct sampler *sampler,
                         struct shade_camera_sample *out) {
    const struct satin_scene *scene = shade->g->scene;
    const struct scene_film *film = &scene->film;
    vec2 pixel = sampler_2d(sampler), lens = sampler_2d(sampler);
    float cx = (float)(film->crop_x + x) + 0.5f, cy = (float)(film->crop_y + y) + 0.5f;
    struct scene_film_offset x_offset = scene_film_filter_offset(
        &shade->filter, cx, (float)film->crop_x, (float)(film->crop_x + film->crop_width), pixel.x);
    struct scene_film_offset y_offset =
        scene_film_filter_offset(&shade->filter, cy, (float)film->crop_y,
                                 (float)(film->crop_y + film->crop_height), pixel.y);
    *out = (struct shade_camera_sample){.weight = x_offset.weight * y_offset.weight,
                                        .film = {cx + x_offset.x, cy + y_offset.x},
                                        .at = lens};
    return scene_camera_ray(scene, shade->camera, out->film, lens, &out->spread);
}

static void add_emission(const struct shade *shade, const struct eye_path *path,
                         const struct interaction *s, rgb *sum) {
    const satin_options *o = shade->g->options;
    if (o->max_depth == 0 || (path->depth == 0 && o->hide_emitters > 0)) return;
    *sum = rgb_fma(*sum, path->T, light_at_hit(shade->g->scene, s, path->ray.d));
}

// Pushes the rays that leave an ideal specular surface. Returns the new height of the stack.
static int push_specular(const struct shade *shade, const struct eye_path *path,
                         const struct shading_point *p, struct sampler *sampler,
                         struct eye_path *stack, int top) {
    struct brdf_sample lobe[2];
    int lobes = brdf_delta(&p->brdf, p->wo_l, BRDF_RADIANCE, lobe);
    if (brdf_is_polished(&p->brdf) &&
        (!lobes || !brdf_facet(&p->brdf, p->wo_l, sampler_2d(sampler), BRDF_RADIANCE, lobe)))
        return top;
    bool split = path->splits < SPLIT_DEPTH && top + lobes <= SHADE_VERTICES;
    if (lobes > 1 && !split) {
        float total = lobe[0].probability + lobe[1].probability;
        float first = total > 0.0f ? lobe[0].probability / total : 0.5f;
        int chosen = sampler_1d(sampler) < first ? 0 : 1;
        lobe[0] = lobe[chosen];
        float q = chosen ? 1.0f - first : first;
        lobe[0].weight = rgb_scale(lobe[0].weight, 1.0f / q);
        lobes = 1;
    }
    for (int i = 0; i < lobes; i++) {
        rgb T = rgb_mul(path->T, lobe[i].weight);
        float throughput = rgb_max(T);
        if (!(throughput > 0.0f)) continue;
        if (throughput < SPLIT_LEAST) {
            if (!(sampler_1d(sampler) < throughput / SPLIT_LEAST)) continue;
            T = rgb_scale(T, SPLIT_LEAST / throughput);
        }
        vec3 d = frame_to_world(&p->frame, lobe[i].wi);
        stack[top++] = (struct eye_path){
            scene_spawn(shade->g->scene, p->interaction.p, p->interaction.ng, d), T,
            path->distance + p->interaction.t, path->depth + 1, path->splits + (lobes > 1)};
    }
    return top;
}

// Finds the components of a blend: all if the stack can hold their branches, else one that is
// drawn.
static int find_components(const struct satin_scene *scene, const struct interaction *s, vec3 d,
                           int taken, struct scene_component component[MATERIAL_COMPONENTS_MAX]) {
    int components = scene_components(scene, s, v3_neg(d), component);
    if (components == 1 || taken + 2 * components <= SHADE_VERTICES) return components;
    component[0] = (struct scene_component){scene_draw_component(scene, s, v3_neg(d)), 1.0f};
    return 1;
}

void shade_eye_trace(const struct shade *shade, int x, int y, struct sampler *sampler,
                     struct shade_eye *out) {
    const struct satin_scene *scene = shade->g->scene;
    const int max_depth = shade->g->options->max_depth;
    struct eye_path stack[SHADE_VERTICES + 2];
    struct ray ray = shade_eye_ray(shade, x, y, sampler, &out->camera);
    const float spread = out->camera.spread;
    stack[0] = (struct eye_path){ray, rgb_grey(1.0f), 0.0f, 0, 0};
    out->count = 0;
    out->hit = false;
    out->emission = rgb_grey(0.0f);
    for (int top = 1; top > 0;) {
        struct eye_path path = stack[--top];
        struct interaction s;
        bool hit = scene_intersect(scene, &path.ray, &s);
        add_emission(shade, &path, hit ? &s : NULL, &out->emission);
        if (!hit) continue;
        const float distance = path.distance + s.t;
        s.footprint = shade->sharpness * spread * distance;
        struct scene_component component[MATERIAL_COMPONENTS_MAX];
        const struct material_side *shown =
            path.depth == 0 ? scene_draw_component(scene, &s, v3_neg(path.ray.d)) : NULL;
        int components = find_components(scene, &s, path.ray.d, out->count + top, component);
        for (int i = 0; i < components; i++) {
            struct shading_point point;
            struct eye_path own = path;
            own.T = rgb_scale(path.T, component[i].weight);
            scene_shading_point_of(scene, component[i].side, &s, path.ray.d, &point);
            if (component[i].side == shown) {
                out->hit = true;
                out->first = point;
            }
            if (max_depth >= 0 && path.depth + 1 >= max_depth) continue;
            if ((point.lobes & BRDF_SMOOTH) && out->count < SHADE_VERTICES)
                out->vertex[out->count++] = (struct shade_vertex){
                    point, own.T, distance, spread * distance, path.depth + 1};
            if ((point.lobes & BRDF_DELTA) && path.depth < EYE_DEPTH)
                top = push_specular(shade, &own, &point, sampler, stack, top);
        }
    }
}

bool shade_eye_emission(const struct shade *shade, int x, int y, struct sampler *sampler, rgb *Le,
                        float *weight) {
    const struct satin_scene *scene = shade->g->scene;
    struct shade_camera_sample camera;
    const struct ray ray = shade_eye_ray(shade, x, y, sampler, &camera);
    struct interaction s;
    const bool hit = scene_intersect(scene, &ray, &s);
    if (hit && scene_shape_has_delta(scene, s.shape)) return false;
    const struct eye_path path = {.ray = ray, .T = rgb_grey(1.0f)};
    *Le = rgb_grey(0.0f);
    add_emission(shade, &path, hit ? &s : NULL, Le);
    *weight = camera.weight;
    return true;
}

const struct shade_vertex *shade_eye_choose(const struct shade_eye *eye, float u,
                                            float *probability) {
    float total = 0.0f;
    for (int i = 0; i < eye->count; i++) total += rgb_max(eye->vertex[i].T);
    float left = u * total;
    for (int i = 0; i < eye->count; i++) {
        const float T = rgb_max(eye->vertex[i].T);
        left -= T;
        if (!(left < 0.0f)) continue;
        if (probability) *probability = T / total;
        return &eye->vertex[i];
    }
    return NULL;
}
