// SPDX-License-Identifier: Apache-2.0
// Emission of photons: from area lights by area and cosine, from lights at a point by their
// intensity (light_point.c), from directional lights and environments through those sides of the
// scene's bounding box that face them. The latter wastes fewer photons than a disk around the
// bounding sphere and is as exact. All of them can be aimed (light_aim.c).
#include "base/sampling.h"
#include "light/light_kinds.h"

static struct light_target bounds_of_scene(const struct satin_scene *scene) {
    return (struct light_target){scene->bounds_lo, scene->bounds_hi};
}

// The areas of the box's sides across x, y and z, projected along d.
static vec3 box_sides(const struct light_target *box, vec3 d) {
    vec3 s = v3_sub(box->hi, box->lo);
    return v3(s.y * s.z * fabsf(d.x), s.x * s.z * fabsf(d.y), s.x * s.y * fabsf(d.z));
}

float light_box_projected_area(const struct light_target *box, vec3 d) {
    vec3 a = box_sides(box, d);
    return a.x + a.y + a.z;
}

float light_bounds_projected_area(const struct satin_scene *scene, vec3 d) {
    struct light_target box = bounds_of_scene(scene);
    return light_box_projected_area(&box, d);
}

float light_box_area(const struct light_target *box) {
    vec3 s = v3_sub(box->hi, box->lo);
    return 2.0f * (s.x * s.y + s.y * s.z + s.z * s.x);
}

float light_bounds_area(const struct satin_scene *scene) {
    struct light_target box = bounds_of_scene(scene);
    return light_box_area(&box);
}

// A ray along d into the box, uniform over its projected area.
static bool box_ray(const struct satin_scene *scene, const struct light_target *box, vec3 d,
                    const float u[2], struct ray *ray) {
    vec3 side = box_sides(box, d), lo = box->lo, hi = box->hi, size = v3_sub(hi, lo), p;
    const float projected = side.x + side.y + side.z;
    if (!(projected > 0.0f)) return false;
    float x = u[0] * projected, v = u[1];
    if (x < side.x) {
        p = v3(d.x > 0.0f ? lo.x : hi.x, lo.y + size.y * (x / side.x), lo.z + size.z * v);
    } else if (x < side.x + side.y || !(side.z > 0.0f)) {
        x = fminf((x - side.x) / side.y, 1.0f);
        p = v3(lo.x + size.x * x, d.y > 0.0f ? lo.y : hi.y, lo.z + size.z * v);
    } else {
        x = fminf((x - side.x - side.y) / side.z, 1.0f);
        p = v3(lo.x + size.x * x, lo.y + size.y * v, d.z > 0.0f ? lo.z : hi.z);
    }
    // The box is within the scene's bounds, so this is outside of all surfaces.
    *ray = (struct ray){v3_mad(p, -2.1f * scene->radius, d), 0.0f, d, INFINITY};
    return true;
}

// ---- Light from a point -----------------------------------------------------------------------

static bool emit_area(const struct satin_scene *scene, const struct light *light,
                      const struct light_aim *aim, const float u[4], struct light_ray *out) {
    struct light_point point = light_area_point(scene, light, u[0], u[1]);
    if (!(point.pdf_a > 0.0f)) return false;
    struct frame frame = frame_from_normal(point.n);
    struct light_cones cones;
    float u2 = u[2];
    vec3 d;
    light_aim_cones(aim, point.p, PI_F, &cones);
    if (!light_cones_draw(&cones, &u2, u[3], &d))
        d = frame_to_world(&frame, sample_cosine_hemisphere(u2, u[3]));
    float pdf_w = fmaxf(v3_dot(d, frame.n), 0.0f) * (1.0f / PI_F);
    float power = PI_F * light_cones_weight(&cones, d, pdf_w);
    out->ray = scene_spawn(scene, point.p, point.n, d);
    out->power = rgb_scale(point.L, power / point.pdf_a);
    return power > 0.0f;
}

static bool emit_beam(const struct satin_scene *scene, const struct light *light, const float u[4],
                      struct light_ray *out) {
    struct light_point point = light_area_point(scene, light, u[0], u[1]);
    out->ray = scene_spawn(scene, point.p, point.n, point.n);
    out->power = rgb_scale(point.L, 1.0f / point.pdf_a);
    return point.pdf_a > 0.0f;
}

