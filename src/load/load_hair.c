// SPDX-License-Identifier: Apache-2.0
// Reads the files of Mitsuba 0.6's `hair`, as text or in the binary form:
//
//   bytes  content
//   11     BINARY_HAIR
//   4      number of vertices, an unsigned integer
//   12     x, y and z of a vertex, as floats; before the first vertex of a strand there may be one
//          float of infinity more
//
// All numbers are little-endian. Mitsuba joins the segments of a strand by mitres and ends it flat;
// here joints and ends are round. Which strands a reduction leaves out is drawn by their numbers in
// the file, with other random numbers than in Mitsuba.
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "load/load_curve.h"
#include "load/load_mesh.h"
#include "load/load_mesh_text.h"

static const char binary_header[] = "BINARY_HAIR";
enum { HEADER_BYTES = sizeof binary_header - 1, DATA_AT = HEADER_BYTES + 4, VERTEX_BYTES = 12 };

struct hair_reader {
    struct curve_list list;
    const struct hair_request *request;
    double cosine;      // of the threshold
    size_t strands;     // number of strands that have begun
    bool begins;        // whether the next point is the first one of a strand
    bool left_out;      // whether the strand is left out
    size_t longer;      // number of lines with more than three numbers
    double tangent[3];  // the direction of the last segment, if there is one
};

// ---- Strands ------------------------------------------------------------------------------------

// The unit vector from one point to another one, in double precision, in which no length of a
// vector of floats is too small or too large.
static void strand_direction(const float from[3], vec3 to, double out[3]) {
    const double d[3] = {(double)to.x - from[0], (double)to.y - from[1], (double)to.z - from[2]};
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int i = 0; i < 3; i++) out[i] = d[i] / length;
}

static satin_status end_strand(struct hair_reader *r) {
    struct curve_list *list = &r->list;
    r->begins = true;
    if (list->points - list->start > 1) return load_curve_end(list, 2);
    list->points = list->start;
    return SATIN_OK;
}

static satin_status begin_strand(struct hair_reader *r, vec3 p) {
    struct rng rng = rng_make(0, RNG_HAIR, r->strands++);
    r->begins = false;
    r->left_out = rng_float(&rng) < r->request->reduction;
    return r->left_out ? SATIN_OK : load_curve_point(&r->list, p, r->request->radius);
}

// Adds a point of world space to the strand. It replaces the last one if the segment to it goes on
// in the direction of the one before, from whose start the new direction is then.
static satin_status continue_strand(struct hair_reader *r, vec3 p) {
    struct curve_list *list = &r->list;
    if (r->left_out) return SATIN_OK;
    float *const end = list->point + 4 * (list->points - 1);
    if (p.x == end[0] && p.y == end[1] && p.z == end[2]) return SATIN_OK;
    const bool second = list->points - list->start == 1;
    double next[3];
    strand_direction(end, p, next);
    if (!second &&
        next[0] * r->tangent[0] + next[1] * r->tangent[1] + next[2] * r->tangent[2] > r->cosine) {
        strand_direction(end - 4, p, r->tangent);
        memcpy(end, (const float[3]){p.x, p.y, p.z}, 3 * sizeof *end);
        return SATIN_OK;
    }
    memcpy(r->tangent, next, sizeof next);
    return load_curve_point(list, p, r->request->radius);
}

// Adds the point of the file. False, without a message, if it is out of range.
static bool add_vertex(struct hair_reader *r, const float v[3], satin_status *status) {
    const vec3 p = mat4_point(&r->request->to_world, v3(v[0], v[1], v[2]));
    if (!v3_finite(p) || !load_curve_in_range(p, r->request->radius)) return false;
    *status = r->begins ? begin_strand(r, p) : continue_strand(r, p);
    return true;
}

// ---- Files --------------------------------------------------------------------------------------

