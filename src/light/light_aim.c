// SPDX-License-Identifier: Apache-2.0
// Aimed emission: most photons of a light are emitted towards boxes, each by the light's own
// distribution restricted to the box. The density of a photon is that of the mixture, whichever
// target drew it, so its power is exact, and at most 1 / LIGHT_UNAIMED times that without aim [the
// balance heuristic of Veach 1997, 9.2.2].
#include "base/sampling.h"
#include "light/light_kinds.h"

// The least half angle of a cone: floats do not resolve a narrower one.
#define CONE_LEAST 4e-6f

static float target_probability(const struct light_aim *aim) {
    return (1.0f - LIGHT_UNAIMED) / (float)aim->count;
}

int light_aim_choose(const struct light_aim *aim, float *u) {
    if (aim->count == 0) return -1;
    if (*u < LIGHT_UNAIMED) {
        *u /= LIGHT_UNAIMED;
        return -1;
    }
    float x = (*u - LIGHT_UNAIMED) / target_probability(aim);
    int i = x < (float)aim->count ? (int)x : aim->count - 1;
    *u = fminf(x - (float)i, SAMPLE_BELOW_ONE);
    return i;
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

static float density(const struct light_target *box, const struct ray *ray) {
    float projected = light_box_projected_area(box, ray->d);
    return projected > 0.0f ? 1.0f / projected : 0.0f;
}

float light_aim_weight_ray(const struct satin_scene *scene, const struct light_aim *aim, int chosen,
                           const struct ray *ray) {
    if (aim->count == 0) return 1.0f;
    const float slack = 1e-5f * scene->radius;
    if (chosen >= 0 && !crosses(ray, &aim->all, slack)) return 0.0f;
    float all = density(&aim->all, ray), sum = LIGHT_UNAIMED * all;
    for (int i = 0; i < aim->count; i++)
        if (i == chosen || crosses(ray, &aim->target[i], slack))
            sum += target_probability(aim) * density(&aim->target[i], ray);
    return sum > 0.0f ? all / sum : 0.0f;
}

// ---- Light from a point: cones about boxes ----------------------------------------------------

struct target_cone {
    vec3 axis;
    float cos_max;
};

// The cone around the box's bounding sphere. False if p is so near that the cone would be wide.
static bool cone_to(const struct light_target *box, vec3 p, struct target_cone *out) {
    vec3 centre = v3_mul(v3_add(box->lo, box->hi), 0.5f), d = v3_sub(centre, p);
    float r2 = 0.25f * v3_dist2(box->lo, box->hi), d2 = v3_len2(d);
    if (!(d2 > 2.0f * r2)) return false;
    out->axis = v3_unit(d);
    out->cos_max = fminf(safe_sqrtf(1.0f - r2 / d2), 1.0f - CONE_LEAST);
    return true;
}

bool light_aim_direction(const struct light_aim *aim, int chosen, vec3 p, float u, float v,
                         vec3 *d) {
    struct target_cone cone;
    if (chosen < 0 || !cone_to(&aim->target[chosen], p, &cone)) return false;
    struct frame frame = frame_from_normal(cone.axis);
    *d = frame_to_world(&frame, sample_uniform_cone(u, v, 1.0f - cone.cos_max));
    return true;
}

float light_aim_weight(const struct light_aim *aim, vec3 p, vec3 d, float pdf_w) {
    if (aim->count == 0) return 1.0f;
    float sum = LIGHT_UNAIMED * pdf_w;
    for (int i = 0; i < aim->count; i++) {
        struct target_cone cone;
        float pdf = pdf_w;  // too near the box: the light's own density
        if (cone_to(&aim->target[i], p, &cone))
            pdf = v3_dot(d, cone.axis) >= cone.cos_max
                      ? 1.0f / (2.0f * PI_F * (1.0f - cone.cos_max))
                      : 0.0f;
        sum += target_probability(aim) * pdf;
    }
    return sum > 0.0f ? pdf_w / sum : 0.0f;
}
