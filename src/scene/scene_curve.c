// SPDX-License-Identifier: Apache-2.0
// Curves: reading, and the surface at a hit. v runs along all segments of a shape from 0 to 1, as
// in Mitsuba; u around the tube, from an axis of our own.
#include "scene/scene_curve.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "scene/scene_mesh.h"
#include "scene/scene_mesh_text.h"

// Share of the radius that hits are moved outwards by: above the error with which Embree finds
// round curves (up to some 1e-4 where they bend), and too little to be seen.
#define OUTSIDE 1e-3f

// ---- Reading ------------------------------------------------------------------------------------

struct reader {
    const struct scene_source *source;
    struct mesh_text text;
    const struct mat4 *to_world;
    float *point;
    uint32_t *first;
    size_t points, point_capacity, segments, first_capacity;
    size_t start;   // of the curve that is being read
    size_t needed;  // points of a segment
};

static satin_status read_point(struct reader *r) {
    double value[4];
    for (int i = 0; i < 4; i++) {
        mesh_text_skip_blanks(&r->text);
        if (!mesh_text_number(&r->text, &value[i]) || !isfinite((float)value[i]))
            return mesh_error(r->source, r->text.line, "expected a point: x y z radius");
    }
    vec3 p = mat4_point(r->to_world, v3((float)value[0], (float)value[1], (float)value[2]));
    if (!(value[3] >= 0.0 && value[3] < 1e15) || !(v3_max_abs(p) < 1e15f))
        return mesh_error(r->source, r->text.line, "the point or its radius is out of range");
    if (!array_reserve((void **)&r->point, &r->point_capacity, r->points * 4 + 4, sizeof(float)))
        return mesh_no_memory(r->source);
    const float out[4] = {p.x, p.y, p.z, (float)value[3]};
    memcpy(r->point + r->points++ * 4, out, sizeof out);
    return SATIN_OK;
}

// Ends a curve: its segments start at every point that has enough after it.
static satin_status end_curve(struct reader *r) {
    size_t count = r->points - r->start;
    if (!count) return SATIN_OK;
    if (count < r->needed)
        return mesh_error(r->source, r->text.line, "a curve of %zu points, but it needs %zu", count,
                          r->needed);
    if (!array_reserve((void **)&r->first, &r->first_capacity, r->segments + count,
                       sizeof *r->first))
        return mesh_no_memory(r->source);
    for (size_t i = 0; i + r->needed <= count; i++)
        r->first[r->segments++] = (uint32_t)(r->start + i);
    r->start = r->points;
    return SATIN_OK;
}

static satin_status read_lines(struct reader *r) {
    satin_status status = SATIN_OK;
    for (; r->text.at < r->text.end && status == SATIN_OK; mesh_text_next_line(&r->text)) {
        mesh_text_skip_blanks(&r->text);
        bool blank = r->text.at == r->text.end || *r->text.at == '\n';
        status = blank ? end_curve(r) : read_point(r);
        mesh_text_skip_blanks(&r->text);
        if (status == SATIN_OK && r->text.at < r->text.end && *r->text.at != '\n')
            status = mesh_error(r->source, r->text.line, "expected a point: x y z radius");
    }
    if (status == SATIN_OK) status = end_curve(r);
    if (status == SATIN_OK && !r->segments)
        status = mesh_error(r->source, 0, "there is no curve in it");
    return status;
}

// One bit per neighbour that a segment has in its curve, as Embree wants them.
static uint8_t *neighbour_flags(struct arena *arena, const struct reader *r) {
    uint8_t *flags = arena_array(arena, r->segments, 1);
    for (size_t i = 0; flags && i < r->segments; i++) {
        bool left = i > 0 && r->first[i - 1] + 1 == r->first[i];
        bool right = i + 1 < r->segments && r->first[i] + 1 == r->first[i + 1];
        flags[i] = (uint8_t)(left | right << 1);
    }
    return flags;
}

