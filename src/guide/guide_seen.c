// SPDX-License-Identifier: Apache-2.0
// Finds the region of the scene that is visible, in any of the images, by a few paths: from an eye
// to x, the first surface that is not ideal specular, and from there along a direction of a gather
// ray. The median length of these rays limits the radius of photon lookups. Boxes around the points
// x, and around the ideal specular surfaces that the rays hit, show where caustic photons are
// useful. A box holds the fraction of the points that is nearest to their median, so that a few
// distant points, as on a ground that extends to the horizon, do not enlarge all boxes.
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "guide/guide.h"

enum { SPECULAR_MAX = 16 };

static const double QUANTILE[GUIDE_SEEN_BOXES] = {1.0, 0.9, 0.5};

struct point {
    vec3 p;
    float distance;  // from the median
};

struct cloud {
    struct point point[GUIDE_SEEN_PATHS_MAX];
    int count;
};

static int compare_points(const void *a, const void *b) {
    return array_compare_floats(&((const struct point *)a)->distance,
                                &((const struct point *)b)->distance);
}

static void add(struct cloud *cloud, vec3 p) { cloud->point[cloud->count++].p = p; }

// ---- Boxes ------------------------------------------------------------------------------------

static float median(const struct cloud *cloud, int axis) {
    float x[GUIDE_SEEN_PATHS_MAX];
    for (int i = 0; i < cloud->count; i++) x[i] = v3_along(cloud->point[i].p, axis);
    qsort(x, (size_t)cloud->count, sizeof *x, array_compare_floats);
    return x[cloud->count / 2];
}

static void make_boxes(struct cloud *cloud, struct light_target *box) {
    vec3 middle = v3(median(cloud, 0), median(cloud, 1), median(cloud, 2));
    for (int i = 0; i < cloud->count; i++) {
        vec3 d = v3_sub(cloud->point[i].p, middle);
        cloud->point[i].distance = fmaxf(fabsf(d.x), fmaxf(fabsf(d.y), fabsf(d.z)));
    }
    qsort(cloud->point, (size_t)cloud->count, sizeof *cloud->point, compare_points);
    for (int k = 0; k < GUIDE_SEEN_BOXES; k++) {
        vec3 lo = middle, hi = middle;
        for (int i = 0; i < (int)(QUANTILE[k] * cloud->count); i++) {
            lo = v3_min(lo, cloud->point[i].p);
            hi = v3_max(hi, cloud->point[i].p);
        }
        // Larger by a tenth on all sides, as the points are only a sample.
        vec3 more = v3_mul(v3_sub(hi, lo), 0.1f);
        box[k] = (struct light_target){v3_sub(lo, more), v3_add(hi, more)};
    }
}

// ---- Paths ------------------------------------------------------------------------------------

bool guide_seen_follow(const struct satin_scene *scene, struct ray *ray, struct rng *rng,
                       struct interaction *s, vec3 *n, struct light_chain *chain) {
    *chain = light_chain_begin(ray);
    for (int i = 0; i < SPECULAR_MAX; i++) {
        struct brdf b;
        struct frame frame;
        struct brdf_sample next;
        vec3 wo = v3_neg(ray->d);
        if (!scene_intersect(scene, ray, s) || !scene_brdf(scene, s, wo, &b, &frame)) return false;
        *n = frame.n;
        if (brdf_lobes(&b) & BRDF_SMOOTH) return true;
        float u = rng_float(rng);
        const vec3 wo_l = frame_to_local(&frame, wo);
        if (!brdf_sample_wi(&b, wo_l, u, (vec2){0.5f, 0.5f}, BRDF_DELTA, BRDF_RADIANCE, &next))
            return false;
        light_chain_pass(chain, scene, s, wo, wo_l, &next);
        *ray = scene_spawn(scene, s->p, s->ng, frame_to_world(&frame, next.wi));
    }
    return false;
}

bool guide_seen_eye(const struct satin_scene *scene, uint32_t i, struct rng *rng,
                    struct interaction *s, vec3 *n) {
    const struct scene_film *film = &scene->film;
    const vec2 pixel = sample_sobol2(i, 0);
    const vec2 at = {(float)film->crop_x + pixel.x * (float)film->crop_width,
                     (float)film->crop_y + pixel.y * (float)film->crop_height};
    struct ray ray =
        scene_camera_ray(scene, scene_camera_sample(scene, i), at, (vec2){0.5f, 0.5f}, NULL);
    struct light_chain chain;
    return guide_seen_follow(scene, &ray, rng, s, n, &chain);
}

// The hits of a path.
struct seen_path {
    bool seen, hit, specular;  // whether x was found, a surface behind it, and whether that is
                               // ideal specular
    vec3 x, end;               // positions of x and of that surface
    float length;              // distance between them
};

struct seen_paths {
    const struct satin_scene *scene;
    uint64_t seed;
    struct seen_path path[GUIDE_SEEN_PATHS_MAX];
};

static void trace_seen(void *ctx, size_t begin, size_t end, int worker) {
    struct seen_paths *paths = ctx;
    const struct satin_scene *scene = paths->scene;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(paths->seed, RNG_SEEN, i);
        const vec2 direction = sample_sobol2((uint32_t)i, 1);
        struct seen_path *path = &paths->path[i];
        struct interaction s;
        vec3 n = v3(0, 0, 1);
        *path = (struct seen_path){.seen = guide_seen_eye(scene, (uint32_t)i, &rng, &s, &n)};
        if (!path->seen) continue;
        path->x = s.p;
        const struct frame frame = frame_from_normal(n);
        const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(direction.x, direction.y));
        struct ray ray = scene_spawn(scene, s.p, s.ng, d);
        path->hit = scene_intersect(scene, &ray, &s);
        if (!path->hit) continue;
        path->end = s.p;
        path->length = s.t;
        path->specular = scene_shape_has_delta(scene, s.shape);
    }
}

void guide_seen_make(const struct satin_scene *scene, uint64_t seed, int paths,
                     struct parallel *pool, struct guide_seen *out) {
    struct seen_paths traced = {.scene = scene, .seed = seed};
    struct cloud seen = {.count = 0}, specular = {.count = 0};
    float length[GUIDE_SEEN_PATHS_MAX];
    int hits = 0;
    parallel_for_all(pool, (size_t)paths, GUIDE_SEEN_CHUNK, trace_seen, &traced);
    for (int i = 0; i < paths; i++) {
        const struct seen_path *path = &traced.path[i];
        if (path->seen) add(&seen, path->x);
        if (path->hit) length[hits++] = path->length;
        if (path->specular) add(&specular, path->end);
    }
    *out = (struct guide_seen){
        .ray_length = INFINITY, .count = seen.count, .specular_count = specular.count};
    qsort(length, (size_t)hits, sizeof *length, array_compare_floats);
    if (hits > 0) out->ray_length = length[hits / 2];
    if (seen.count > 0) make_boxes(&seen, out->box);
    if (specular.count > 0) make_boxes(&specular, out->specular_box);
}
