// SPDX-License-Identifier: Apache-2.0
// Reads curves from Mitsuba's text files.
#include "load/load_curve.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "load/load_mesh.h"
#include "load/load_mesh_text.h"

bool load_curve_in_range(vec3 p, double radius) {
    return radius >= 0.0 && radius < 1e15 && v3_max_abs(p) < 1e15f;
}

satin_status load_curve_point(struct curve_list *list, vec3 p, float radius) {
    if (!array_reserve((void **)&list->point, &list->point_capacity, list->points * 4 + 4,
                       sizeof(float)))
        return load_mesh_no_memory(list->source);
    const float out[4] = {p.x, p.y, p.z, radius};
    memcpy(list->point + list->points++ * 4, out, sizeof out);
    return SATIN_OK;
}

satin_status load_curve_end(struct curve_list *list, size_t needed) {
    const size_t count = list->points - list->start;
    if (!array_reserve((void **)&list->first, &list->first_capacity, list->segments + count,
                       sizeof *list->first))
        return load_mesh_no_memory(list->source);
    for (size_t i = 0; i + needed <= count; i++)
        list->first[list->segments++] = (uint32_t)(list->start + i);
    list->start = list->points;
    return SATIN_OK;
}

// Sets a bit for each neighbour that a segment has in its curve, as Embree needs.
static uint8_t *neighbour_flags(struct arena *arena, const struct curve_list *list) {
    uint8_t *flags = arena_array(arena, list->segments, 1);
    for (size_t i = 0; flags && i < list->segments; i++) {
        bool left = i > 0 && list->first[i - 1] + 1 == list->first[i];
        bool right = i + 1 < list->segments && list->first[i] + 1 == list->first[i + 1];
        flags[i] = (uint8_t)(left | right << 1);
    }
    return flags;
}

satin_status load_curve_store(const struct curve_list *list, bool linear, struct curves *out) {
    struct arena *arena = list->source->arena;
    struct curves c = {.segments = (uint32_t)list->segments, .linear = linear};
    float *point = arena_array(arena, list->points * 4, sizeof *point);
    uint32_t *first = arena_array(arena, list->segments, sizeof *first);
    c.flags = neighbour_flags(arena, list);
    if (!point || !first || !c.flags) return load_mesh_no_memory(list->source);
    memcpy(point, list->point, list->points * 4 * sizeof *point);
    memcpy(first, list->first, list->segments * sizeof *first);
    c.points = (uint32_t)list->points;
    c.point = point;
    c.first = first;
    *out = c;
    return SATIN_OK;
}

void load_curve_free(struct curve_list *list) {
    free(list->point);
    free(list->first);
}

// ---- Curves with a radius per point -------------------------------------------------------------

struct curve_reader {
    struct curve_list list;
    struct mesh_text text;
    const struct mat4 *to_world;
    size_t needed;  // number of points of a segment
};

static satin_status read_point(struct curve_reader *r) {
    double value[4];
    for (int i = 0; i < 4; i++) {
        load_mesh_text_skip_blanks(&r->text);
        if (!load_mesh_text_number(&r->text, &value[i]) || !isfinite((float)value[i]))
            return load_mesh_error(r->list.source, r->text.line, "expected a point: x y z radius");
    }
    vec3 p = mat4_point(r->to_world, v3((float)value[0], (float)value[1], (float)value[2]));
    if (!load_curve_in_range(p, value[3]))
        return load_mesh_error(r->list.source, r->text.line,
                               "the point or its radius is out of range");
    return load_curve_point(&r->list, p, (float)value[3]);
}

static satin_status end_curve(struct curve_reader *r) {
    const size_t count = r->list.points - r->list.start;
    if (!count) return SATIN_OK;
    if (count < r->needed)
        return load_mesh_error(r->list.source, r->text.line,
                               "a curve of %zu points, but it needs %zu", count, r->needed);
    return load_curve_end(&r->list, r->needed);
}

static satin_status read_curve_lines(struct curve_reader *r) {
    satin_status status = SATIN_OK;
    for (; r->text.at < r->text.end && status == SATIN_OK; load_mesh_text_next_line(&r->text)) {
        load_mesh_text_skip_blanks(&r->text);
        bool blank = r->text.at == r->text.end || *r->text.at == '\n';
        status = blank ? end_curve(r) : read_point(r);
        load_mesh_text_skip_blanks(&r->text);
        if (status == SATIN_OK && r->text.at < r->text.end && *r->text.at != '\n')
            status =
                load_mesh_error(r->list.source, r->text.line, "expected a point: x y z radius");
    }
    if (status == SATIN_OK) status = end_curve(r);
    if (status == SATIN_OK && !r->list.segments)
        status = load_mesh_error(r->list.source, 0, "there is no curve in it");
    return status;
}

satin_status load_curves(const struct load_source *source, const struct mat4 *to_world, bool linear,
                         struct curves *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct curve_reader r = {.list = {.source = source},
                             .text = {data, data + size, 1},
                             .to_world = to_world,
                             .needed = linear ? 2 : 4};
    status = read_curve_lines(&r);
    if (status == SATIN_OK) status = load_curve_store(&r.list, linear, out);
    load_curve_free(&r.list);
    free(data);
    return status;
}
