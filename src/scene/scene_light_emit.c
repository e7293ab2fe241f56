// SPDX-License-Identifier: Apache-2.0
// Photons leave the lights: area lights by area and cosine, point and spot lights by their
// intensity, directional lights and environments through the sides of the scene's bounding box that
// face them, which wastes less than a disk around the bounding sphere and is as exact. All of them
// may be aimed (scene_light_aim.c).
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

float light_box_shadow(const struct light_target *box, vec3 d) {
    vec3 a = box_sides(box, d);
    return a.x + a.y + a.z;
}

float light_bounds_shadow(const struct satin_scene *scene, vec3 d) {
    struct light_target box = scene_bounds(scene);
    return light_box_shadow(&box, d);
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

// ---- Light from a place -----------------------------------------------------------------------

// The beam uniformly; the penumbra by an angle whose density falls linearly, as the intensity does.
static vec3 spot_direction(const struct light *light, float u, float v) {
    float beam, penumbra;
    light_spot_solid_angles(light, &beam, &penumbra);
    float share = beam / (beam + penumbra);
    if (u < share) return sample_uniform_cone(u / share, v, light->cos_beam);
    float rest = (u - share) / (1.0f - share), phi = 2.0f * PI_F * v;
    float c = acosf(light->cos_cutoff), b = acosf(light->cos_beam);
    float theta = c - (c - b) * safe_sqrtf(1.0f - rest), s = sinf(theta);
    return v3(s * cosf(phi), s * sinf(phi), cosf(theta));
}

// The intensity, relative to the light's value, over the density of spot_direction.
static float spot_power(const struct light *light, float cos_theta) {
    float beam, penumbra;
    light_spot_solid_angles(light, &beam, &penumbra);
    if (cos_theta >= light->cos_beam) return beam + penumbra;
    if (cos_theta <= light->cos_cutoff) return 0.0f;
    float c = acosf(light->cos_cutoff), b = acosf(light->cos_beam);
    // falloff sin(theta) 2 pi over its density 2 (c - theta) / (c - b)^2 (1 - share)
    return PI_F * safe_sqrtf(1.0f - sqrf(cos_theta)) * (c - b) * (beam + penumbra) / penumbra;
}

// Where a photon starts; the light sends it about frame.n, by the angle from it alone.
struct place {
    const struct light *light;
    vec3 p;
    struct frame frame;
};

static vec3 draw_direction(const struct place *at, float u, float v) {
    if (at->light->kind == LIGHT_AREA) return sample_cosine_hemisphere(u, v);
    if (at->light->kind == LIGHT_SPOT) return spot_direction(at->light, u, v);
    return sample_uniform_sphere(u, v);
}

// What the light sends along a direction over the density of draw_direction, which goes to *pdf_w.
static float direction_power(const struct place *at, float cos_theta, float *pdf_w) {
    float power;
    switch (at->light->kind) {
        case LIGHT_AREA:
            *pdf_w = fmaxf(cos_theta, 0.0f) * (1.0f / PI_F);
            return PI_F;
        case LIGHT_SPOT:
            power = spot_power(at->light, cos_theta);
            *pdf_w = power > 0.0f ? light_spot_falloff(at->light, cos_theta) / power : 0.0f;
            return power;
        default:
            *pdf_w = 0.25f / PI_F;
            return 4.0f * PI_F;
    }
}

// The direction of a photon and the factor of its power; 0: the light sends nothing there.
static vec3 aim_direction(const struct place *at, const struct light_aim *aim, const float u[2],
                          float *power) {
    float u0 = u[0], pdf_w;
    int spot = light_aim_choose(aim, &u0);
    vec3 d;
    if (!light_aim_direction(aim, spot, at->p, u0, u[1], &d))
        d = frame_to_world(&at->frame, draw_direction(at, u0, u[1]));
    *power = direction_power(at, v3_dot(d, at->frame.n), &pdf_w);
    *power *= light_aim_weight(aim, at->p, d, pdf_w);
    return d;
}

static bool emit_area(const struct satin_scene *scene, const struct light *light,
                      const struct light_aim *aim, const float u[4], struct light_ray *out) {
    struct light_point point = light_area_point(scene, light, u[0], u[1]);
    if (!(point.pdf_a > 0.0f)) return false;
    struct place at = {light, point.p, frame_from_normal(point.n)};
    float power;
    vec3 d = aim_direction(&at, aim, u + 2, &power);
    out->ray = scene_spawn(scene, point.p, point.n, d);
    out->power = rgb_scale(point.L, power / point.pdf_a);
    return power > 0.0f;
}

static bool emit_position(const struct light *light, const struct light_aim *aim, const float u[4],
                          struct light_ray *out) {
    struct place at = {light, light->position, {v3(1, 0, 0), v3(0, 1, 0), v3(0, 0, 1)}};
    if (light->kind == LIGHT_SPOT) at.frame = frame_from_normal(light->direction);
    float power;
    vec3 d = aim_direction(&at, aim, u + 2, &power);
    out->ray = (struct ray){light->position, 0.0f, d, INFINITY};
    out->power = rgb_scale(light->value, power);
    return power > 0.0f;
}

// ---- Light from infinitely far ----------------------------------------------------------------

// A ray along d through one of the aim's boxes; *area gets 1 over its density.
static bool aim_ray(const struct satin_scene *scene, const struct light_aim *aim, vec3 d,
                    const float u[2], struct ray *ray, float *area) {
    float u2[2] = {u[0], u[1]}, shadow;
    int spot = light_aim_choose(aim, &u2[0]);
    const struct light_target *box = spot < 0 ? &aim->all : &aim->spot[spot];
    if (!box_ray(scene, box, d, u2, ray, &shadow)) return false;
    float weight = light_aim_weight_ray(scene, aim, spot, ray);
    *area = light_box_shadow(&aim->all, d) * weight;
    return weight > 0.0f;
}

static bool emit_directional(const struct satin_scene *scene, const struct light *light,
                             const struct light_aim *aim, const float u[4], struct light_ray *out) {
    float area;
    if (!aim_ray(scene, aim, light->direction, u, &out->ray, &area)) return false;
    out->power = rgb_scale(light->value, area);
    return true;
}

static bool emit_environment(const struct satin_scene *scene, const struct light *light,
                             const struct light_aim *aim, const float u[4], struct light_ray *out) {
    vec3 w;
    rgb L;
    float pdf_w, area;
    if (!light_environment_sample(light, u[2], u[3], &w, &L, &pdf_w)) return false;
    if (!aim_ray(scene, aim, v3_neg(w), u, &out->ray, &area)) return false;
    out->power = rgb_scale(L, area / pdf_w);
    return true;
}

bool light_emit(const struct satin_scene *scene, uint32_t i, const struct light_aim *aim,
                const float u[4], struct light_ray *out) {
    const struct light *light = &scene->light[i];
    const struct light_aim none = {.all = scene_bounds(scene)};
    if (!aim) aim = &none;
    switch (light->kind) {
        case LIGHT_AREA:
            return emit_area(scene, light, aim, u, out);
        case LIGHT_POINT:
        case LIGHT_SPOT:
            return emit_position(light, aim, u, out);
        case LIGHT_DIRECTIONAL:
            return emit_directional(scene, light, aim, u, out);
        case LIGHT_CONSTANT:
        case LIGHT_ENVMAP:
            return emit_environment(scene, light, aim, u, out);
    }
    return false;
}
