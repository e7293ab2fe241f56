// SPDX-License-Identifier: Apache-2.0
// Eye rays, and film positions drawn from the pixel filter.
#include "base/sampling.h"
#include "scene/scene.h"

// The width of parallel rays is constant, so that the width over distance is correct only at the
// middle of the scene.
static float parallel_spread(const struct satin_scene *scene, const struct camera *camera, vec3 o,
                             vec3 d) {
    vec3 middle = v3_mul(v3_add(scene->bounds_lo, scene->bounds_hi), 0.5f);
    vec3 x = mat4_vector(&camera->to_world, v3(2.0f * camera->tan_x, 0, 0));
    float distance = fmaxf(v3_dot(v3_sub(middle, o), d), 0.1f * scene->radius);
    return v3_len(x) / (float)scene->film.width / distance;
}

// Parallel rays from the near plane.
static struct ray parallel_ray(const struct satin_scene *scene, const struct camera *camera,
                               vec3 plane, float *spread) {
    vec3 o = mat4_point(&camera->to_world, v3(plane.x, plane.y, camera->near_clip));
    vec3 d = v3_unit(mat4_vector(&camera->to_world, v3(0, 0, 1)));
    if (spread) *spread = parallel_spread(scene, camera, o, d);
    return (struct ray){o, 0.0f, d, camera->far_clip - camera->near_clip};
}

// Rays from a disk around the film position to the point in focus before it, as in Mitsuba 0.6's
// telecentric camera: through every point of the lens there are parallel rays of all pixels.
static struct ray telecentric_ray(const struct satin_scene *scene, const struct camera *camera,
                                  vec3 plane, vec2 lens, float *spread) {
    const vec2 disk = sample_disk(lens.x, lens.y);
    const float x = camera->aperture * disk.x, y = camera->aperture * disk.y;
    const vec3 o = mat4_point(&camera->to_world, v3(plane.x + x, plane.y + y, 0.0f));
    // Per unit of depth in camera space.
    const vec3 along = mat4_vector(
        &camera->to_world, v3(-x / camera->focus_distance, -y / camera->focus_distance, 1.0f));
    const float length = v3_len(along);
    const vec3 d = v3_mul(along, 1.0f / length);
    if (spread) *spread = parallel_spread(scene, camera, o, d);
    return (struct ray){o, camera->near_clip * length, d, camera->far_clip * length};
}

// Rays to all directions by longitude and latitude: +z in the middle of the film and +y above, as
// in Mitsuba 0.6. The width is that of the longer side of a pixel, which near the poles is its
// height, so that no row of the film asks for finer records or texels than another.
static struct ray spherical_ray(const struct satin_scene *scene, const struct camera *camera,
                                float s, float t, float *spread) {
    const float phi = 2.0f * PI_F * s, theta = PI_F * t, sine = fmaxf(sinf(theta), 0.0f);
    const vec3 d = v3(sinf(phi) * sine, cosf(theta), -cosf(phi) * sine);
    if (spread)
        *spread =
            fmaxf(2.0f * PI_F * sine / (float)scene->film.width, PI_F / (float)scene->film.height);
    return (struct ray){mat4_point(&camera->to_world, v3(0, 0, 0)), camera->near_clip,
                        v3_unit(mat4_vector(&camera->to_world, d)), camera->far_clip};
}

struct ray scene_camera_ray(const struct satin_scene *scene, const struct camera *camera, vec2 film,
                            vec2 lens, float *spread) {
    const int columns = scene->film.width, rows = scene->film.height;
    float s = film.x / (float)columns + camera->shift.x;
    float t = film.y / (float)rows + camera->shift.y;
    if (camera->spherical) return spherical_ray(scene, camera, s, t, spread);
    // The film position on the plane z = 1, where x points left and y up.
    vec3 plane = v3(camera->tan_x * (1.0f - 2.0f * s), camera->tan_y * (1.0f - 2.0f * t), 1.0f);
    if (camera->orthographic && camera->aperture > 0.0f)
        return telecentric_ray(scene, camera, plane, lens, spread);
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
