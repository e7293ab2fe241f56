// SPDX-License-Identifier: Apache-2.0
// Cylinders that emit outwards, as fluorescent tubes: directions to them have angles around a line
// through the point along their axis, whose sines are drawn uniformly, and angles to the plane
// across that line, which are drawn uniformly.
#include "base/sampling.h"
#include "light/light_kinds.h"
#include "light/light_line.h"

// The largest relative difference of the scales across the axis of a cylinder that is round, and
// the largest cosine between its axes.
static const float ROUND = 1e-4f;
// A point outside by less than this fraction of the radius is lit as one within: by area.
static const float OUTSIDE = 1e-3f;

struct light_tube {
    vec3 from;          // one end
    struct frame axes;  // n: along the axis, away from that end; u and v: those of the shape
    float length, radius;
    struct mat4 to_world;  // of the shape
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
    tube->radius = v3_len(x);
    tube->to_world = shape->to_world;
    tube->axes = (struct frame){v3_unit(x), v3_unit(y), v3_mul(z, 1.0f / tube->length)};
    light->tube = tube;
    return SATIN_OK;
}

// False if it must be sampled by area from p.
static bool take_bearing(const struct light_tube *tube, vec3 p, struct tube_bearing *bearing) {
    const vec3 d = v3_sub(p, tube->from);
    bearing->foot = v3_dot(d, tube->axes.n);
    const vec3 across = v3_mad(d, -bearing->foot, tube->axes.n);
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

// The point of the tube whose normal has these components along the axes, at z in [0, 1]. It is
// computed in double, as the surface that rays find is: a point within it would be in its own
// shadow.
static vec3 tube_point(const struct light_tube *tube, float x, float y, float z) {
    const double scale = 1.0 / sqrt((double)x * x + (double)y * y);
    const double at[3] = {scale * x, scale * y, z};
    double p[3];
    for (int i = 0; i < 3; i++) {
        const float *row = tube->to_world.m[i];
        p[i] = row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3];
    }
    return v3((float)p[0], (float)p[1], (float)p[2]);
}

bool light_tube_sample(const struct light_tube *tube, vec3 p, float u, float v,
                       struct light_tube_point *out) {
    struct tube_bearing bearing;
    struct light_line line;
    if (!take_bearing(tube, p, &bearing)) return false;
    // Lengths as they would be without differences of such as are much larger.
    const float ratio = 2.0f * u - 1.0f, radius = tube->radius, away = bearing.away;
    const float inside2 = 4.0f * u * (1.0f - u) * sqrf(radius);  // half the chord through the tube
    const float outside2 = (away - radius) * (away + radius);    // the tangent to it
    const float middle = sqrtf(outside2 + inside2);              // of the chord
    if (!light_line_make(tube->length, bearing.foot, outside2 / (middle + sqrtf(inside2)), &line))
        return false;
    const float at = light_line_sample(&line, v);
    const float distance = sqrtf(sqrf(line.away) + sqrf(at - bearing.foot));
    out->pdf_w = tube_pdf(&bearing, &line, distance, middle / away);
    // The sine and cosine of the angle around the axis.
    const float around = ratio * line.away / away, facing = sqrtf(1.0f - sqrf(around));
    const vec3 across = v3_cross(tube->axes.n, bearing.side);
    out->n = v3_mad(v3_mul(bearing.side, facing), around, across);
    const float x = v3_dot(out->n, tube->axes.u), y = v3_dot(out->n, tube->axes.v);
    out->uv = (vec2){azimuth_fraction(y, x), at / tube->length};
    out->p = tube_point(tube, x, y, out->uv.y);
    return true;
}

bool light_tube_pdf(const struct light_tube *tube, vec3 p, vec3 q, float *pdf_w) {
    struct tube_bearing bearing;
    struct light_line line;
    if (!take_bearing(tube, p, &bearing)) return false;
    const vec3 d = v3_sub(q, p);
    const vec3 across = v3_mad(d, -v3_dot(d, tube->axes.n), tube->axes.n);
    if (!light_line_make(tube->length, bearing.foot, v3_len(across), &line)) return false;
    const float cosine = -v3_dot(across, bearing.side) / line.away;
    *pdf_w = tube_pdf(&bearing, &line, v3_len(d), fmaxf(cosine, 0.0f));
    return true;
}

float light_tube_closeness(const struct light_tube *tube, vec3 p) {
    const vec3 d = v3_sub(p, tube->from);
    const float foot = v3_dot(d, tube->axes.n);
    const float away = fmaxf(v3_len(v3_mad(d, -foot, tube->axes.n)), tube->radius);
    return light_line_closeness(tube->length, foot, away);
}
