// SPDX-License-Identifier: Apache-2.0
// Before the render, a few rays check whether the camera sees anything, and if not, why: otherwise
// the image would be black without explanation.
#include "base/sampling.h"
#include "scene/scene.h"

enum { RAYS = 1024 };

// What the rays hit, with and without the clip planes. Where one of them sees something, all is
// well, and the others are not traced.
struct camera_look {
    bool seen;
    int there;
    float first, last;  // least and largest depth of the hits, measured as for the clip planes
};

static struct camera_look trace_eye_rays(const struct satin_scene *scene,
                                         const struct camera *camera) {
    const struct scene_film *film = &scene->film;
    struct camera_look out = {.first = INFINITY};
    for (uint32_t i = 0; i < RAYS && !out.seen; i++) {
        const vec2 at = sample_sobol2(i, 0);
        const vec2 pixel = {(float)film->crop_x + at.x * (float)film->crop_width,
                            (float)film->crop_y + at.y * (float)film->crop_height};
        struct ray ray = scene_camera_ray(scene, camera, pixel, (vec2){0.5f, 0.5f}, NULL);
        out.seen = scene_occluded(scene, &ray);
        // Depth per distance along the ray, and depth of the ray's origin.
        float rate = camera->spherical ? 1.0f : camera->near_clip / ray.tnear, start = 0.0f;
        if (camera->orthographic && !(camera->aperture > 0.0f)) {
            start = camera->near_clip;
            rate = (camera->far_clip - camera->near_clip) / ray.tfar;
        }
        ray.tnear = 0.0f;
        ray.tfar = INFINITY;
        const float depth = start + rate * scene_distance(scene, &ray);
        if (!isfinite(depth)) continue;
        out.there++;
        out.first = fminf(out.first, depth);
        out.last = fmaxf(out.last, depth);
    }
    return out;
}

// Whether all corners of the scene's bounds are behind the camera.
static bool scene_is_behind(const struct satin_scene *scene, const struct camera *camera) {
    if (camera->spherical) return false;
    const vec3 eye = mat4_point(&camera->to_world, v3(0, 0, 0)),
               d = mat4_vector(&camera->to_world, v3(0, 0, 1)), lo = scene->bounds_lo,
               hi = scene->bounds_hi;
    for (int i = 0; i < 8; i++) {
        const vec3 corner = v3(i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z);
        if (v3_dot(v3_sub(corner, eye), d) > 0.0f) return false;
    }
    return true;
}

// Warns if nothing can be seen by any camera.
static bool check_shapes(const struct satin_scene *scene, struct log log) {
    const bool empty = scene->shape_count == 0 && scene->environment < 0;
    const bool dark = scene->shape_count > 0 && scene->light_count == 0;
    if (empty) log_message(log, SATIN_LOG_WARNING, "the scene has no shapes: nothing is seen");
    if (dark) log_message(log, SATIN_LOG_WARNING, "the scene emits no light: the image is black");
    return empty || dark;
}

bool scene_camera_check(const struct satin_scene *scene, const struct camera *camera,
                        struct log log) {
    const bool warned = check_shapes(scene, log);
    if (scene->shape_count == 0) return warned;
    const struct camera_look l = trace_eye_rays(scene, camera);
    if (l.seen) return warned;
    if (l.there > 0 && l.first >= camera->far_clip)
        log_message(log, SATIN_LOG_WARNING,
                    "far_clip %g lies before the scene, which begins at %g: no shape is seen",
                    (double)camera->far_clip, (double)l.first);
    else if (l.there > 0 && l.last <= camera->near_clip)
        log_message(log, SATIN_LOG_WARNING,
                    "near_clip %g lies behind the scene, which ends at %g: no shape is seen",
                    (double)camera->near_clip, (double)l.last);
    else if (l.there > 0)
        log_message(log, SATIN_LOG_WARNING,
                    "no shape is seen between near_clip %g and far_clip %g: the first begins at "
                    "%g, the last at %g",
                    (double)camera->near_clip, (double)camera->far_clip, (double)l.first,
                    (double)l.last);
    else if (scene->environment < 0)
        log_message(log, SATIN_LOG_WARNING, "none of %d camera rays hits a shape%s", RAYS,
                    scene_is_behind(scene, camera) ? ": the scene is behind it" : "");
    return warned || l.there > 0 || scene->environment < 0;
}
