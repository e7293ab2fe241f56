// SPDX-License-Identifier: Apache-2.0
// Eye rays, and film positions drawn from the pixel filter.
#include "base/sampling.h"
#include "scene/scene.h"

// Parallel rays from the near plane. Their width is constant, so that the width over distance is
// correct only at the middle of the scene.
static struct ray parallel_ray(const struct satin_scene *scene, const struct camera *camera,
                               vec3 plane, float *spread) {
    vec3 o = mat4_point(&camera->to_world, v3(plane.x, plane.y, camera->near_clip));
    vec3 d = v3_unit(mat4_vector(&camera->to_world, v3(0, 0, 1)));
    vec3 middle = v3_mul(v3_add(scene->bounds_lo, scene->bounds_hi), 0.5f);
    vec3 x = mat4_vector(&camera->to_world, v3(2.0f * camera->tan_x, 0, 0));
    float distance = fmaxf(v3_dot(v3_sub(middle, o), d), 0.1f * scene->radius);
    if (spread) *spread = v3_len(x) / (float)scene->film.width / distance;
    return (struct ray){o, 0.0f, d, camera->far_clip - camera->near_clip};
}

struct ray scene_camera_ray(const struct satin_scene *scene, const struct camera *camera, vec2 film,
                            vec2 lens, float *spread) {
    const int columns = scene->film.width, rows = scene->film.height;
    // The film position on the plane z = 1, where x points left and y up.
    float s = film.x / (float)columns + camera->shift.x;
    float t = film.y / (float)rows + camera->shift.y;
    vec3 plane = v3(camera->tan_x * (1.0f - 2.0f * s), camera->tan_y * (1.0f - 2.0f * t), 1.0f);
    if (camera->orthographic) return parallel_ray(scene, camera, plane, spread);
    vec3 origin = v3(0, 0, 0), d = v3_unit(plane);
    // A pixel's width on that plane, as the eye sees it: the square root of its solid angle, w^2
    // cos^3.
    float width = 2.0f * camera->tan_x / (float)columns;
    if (spread) *spread = width * d.z * sqrtf(d.z);
    if (camera->aperture > 0.0f) {
        vec2 disk = sample_disk(lens.x, lens.y);
        origin = v3(camera->aperture * disk.x, camera->aperture * disk.y, 0.0f);
        d = v3_unit(v3_mad(plane, -1.0f / camera->focus_distance, origin));
    }
    return (struct ray){mat4_point(&camera->to_world, origin), camera->near_clip / d.z,
                        v3_unit(mat4_vector(&camera->to_world, d)), camera->far_clip / d.z};
}
