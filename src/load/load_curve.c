// SPDX-License-Identifier: Apache-2.0
// Reads curves from Mitsuba's text files.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "load/load_mesh.h"
#include "load/load_mesh_text.h"

struct curve_reader {
    const struct load_source *source;
    struct mesh_text text;
    const struct mat4 *to_world;
    float *point;
    uint32_t *first;
    size_t points, point_capacity, segments, first_capacity;
    size_t start;   // first point of the curve that is being read
    size_t needed;  // number of points of a segment
};

static satin_status read_point(struct curve_reader *r) {
    double value[4];
    for (int i = 0; i < 4; i++) {
        load_mesh_text_skip_blanks(&r->text);
        if (!load_mesh_text_number(&r->text, &value[i]) || !isfinite((float)value[i]))
            return load_mesh_error(r->source, r->text.line, "expected a point: x y z radius");
    }
    vec3 p = mat4_point(r->to_world, v3((float)value[0], (float)value[1], (float)value[2]));
    if (!(value[3] >= 0.0 && value[3] < 1e15) || !(v3_max_abs(p) < 1e15f))
        return load_mesh_error(r->source, r->text.line, "the point or its radius is out of range");
    if (!array_reserve((void **)&r->point, &r->point_capacity, r->points * 4 + 4, sizeof(float)))
        return load_mesh_no_memory(r->source);
    const float out[4] = {p.x, p.y, p.z, (float)value[3]};
    memcpy(r->point + r->points++ * 4, out, sizeof out);
    return SATIN_OK;
}

// Ends a curve: a segment starts at every point that has enough points after it.
static satin_status end_curve(struct curve_reader *r) {
    size_t count = r->points - r->start;
    if (!count) return SATIN_OK;
    if (count < r->needed)
        return load_mesh_error(r->source, r->text.line, "a curve of %zu points, but it needs %zu",
                               count, r->needed);
    if (!array_reserve((void **)&r->first, &r->first_capacity, r->segments + count,
                       sizeof *r->first))
        return load_mesh_no_memory(r->source);
    for (size_t i = 0; i + r->needed <= count; i++)
        r->first[r->segments++] = (uint32_t)(r->start + i);
    r->start = r->points;
    return SATIN_OK;
}

static satin_status read_curve_lines(struct curve_reader *r) {
    satin_status status = SATIN_OK;
    for (; r->text.at < r->text.end && status == SATIN_OK; load_mesh_text_next_line(&r->text)) {
        load_mesh_text_skip_blanks(&r->text);
        bool blank = r->text.at == r->text.end || *r->text.at == '\n';
        status = blank ? end_curve(r) : read_point(r);
        load_mesh_text_skip_blanks(&r->text);
        if (status == SATIN_OK && r->text.at < r->text.end && *r->text.at != '\n')
            status = load_mesh_error(r->source, r->text.line, "expected a point: x y z radius");
    }
    if (status == SATIN_OK) status = end_curve(r);
    if (status == SATIN_OK && !r->segments)
        status = load_mesh_error(r->source, 0, "there is no curve in it");
    return status;
}

// Sets a bit for each neighbour that a segment has in its curve, as Embree needs.
static uint8_t *neighbour_flags(struct arena *arena, const struct curve_reader *r) {
    uint8_t *flags = arena_array(arena, r->segments, 1);
    for (size_t i = 0; flags && i < r->segments; i++) {
        bool left = i > 0 && r->first[i - 1] + 1 == r->first[i];
        bool right = i + 1 < r->segments && r->first[i] + 1 == r->first[i + 1];
        flags[i] = (uint8_t)(left | right << 1);
    }
    return flags;
}

static satin_status store_curves(const struct curve_reader *r, bool linear, struct curves *out) {
    struct arena *arena = r->source->arena;
    struct curves c = {.segments = (uint32_t)r->segments, .linear = linear};
    float *point = arena_array(arena, r->points * 4, sizeof *point);
    uint32_t *first = arena_array(arena, r->segments, sizeof *first);
    c.flags = neighbour_flags(arena, r);
    if (!point || !first || !c.flags) return load_mesh_no_memory(r->source);
    memcpy(point, r->point, r->points * 4 * sizeof *point);
    memcpy(first, r->first, r->segments * sizeof *first);
    c.points = (uint32_t)r->points;
    c.point = point;
    c.first = first;
    *out = c;
    return SATIN_OK;
}

satin_status load_curves(const struct load_source *source, const struct mat4 *to_world, bool linear,
                         struct curves *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct curve_reader r = {.source = source,
                             .text = {data, data + size, 1},
                             .to_world = to_world,
                             .needed = linear ? 2 : 4};
    status = read_curve_lines(&r);
    if (status == SATIN_OK) status = store_curves(&r, linear, out);
    free(r.point);
    free(r.first);
    free(data);
    return status;
}
