// SPDX-License-Identifier: Apache-2.0
// Photons leave the lights: area lights by area and cosine, point and spot lights by their
// intensity, directional lights and environments through the sides of the scene's bounding box that
// face them, which wastes less than a disk around the bounding sphere and is as exact.
#include "base/sampling.h"
#include "scene/scene_light.h"

static struct light_target scene_bounds(const struct satin_scene *scene) {
    return (struct light_target){scene->bounds_lo, scene->bounds_hi};
}

// What the box's sides across x, y and z show in direction d.
static vec3 box_sides(const struct light_target *box, vec3 d) {
    vec3 s = v3_sub(box->hi, box->lo);
    return v3(s.y * s.z * fabsf(d.x), s.x * s.z * fabsf(d.y), s.x * s.y * fabsf(d.z));
}

float light_bounds_shadow(const struct satin_scene *scene, vec3 d) {
    struct light_target box = scene_bounds(scene);
    vec3 a = box_sides(&box, d);
    return a.x + a.y + a.z;
}

float light_bounds_area(const struct satin_scene *scene) {
    vec3 s = v3_sub(scene->bounds_hi, scene->bounds_lo);
    return 2.0f * (s.x * s.y + s.y * s.z + s.z * s.x);
}

// A ray into the box along d, uniform over the area that the box shows; that area goes to *shadow.
static bool box_ray(const struct satin_scene *scene, const struct light_target *box, vec3 d,
                    const float u[2], struct ray *ray, float *shadow) {
    vec3 side = box_sides(box, d), lo = box->lo, hi = box->hi, size = v3_sub(hi, lo), p;
    *shadow = side.x + side.y + side.z;
    if (!(*shadow > 0.0f)) return false;
    float x = u[0] * *shadow, v = u[1];
    if (x < side.x) {
        p = v3(d.x > 0.0f ? lo.x : hi.x, lo.y + size.y * (x / side.x), lo.z + size.z * v);
    } else if (x < side.x + side.y || !(side.z > 0.0f)) {
        x = fminf((x - side.x) / side.y, 1.0f);
        p = v3(lo.x + size.x * x, d.y > 0.0f ? lo.y : hi.y, lo.z + size.z * v);
    } else {
        x = fminf((x - side.x - side.y) / side.z, 1.0f);
        p = v3(lo.x + size.x * x, lo.y + size.y * v, d.z > 0.0f ? lo.z : hi.z);
    }
    // The box lies in the scene's bounds, so this is outside of everything.
    *ray = (struct ray){v3_mad(p, -2.1f * scene->radius, d), 0.0f, d, INFINITY};
    return true;
}

float light_spot_falloff(const struct light *light, float cos_theta) {
    if (cos_theta >= light->cos_beam) return 1.0f;
    if (cos_theta <= light->cos_cutoff) return 0.0f;
    float cutoff = acosf(light->cos_cutoff), beam = acosf(light->cos_beam);
    return (cutoff - acosf(cos_theta)) / (cutoff - beam);
}

void light_spot_solid_angles(const struct light *light, float *beam, float *penumbra) {
    double c = acos((double)light->cos_cutoff), b = acos((double)light->cos_beam);
    *beam = (float)(2.0 * M_PI * (1.0 - cos(b)));
    // The integral of sin t (c - t) / (c - b) from b to c.
    double integral = c > b ? cos(b) - (sin(c) - sin(b)) / (c - b) : 0.0;
    *penumbra = (float)(2.0 * M_PI * fmax(integral, 0.0));
}

static bool emit_area(const struct satin_scene *scene, const struct light *light, const float u[4],
                      struct light_ray *out) {
    struct light_point at = light_area_point(scene, light, u[0], u[1]);
    struct frame f = frame_from_normal(at.n);
    vec3 d = frame_to_world(&f, sample_cosine_hemisphere(u[2], u[3]));
    if (!(at.pdf_a > 0.0f)) return false;
    out->ray = scene_spawn(scene, at.p, at.n, d);
    out->power = rgb_scale(at.L, PI_F / at.pdf_a);
    return true;
}

// The beam uniformly; the penumbra by an angle whose density falls linearly, as the intensity does.
static bool emit_spot(const struct light *light, const float u[4], struct light_ray *out) {
    float beam, penumbra;
    light_spot_solid_angles(light, &beam, &penumbra);
    float total = beam + penumbra, share = beam / total;
    vec3 l;
    if (u[2] < share) {
        l = sample_uniform_cone(u[2] / share, u[3], light->cos_beam);
        out->power = rgb_scale(light->value, total);
    } else {
        float rest = (u[2] - share) / (1.0f - share), phi = 2.0f * PI_F * u[3];
        float c = acosf(light->cos_cutoff), b = acosf(light->cos_beam);
        float theta = c - (c - b) * safe_sqrtf(1.0f - rest), s = sinf(theta);
        l = v3(s * cosf(phi), s * sinf(phi), cosf(theta));
        // falloff sin(theta) 2 pi over its density 2 (c - theta) / (c - b)^2 (1 - share)
        out->power = rgb_scale(light->value, PI_F * s * (c - b) / (1.0f - share));
    }
    struct frame f = frame_from_normal(light->direction);
    out->ray = (struct ray){light->position, 0.0f, frame_to_world(&f, l), INFINITY};
    return total > 0.0f;
}

static bool emit_point(const struct light *light, const float u[4], struct light_ray *out) {
    out->ray = (struct ray){light->position, 0.0f, sample_uniform_sphere(u[2], u[3]), INFINITY};
    out->power = rgb_scale(light->value, 4.0f * PI_F);
    return true;
}

static bool emit_directional(const struct satin_scene *scene, const struct light *light,
                             const struct light_target *target, const float u[4],
                             struct light_ray *out) {
    float shadow;
    if (!box_ray(scene, target, light->direction, u, &out->ray, &shadow)) return false;
    out->power = rgb_scale(light->value, shadow);
    return true;
}

static bool emit_environment(const struct satin_scene *scene, const struct light *light,
                             const struct light_target *target, const float u[4],
                             struct light_ray *out) {
    vec3 w;
    rgb L;
    float pdf_w, shadow;
    if (!light_environment_sample(light, u[2], u[3], &w, &L, &pdf_w)) return false;
    if (!box_ray(scene, target, v3_neg(w), u, &out->ray, &shadow)) return false;
    out->power = rgb_scale(L, shadow / pdf_w);
    return true;
}

bool light_emit(const struct satin_scene *scene, uint32_t i, const struct light_target *target,
                const float u[4], struct light_ray *out) {
    const struct light *light = &scene->light[i];
    struct light_target all = scene_bounds(scene);
    if (!target) target = &all;
    switch (light->kind) {
        case LIGHT_AREA:
            return emit_area(scene, light, u, out);
        case LIGHT_POINT:
            return emit_point(light, u, out);
        case LIGHT_SPOT:
            return emit_spot(light, u, out);
        case LIGHT_DIRECTIONAL:
            return emit_directional(scene, light, target, u, out);
        case LIGHT_CONSTANT:
        case LIGHT_ENVMAP:
            return emit_environment(scene, light, target, u, out);
    }
    return false;
}