static satin_status read_strand_line(struct hair_reader *r, struct mesh_text *text) {
    satin_status status = SATIN_OK;
    float v[3];
    for (int i = 0; i < 3; i++) {
        double value;
        load_mesh_text_skip_blanks(text);
        if (!load_mesh_text_number(text, &value))
            return load_mesh_error(r->list.source, text->line, "expected a point: x y z");
        v[i] = (float)value;
    }
    load_mesh_text_skip_blanks(text);
    if (text->at < text->end && *text->at != '\n') r->longer++;
    if (!add_vertex(r, v, &status))
        return load_mesh_error(r->list.source, text->line, "the point is out of range");
    return status;
}

static satin_status read_strand_lines(struct hair_reader *r, const char *data, size_t size) {
    struct mesh_text text = {data, data + size, 1};
    satin_status status = SATIN_OK;
    for (; text.at < text.end && status == SATIN_OK; load_mesh_text_next_line(&text)) {
        load_mesh_text_skip_blanks(&text);
        const bool separates = text.at == text.end || *text.at == '\n' || *text.at == '#';
        status = separates ? end_strand(r) : read_strand_line(r, &text);
    }
    return status;
}

static uint32_t little_u32(const char *at) {
    const unsigned char *b = (const unsigned char *)at;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static float little_float(const char *at) {
    const uint32_t bits = little_u32(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static satin_status read_strand_bytes(struct hair_reader *r, const char *data, size_t size) {
    const struct load_source *source = r->list.source;
    if (size < DATA_AT)
        return load_mesh_error(source, 0, "byte %zu: the file ends before the number of vertices",
                               size);
    const uint32_t count = little_u32(data + HEADER_BYTES);
    size_t at = DATA_AT;
    satin_status status = SATIN_OK;
    for (uint32_t i = 0; i < count && status == SATIN_OK; i++, at += VERTEX_BYTES) {
        const bool separated = size - at >= sizeof(float) && isinf(little_float(data + at));
        if (separated) {
            status = end_strand(r);
            at += sizeof(float);
        }
        if (size - at < VERTEX_BYTES)
            return load_mesh_error(source, 0, "byte %zu: the file ends after %u of %u vertices",
                                   size, i, count);
        float v[3];
        for (int k = 0; k < 3; k++) v[k] = little_float(data + at + 4 * k);
        if (status == SATIN_OK && !add_vertex(r, v, &status))
            return load_mesh_error(source, 0, "byte %zu: the vertex is not finite or out of range",
                                   at);
    }
    // A separator may end the last strand.
    if (status == SATIN_OK && size - at > sizeof(float))
        log_message(source->log, SATIN_LOG_WARNING,
                    "%s: %zu bytes after the last of %u vertices are not read", source->path,
                    size - at, count);
    return status;
}

static satin_status check_strands(const struct hair_reader *r) {
    if (r->list.segments) return SATIN_OK;
    if (r->request->reduction > 0.0f && r->strands)
        return load_mesh_error(r->list.source, 0,
                               "no strand with a segment is left of %zu after the reduction",
                               r->strands);
    return load_mesh_error(r->list.source, 0, "there is no strand of two points in it");
}

satin_status load_hair(const struct load_source *source, const struct hair_request *request,
                       struct curves *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct hair_reader r = {.list = {.source = source},
                            .request = request,
                            .cosine = cos((double)request->angle_threshold * (M_PI / 180.0)),
                            .begins = true};
    const bool binary = size >= HEADER_BYTES && memcmp(data, binary_header, HEADER_BYTES) == 0;
    status = binary ? read_strand_bytes(&r, data, size) : read_strand_lines(&r, data, size);
    free(data);
    if (status == SATIN_OK) status = end_strand(&r);
    if (status == SATIN_OK) status = check_strands(&r);
    if (status == SATIN_OK && r.longer)
        log_message(source->log, SATIN_LOG_WARNING,
                    "%s: of %zu lines only the first three numbers are read", source->path,
                    r.longer);
    if (status == SATIN_OK) status = load_curve_store(&r.list, true, out);
    load_curve_free(&r.list);
    return status;
}
