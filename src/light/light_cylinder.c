// SPDX-License-Identifier: Apache-2.0
// Cylinders that emit outwards, as fluorescent tubes: directions to them have angles around a line
// through the point along their axis, whose sines are drawn uniformly, and angles to the plane
// across that line, which are drawn uniformly.
#include "base/sampling.h"
#include "light/light_kinds.h"
#include "light/light_line.h"

// The largest relative difference of the scales across the axis of a cylinder that is round, and
// the largest cosine between its axes.
static const float ROUND = 1e-3f;
// A point outside by less than this fraction of the radius is lit as one within: by area.
static const float OUTSIDE = 1e-3f;

struct light_tube {
    vec3 from, axis;  // one end, and the unit vector to the other
    float length, radius;
};

// A tube relative to a point outside it.
struct tube_bearing {
    vec3 side;         // unit vector across the axis towards the point
    float foot, away;  // of the point: the distance along the axis from its beginning, and from it
    float sine;        // of half the angle that the tube subtends across its axis
};

static bool is_round(vec3 x, vec3 y, vec3 z) {
    const float a = v3_len(x), b = v3_len(y), c = v3_len(z);
    return fabsf(a - b) <= ROUND * a && fabsf(v3_dot(x, y)) <= ROUND * a * b &&
           fabsf(v3_dot(x, z)) <= ROUND * a * c && fabsf(v3_dot(y, z)) <= ROUND * b * c;
}

satin_status light_tube_build(struct satin_scene *scene, struct light *light) {
    const struct shape *shape = &scene->shape[light->shape];
    const vec3 x = mat4_vector(&shape->to_world, v3(1.0f, 0.0f, 0.0f));
    const vec3 y = mat4_vector(&shape->to_world, v3(0.0f, 1.0f, 0.0f));
    const vec3 z = mat4_vector(&shape->to_world, v3(0.0f, 0.0f, 1.0f));
    if (shape->flip_normals || !is_round(x, y, z)) return SATIN_OK;
    struct light_tube *tube = arena_alloc(&scene->arena, sizeof *tube);
    if (!tube) return SATIN_ERROR_MEMORY;
    tube->from = mat4_point(&shape->to_world, v3(0.0f, 0.0f, 0.0f));
    tube->length = v3_len(z);
    tube->axis = v3_mul(z, 1.0f / tube->length);
    tube->radius = v3_len(x);
    light->tube = tube;
    return SATIN_OK;
}

// False if it must be sampled by area from p.
static bool take_bearing(const struct light_tube *tube, vec3 p, struct tube_bearing *bearing) {
    const vec3 d = v3_sub(p, tube->from);
    bearing->foot = v3_dot(d, tube->axis);
    const vec3 across = v3_mad(d, -bearing->foot, tube->axis);
    bearing->away = v3_len(across);
    if (!(bearing->away > (1.0f + OUTSIDE) * tube->radius)) return false;
    bearing->side = v3_mul(across, 1.0f / bearing->away);
    bearing->sine = tube->radius / bearing->away;
    return bearing->sine > 0.0f;
}

// The density over solid angle of a point at this distance, whose angle across the axis has this
// cosine.
static float tube_pdf(const struct tube_bearing *bearing, const struct light_line *line,
                      float distance, float cosine) {
    return cosine * distance / (2.0f * bearing->sine * line->angle * line->away);
}

bool light_tube_sample(const struct light_tube *tube, vec3 p, float u, float v,
                       struct light_tube_point *out) {
    struct tube_bearing bearing;
    struct light_line line;
    if (!take_bearing(tube, p, &bearing)) return false;
    const float sine = (2.0f * u - 1.0f) * bearing.sine, cosine = sqrtf(1.0f - sqrf(sine));
    const float inside = safe_sqrtf(sqrf(tube->radius) - sqrf(bearing.away * sine));
    const vec3 across =
        v3_mad(v3_mul(bearing.side, -cosine), sine, v3_cross(tube->axis, bearing.side));
    if (!light_line_make(tube->length, bearing.foot, bearing.away * cosine - inside, &line))
        return false;
    const float along = light_line_sample(&line, v) - bearing.foot;
    const vec3 d = v3_mad(v3_mul(across, line.away), along, tube->axis);
    out->p = v3_add(p, d);
    out->n = v3_unit(v3_mad(v3_mul(bearing.side, bearing.away), line.away, across));
    out->pdf_w = tube_pdf(&bearing, &line, v3_len(d), cosine);
    return true;
}

bool light_tube_pdf(const struct light_tube *tube, vec3 p, vec3 q, float *pdf_w) {
    struct tube_bearing bearing;
    struct light_line line;
    if (!take_bearing(tube, p, &bearing)) return false;
    const vec3 d = v3_sub(q, p);
    const vec3 across = v3_mad(d, -v3_dot(d, tube->axis), tube->axis);
    if (!light_line_make(tube->length, bearing.foot, v3_len(across), &line)) return false;
    const float cosine = -v3_dot(across, bearing.side) / line.away;
    *pdf_w = tube_pdf(&bearing, &line, v3_len(d), fmaxf(cosine, 0.0f));
    return true;
}

float light_tube_closeness(const struct light_tube *tube, vec3 p) {
    const vec3 d = v3_sub(p, tube->from);
    const float foot = v3_dot(d, tube->axis);
    const float away = fmaxf(v3_len(v3_mad(d, -foot, tube->axis)), tube->radius);
    return light_line_closeness(tube->length, foot, away);
}