static satin_status keep(const struct reader *r, bool linear, struct curves *out) {
    struct arena *arena = r->source->arena;
    struct curves c = {.segments = (uint32_t)r->segments, .linear = linear};
    float *point = arena_array(arena, r->points * 4, sizeof *point);
    uint32_t *first = arena_array(arena, r->segments, sizeof *first);
    c.flags = neighbour_flags(arena, r);
    if (!point || !first || !c.flags) return mesh_no_memory(r->source);
    memcpy(point, r->point, r->points * 4 * sizeof *point);
    memcpy(first, r->first, r->segments * sizeof *first);
    c.points = (uint32_t)r->points;
    c.point = point;
    c.first = first;
    *out = c;
    return SATIN_OK;
}

satin_status scene_curves_read(const struct scene_source *source, const struct mat4 *to_world,
                               bool linear, struct curves *out) {
    char *data;
    size_t size;
    satin_status status = scene_source_read(source, SCENE_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct reader r = {.source = source,
                       .text = {data, data + size, 1},
                       .to_world = to_world,
                       .needed = linear ? 2 : 4};
    status = read_lines(&r);
    if (status == SATIN_OK) status = keep(&r, linear, out);
    free(r.point);
    free(r.first);
    free(data);
    return status;
}

void scene_curves_bound(const struct curves *curves, vec3 *lo, vec3 *hi) {
    *lo = v3(INFINITY, INFINITY, INFINITY);
    *hi = v3_neg(*lo);
    for (size_t i = 0; i < curves->points; i++) {
        const float *p = curves->point + 4 * i;
        vec3 r = v3(p[3], p[3], p[3]), c = v3(p[0], p[1], p[2]);
        *lo = v3_min(*lo, v3_sub(c, r));
        *hi = v3_max(*hi, v3_add(c, r));
    }
}

// ---- The surface --------------------------------------------------------------------------------

// Weights of a segment's points at u, and their derivatives by u; the number of points.
static int basis(bool linear, float u, float w[4], float d[4]) {
    float v = 1.0f - u;
    if (linear) {
        w[0] = v, w[1] = u;
        d[0] = -1.0f, d[1] = 1.0f;
        return 2;
    }
    w[0] = v * v * v / 6.0f;
    w[1] = (3.0f * u * u * u - 6.0f * u * u + 4.0f) / 6.0f;
    w[2] = (3.0f * v * v * v - 6.0f * v * v + 4.0f) / 6.0f;
    w[3] = u * u * u / 6.0f;
    d[0] = -0.5f * v * v;
    d[1] = 0.5f * (3.0f * u * u - 4.0f * u);
    d[2] = -0.5f * (3.0f * v * v - 4.0f * v);
    d[3] = 0.5f * u * u;
    return 4;
}

void curve_surfel(const struct curves *curves, const struct curve_hit *hit, bool tangent,
                  struct surfel *out) {
    const float *point = curves->point + (size_t)curves->first[hit->segment] * 4;
    float w[4], d[4], radius = 0.0f;
    int count = basis(curves->linear, hit->u, w, d);
    vec3 along = v3(0, 0, 0);
    for (int i = 0; i < count; i++) {
        const float *p = point + 4 * i;
        along = v3_mad(along, d[i], v3(p[0], p[1], p[2]));
        radius += w[i] * p[3];
    }
    vec3 n = v3_unit(hit->n), axis = v3_unit(along);
    struct frame around = frame_from_normal(axis);
    float turn = atan2f(v3_dot(n, around.v), v3_dot(n, around.u)) * (0.5f / PI_F);
    out->p = v3_mad(hit->p, OUTSIDE * radius, n);
    out->ng = hit->flip ? v3_neg(n) : n;
    out->uv = (vec2){turn < 0.0f ? turn + 1.0f : turn,
                     ((float)hit->segment + hit->u) / (float)curves->segments};
    out->dp_dv = along;
    out->dp_du = v3_mul(v3_cross(along, n), 2.0f * PI_F * radius / fmaxf(v3_len(along), 1e-20f));
    out->frame = tangent ? frame_from_tangent(out->ng, out->dp_du) : frame_from_normal(out->ng);
}