static bool emit_position(const struct light *light, const struct light_aim *aim, const float u[4],
                          struct light_ray *out) {
    struct light_cones cones;
    float u2 = u[2];
    vec3 d;
    rgb color;
    light_aim_cones(aim, light->position, light_point_solid_angle(light), &cones);
    if (!light_cones_draw(&cones, &u2, u[3], &d)) d = light_point_direction(light, u2, u[3]);
    float pdf_w, power = light_point_power(light, d, &color, &pdf_w);
    power *= light_cones_weight(&cones, d, pdf_w);
    out->ray = (struct ray){light->position, 0.0f, d, INFINITY};
    out->power = rgb_scale(color, power);
    return power > 0.0f && !rgb_black(color);
}

// ---- Light from infinitely far ----------------------------------------------------------------

// A ray along d through one of the aim's boxes or its openings. *area is set to 1 over its density.
// Sets the ray and out->entering.
static bool aim_ray(const struct satin_scene *scene, const struct light_aim *aim, vec3 d,
                    const float u[2], struct light_ray *out, float *area) {
    struct ray *ray = &out->ray;
    const bool open = aim->openings && light_openings_face(aim->openings, d);
    const float entering = open ? LIGHT_ENTERING : 0.0f;
    struct light_rays rays;
    int chosen = -1;
    if (!light_aim_rays(aim, d, &rays)) return false;
    if (u[0] < entering) {
        const vec3 p = light_openings_point(aim->openings, d, u[0] / entering, u[1]);
        *ray = (struct ray){v3_mad(p, -2.1f * scene->radius, d), 0.0f, d, INFINITY};
    } else {
        float u2[2] = {fminf((u[0] - entering) / (1.0f - entering), SAMPLE_BELOW_ONE), u[1]};
        chosen = light_rays_choose(&rays, &u2[0]);
        if (!box_ray(scene, &aim->box[chosen], d, u2, ray)) return false;
    }
    *area = light_rays_area(&rays, 1e-5f * scene->radius, chosen, ray);
    if (!(*area > 0.0f)) return false;
    if (open) {
        const float boxes = (1.0f - entering) / *area;
        *area = 1.0f / (boxes + entering * light_openings_density(aim->openings, ray));
        out->entering = 1.0f / (*area * (boxes + entering * light_openings_most(aim->openings, d)));
    }
    return true;
}

static bool emit_directional(const struct satin_scene *scene, const struct light *light,
                             const struct light_aim *aim, const float u[4], struct light_ray *out) {
    float area;
    if (!aim_ray(scene, aim, light->direction, u, out, &area)) return false;
    out->power = rgb_scale(light->value, area);
    return true;
}

static bool emit_environment(const struct satin_scene *scene, const struct light_aim *aim,
                             const float u[4], struct light_ray *out) {
    struct light_sample s;
    float area;
    const uint32_t light = (uint32_t)scene->environment;
    if (!light_sample_wi(scene, light, v3(0, 0, 0), u[2], u[3], &s)) return false;
    if (!aim_ray(scene, aim, v3_neg(s.wi), u, out, &area)) return false;
    out->power = rgb_scale(s.L, area / s.pdf_w);
    return true;
}

bool light_emit(const struct satin_scene *scene, uint32_t i, const struct light_aim *aim,
                const float u[4], struct light_ray *out) {
    const struct light *light = &scene->light[i];
    const struct light_aim scene_box = {1, 1, {bounds_of_scene(scene)}, NULL};
    if (!aim || (aim->openings && !light_is_far(light))) aim = &scene_box;
    out->entering = 1.0f;
    switch (light->kind) {
        case LIGHT_AREA:
            return emit_area(scene, light, aim, u, out);
        case LIGHT_BEAM:
            return emit_beam(scene, light, u, out);
        case LIGHT_POINT:
        case LIGHT_SPOT:
        case LIGHT_PROJECTOR:
            return emit_position(light, aim, u, out);
        case LIGHT_DIRECTIONAL:
            return emit_directional(scene, light, aim, u, out);
        case LIGHT_CONSTANT:
        case LIGHT_ENVMAP:
            return emit_environment(scene, aim, u, out);
    }
    return false;
}
