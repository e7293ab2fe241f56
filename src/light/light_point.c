// SPDX-License-Identifier: Apache-2.0
// Lights at a point: uniform in all directions, in a cone (spot), or through a slide (projector).
// Units and texture coordinates were measured on Mitsuba 3.9.
#include "base/sampling.h"
#include "light/light_kinds.h"

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

// ---- Slides -------------------------------------------------------------------------------------

static rgb slide(const struct light *light, vec2 uv) {
    struct texture_lookup at = scene_texture_at(uv);
    return light->texture ? rgb_mul(light->value, scene_texture_eval(light->texture, &at))
                          : light->value;
}

// A spot's texture covers the square around its cone.
static rgb spot_color(const struct light *light, vec3 d) {
    if (!light->texture) return light->value;
    vec3 l = mat4_vector(&light->to_local, d);
    float scale = 0.5f / (l.z * tanf(acosf(light->cos_cutoff)));
    return slide(light, (vec2){0.5f + l.x * scale, 0.5f + l.y * scale});
}

// The point at which d (light space) meets the projector's slide. False if it misses the slide.
static bool slide_uv(const struct light *light, vec3 d, vec2 *uv) {
    *uv =
        (vec2){0.5f - 0.5f * d.x / (d.z * light->tan_x), 0.5f - 0.5f * d.y / (d.z * light->tan_y)};
    return d.z > 0.0f && uv->x >= 0.0f && uv->x <= 1.0f && uv->y >= 0.0f && uv->y <= 1.0f;
}

// A plane at unit distance in light space gets pi times the slide's value as irradiance, which
// needs an intensity in proportion to 1 / cos^3 of the angle to the axis. Returns the intensity
// over the slide's value for direction d, and in *uv the slide's point; 0 if d misses the slide.
static float projector_factor(const struct light *light, vec3 d, vec2 *uv) {
    vec3 axis = mat4_vector(&light->to_world, v3(0, 0, 1)), l = mat4_vector(&light->to_local, d);
    if (!slide_uv(light, l, uv)) return 0.0f;
    return PI_F / (l.z * l.z * v3_dot(axis, d));
}

// The power of a slide of irradiance 1: intensity times solid angle is pi times the slide's area,
// over the length of the light's z axis in world units.
static float slide_power(const struct light *light) {
    float length = v3_len(mat4_vector(&light->to_world, v3(0, 0, 1)));
    return 4.0f * light->tan_x * light->tan_y * PI_F * length;
}

// ---- Direct lighting ----------------------------------------------------------------------------

float light_point_estimate(const struct light *light, vec3 p) {
    vec3 d = v3_sub(p, light->position);
    float d2 = fmaxf(v3_len2(d), 1e-20f), f = 1.0f;
    vec2 uv;
    if (light->kind == LIGHT_SPOT)
        f = light_spot_falloff(light, v3_dot(d, light->direction) / sqrtf(d2));
    if (light->kind == LIGHT_PROJECTOR)
        f = slide_uv(light, mat4_vector(&light->to_local, d), &uv) ? 1.0f : 0.0f;
    return light->strength * f / d2;
}

bool light_point_sample(const struct light *light, vec3 p, struct light_sample *out) {
    vec3 d = v3_sub(light->position, p);
    float d2 = v3_len2(d), dist = sqrtf(d2);
    if (!(dist > 0.0f)) return false;
    vec3 wi = v3_mul(d, 1.0f / dist);
    float scale = 1.0f / d2;
    rgb color = light->value;
    if (light->kind == LIGHT_SPOT) {
        scale *= light_spot_falloff(light, -v3_dot(wi, light->direction));
        color = spot_color(light, v3_neg(wi));
    }
    if (light->kind == LIGHT_PROJECTOR) {
        vec2 uv;
        scale *= projector_factor(light, v3_neg(wi), &uv);
        color = slide(light, uv);
    }
    if (!(scale > 0.0f) || !isfinite(scale) || rgb_black(color) || !rgb_finite(color)) return false;
    *out = (struct light_sample){.wi = wi,
                                 .p = light->position,
                                 .dist = dist,
                                 .L = rgb_scale(color, scale),
                                 .pdf_w = 1.0f,
                                 .delta = true};
    return true;
}

// ---- Emission -----------------------------------------------------------------------------------

