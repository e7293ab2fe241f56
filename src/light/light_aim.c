// SPDX-License-Identifier: Apache-2.0
// Aimed emission: the photons of a light are emitted towards boxes, each by the light's own
// distribution restricted to the box. The density of a photon is that of the mixture, whichever
// box drew it, so its power is exact, and where there are spots at most 1 / LIGHT_COVERED times
// that without them [the balance heuristic of Veach 1997, 9.2.2]. Each cover has the probability of
// being hit, so that photons have about the same power.
#include "base/sampling.h"
#include "light/light_kinds.h"

// The least half angle of a cone: floats do not resolve a narrower one.
#define CONE_LEAST 4e-6f

// ---- Mixtures -----------------------------------------------------------------------------------

// Sets the probabilities of boxes by the sizes in which the light sees them. False if no cover has
// one.
static bool set_probabilities(const struct light_aim *aim, const float *size,
                              struct light_mixture *out) {
    const int spots = aim->count - aim->covers;
    const float covered = spots ? LIGHT_COVERED : 1.0f;
    float sum = 0.0f;
    for (int i = 0; i < aim->covers; i++) sum += size[i];
    if (!(sum > 0.0f)) return false;
    out->covers = aim->covers;
    out->count = aim->count;
    for (int i = 0; i < aim->count; i++)
        out->probability[i] =
            i < aim->covers ? covered * size[i] / sum : (1.0f - covered) / (float)spots;
    return true;
}

// Chooses a box by *u, which is then rescaled to [0, 1).
static int choose_box(const struct light_mixture *mixture, float *u) {
    int i = 0;
    while (i < mixture->count - 1 && *u >= mixture->probability[i]) *u -= mixture->probability[i++];
    while (i > 0 && !(mixture->probability[i] > 0.0f)) i--;
    *u = clampf(*u / mixture->probability[i], 0.0f, SAMPLE_BELOW_ONE);
    return i;
}

// The sum over boxes of their probability times the density by each; 0 if no cover has any.
static float mixed_density(const struct light_mixture *mixture, const float *density) {
    float sum = 0.0f;
    for (int i = 0; i < mixture->count; i++) {
        if (i == mixture->covers && !(sum > 0.0f)) return 0.0f;
        sum += mixture->probability[i] * density[i];
    }
    return sum;
}

// ---- Light from infinitely far: rays through boxes --------------------------------------------

// Clips [*near, *far] to where o + t d is within [lo, hi] along one axis.
static void clip_slab(float o, float d, float lo, float hi, float *near, float *far) {
    float a = (lo - o) / d, b = (hi - o) / d;
    if (d == 0.0f) {
        if (o < lo || o > hi) *far = -INFINITY;
        return;
    }
    *near = fmaxf(*near, fminf(a, b));
    *far = fminf(*far, fmaxf(a, b));
}

// Whether the ray's line crosses the box, which may be flat.
static bool crosses(const struct ray *ray, const struct light_target *box, float slack) {
    float near = -INFINITY, far = INFINITY;
    clip_slab(ray->o.x, ray->d.x, box->lo.x - slack, box->hi.x + slack, &near, &far);
    clip_slab(ray->o.y, ray->d.y, box->lo.y - slack, box->hi.y + slack, &near, &far);
    clip_slab(ray->o.z, ray->d.z, box->lo.z - slack, box->hi.z + slack, &near, &far);
    return near <= far;
}

bool light_aim_rays(const struct light_aim *aim, vec3 d, struct light_rays *out) {
    for (int i = 0; i < aim->count; i++) out->area[i] = light_box_projected_area(&aim->box[i], d);
    out->aim = aim;
    return set_probabilities(aim, out->area, &out->mixture);
}

int light_rays_choose(const struct light_rays *rays, float *u) {
    return choose_box(&rays->mixture, u);
}

float light_rays_area(const struct light_rays *rays, float slack, int chosen,
                      const struct ray *ray) {
    float density[LIGHT_BOXES];
    for (int i = 0; i < rays->mixture.count; i++) {
        const bool hit = i == chosen || crosses(ray, &rays->aim->box[i], slack);
        density[i] = hit && rays->area[i] > 0.0f ? 1.0f / rays->area[i] : 0.0f;
    }
    const float sum = mixed_density(&rays->mixture, density);
    return sum > 0.0f ? 1.0f / sum : 0.0f;
}

// ---- Light from a point: cones about boxes ----------------------------------------------------

// The cone around the box's bounding sphere. False if p is so near that the cone would be wide.
static bool cone_to(const struct light_target *box, vec3 p, struct light_cone *out) {
    vec3 centre = v3_mul(v3_add(box->lo, box->hi), 0.5f), d = v3_sub(centre, p);
    float r2 = 0.25f * v3_dist2(box->lo, box->hi), d2 = v3_len2(d);
    if (!(d2 > 2.0f * r2)) return false;
    out->axis = v3_unit(d);
    out->cos_max = fminf(safe_sqrtf(1.0f - r2 / d2), 1.0f - CONE_LEAST);
    out->solid_angle = 2.0f * PI_F * (1.0f - out->cos_max);
    return true;
}

void light_aim_cones(const struct light_aim *aim, vec3 p, float solid_angle,
                     struct light_cones *out) {
    float size[LIGHT_BOXES];
    for (int i = 0; i < aim->count; i++) {
        struct light_cone *cone = &out->cone[i];
        if (!cone_to(&aim->box[i], p, cone) || !(cone->solid_angle < solid_angle))
            cone->solid_angle = INFINITY;
        size[i] = fminf(cone->solid_angle / solid_angle, 1.0f);
    }
    set_probabilities(aim, size, &out->mixture);
}

bool light_cones_draw(const struct light_cones *cones, float *u, float v, vec3 *d) {
    const struct light_cone *cone = &cones->cone[choose_box(&cones->mixture, u)];
    if (!isfinite(cone->solid_angle)) return false;
    struct frame frame = frame_from_normal(cone->axis);
    *d = frame_to_world(&frame, sample_uniform_cone(*u, v, 1.0f - cone->cos_max));
    return true;
}

float light_cones_weight(const struct light_cones *cones, vec3 d, float pdf_w) {
    float density[LIGHT_BOXES];
    for (int i = 0; i < cones->mixture.count; i++) {
        const struct light_cone *cone = &cones->cone[i];
        density[i] = pdf_w;
        if (isfinite(cone->solid_angle))
            density[i] = v3_dot(d, cone->axis) >= cone->cos_max ? 1.0f / cone->solid_angle : 0.0f;
    }
    const float sum = mixed_density(&cones->mixture, density);
    return sum > 0.0f ? pdf_w / sum : 0.0f;
}