// Draws a direction: uniformly in the cone of full intensity, and in the penumbra by an angle whose
// density falls linearly, as the intensity does.
static vec3 spot_direction(const struct light *light, float u, float v) {
    float beam, penumbra;
    light_spot_solid_angles(light, &beam, &penumbra);
    float in_beam = beam / (beam + penumbra);
    if (u < in_beam) return sample_uniform_cone(u / in_beam, v, 1.0f - light->cos_beam);
    float rest = (u - in_beam) / (1.0f - in_beam), phi = 2.0f * PI_F * v;
    float c = acosf(light->cos_cutoff), b = acosf(light->cos_beam);
    float theta = c - (c - b) * safe_sqrtf(1.0f - rest), s = sinf(theta);
    return v3(s * cosf(phi), s * sinf(phi), cosf(theta));
}

// The intensity, relative to the light's colour, over the density of spot_direction.
static float spot_power(const struct light *light, float cos_theta) {
    float beam, penumbra;
    light_spot_solid_angles(light, &beam, &penumbra);
    if (cos_theta >= light->cos_beam) return beam + penumbra;
    if (cos_theta <= light->cos_cutoff) return 0.0f;
    float c = acosf(light->cos_cutoff), b = acosf(light->cos_beam);
    // falloff sin(theta) 2 pi over its density 2 (c - theta) / (c - b)^2 (1 - in_beam)
    return PI_F * safe_sqrtf(1.0f - sqrf(cos_theta)) * (c - b) * (beam + penumbra) / penumbra;
}

vec3 light_point_direction(const struct light *light, float u, float v) {
    if (light->kind == LIGHT_SPOT) {
        struct frame frame = frame_from_normal(light->direction);
        return frame_to_world(&frame, spot_direction(light, u, v));
    }
    if (light->kind != LIGHT_PROJECTOR) return sample_uniform_sphere(u, v);
    // The irradiance is uniform over the slide, so points on it are drawn uniformly.
    vec3 l = v3(light->tan_x * (1.0f - 2.0f * u), light->tan_y * (1.0f - 2.0f * v), 1.0f);
    return v3_unit(mat4_vector(&light->to_world, l));
}

float light_point_power(const struct light *light, vec3 d, rgb *color, float *pdf_w) {
    *color = light->value;
    if (light->kind == LIGHT_SPOT) {
        float cos_theta = v3_dot(d, light->direction), power = spot_power(light, cos_theta);
        *pdf_w = power > 0.0f ? light_spot_falloff(light, cos_theta) / power : 0.0f;
        if (power > 0.0f) *color = spot_color(light, d);
        return power;
    }
    if (light->kind == LIGHT_PROJECTOR) {
        vec2 uv;
        float intensity = projector_factor(light, d, &uv), power = slide_power(light);
        *pdf_w = intensity / power;
        if (intensity > 0.0f) *color = slide(light, uv);
        return intensity > 0.0f ? power : 0.0f;
    }
    *pdf_w = 0.25f / PI_F;
    return 4.0f * PI_F;
}

float light_point_solid_angle(const struct light *light) {
    float beam = 4.0f * PI_F, penumbra = 0.0f;
    if (light->kind == LIGHT_PROJECTOR) return 4.0f * light->tan_x * light->tan_y;
    if (light->kind == LIGHT_SPOT) light_spot_solid_angles(light, &beam, &penumbra);
    return beam + penumbra;
}

// ---- Preparation --------------------------------------------------------------------------------

// The mean emitted power over a grid of the random numbers.
static float mean_power(const struct light *light) {
    enum { PROFILE_GRID = 64 };
    double sum = 0.0;
    for (int i = 0; i < PROFILE_GRID * PROFILE_GRID; i++) {
        float u = ((float)(i / PROFILE_GRID) + 0.5f) / PROFILE_GRID,
              v = ((float)(i % PROFILE_GRID) + 0.5f) / PROFILE_GRID, pdf_w;
        rgb color;
        float power = light_point_power(light, light_point_direction(light, u, v), &color, &pdf_w);
        sum += (double)(power * rgb_luminance(color));
    }
    return (float)(sum / (PROFILE_GRID * PROFILE_GRID));
}

void light_point_prepare(struct light *light) {
    const float solid_angle = light_point_solid_angle(light);
    light->strength = rgb_luminance(light->value);
    light->power = solid_angle * light->strength;
    if (light->kind == LIGHT_PROJECTOR) {
        light->power = slide_power(light) * light->strength;
        light->strength = light->power / solid_angle;
    }
    if (!light->texture) return;
    float plain = light->power;
    light->power = mean_power(light);
    light->strength *= light->power / plain;
}
