// SPDX-License-Identifier: Apache-2.0
// satin's text form of a measured BRDF (docs/formats.md): words separated by blanks or line ends,
// comments from # to the end of the line.
//   brdf 1
//   theta_o N a1 ... aN   phi_o ...   theta_i ...   phi ...     [degrees], ascending
//   channels 1|3
//   values ...            theta_o slowest, then phi_o, theta_i, phi, and the channel fastest
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/load_measured.h"
#include "load/load_mesh_text.h"

enum { NODES_MAX = 3600, TEXT_VALUES_MAX = 1 << 28 };

struct measured_reader {
    const struct load_source *source;
    struct mesh_text text;
};

static satin_status measured_error(const struct measured_reader *r, const char *why) {
    log_error_at(r->source->log, (struct log_place){r->source->path, r->text.line, 1}, "%s", why);
    return SATIN_ERROR_INPUT;
}

static void skip(struct measured_reader *r) {
    for (;;) {
        load_mesh_text_skip_space(&r->text);
        if (r->text.at == r->text.end || *r->text.at != '#') return;
        load_mesh_text_next_line(&r->text);
    }
}

static bool take(struct measured_reader *r, const char *name) {
    const char *word;
    skip(r);
    size_t length = load_mesh_text_word(&r->text, &word);
    return load_mesh_text_is(word, length, name);
}

static bool read_measured_number(struct measured_reader *r, double *out) {
    skip(r);
    return load_mesh_text_number(&r->text, out);
}

static bool count(struct measured_reader *r, int most, int *out) {
    double n;
    if (!read_measured_number(r, &n) || !(n >= 1.0 && n <= most) || n != (double)(int)n)
        return false;
    *out = (int)n;
    return true;
}

// Reads one list of angles, in [0, most] degrees.
static satin_status read_angles(struct measured_reader *r, const char *name, double most, int *size,
                                const float **out) {
    char text[64];
    snprintf(text, sizeof text, "expected '%s', how many, and angles from 0 to %g", name, most);
    if (!take(r, name) || !count(r, NODES_MAX, size)) return measured_error(r, text);
    float *angle = arena_array(r->source->arena, (size_t)*size, sizeof *angle);
    if (!angle) return log_fail(r->source->log, SATIN_ERROR_MEMORY, "not enough memory");
    for (int i = 0; i < *size; i++) {
        double a;
        if (!read_measured_number(r, &a) || !(a >= 0.0 && a <= most))
            return measured_error(r, text);
        angle[i] = (float)(a * (M_PI / 180.0));
        if (i && !(angle[i] > angle[i - 1])) return measured_error(r, "angles must ascend");
    }
    *out = angle;
    return SATIN_OK;
}

static satin_status read_values(struct measured_reader *r, struct brdf_grid *g) {
    uint64_t n = (uint64_t)g->channels;
    for (int i = 0; i < 4; i++) n *= (uint64_t)g->size[i];  // below 2^50
    if (n > TEXT_VALUES_MAX) return measured_error(r, "there are too many values");
    // A value takes at least two bytes, so a short file cannot allocate much.
    if (n > (uint64_t)(r->text.end - r->text.at))
        return measured_error(r, "there are too few values");
    float *value = arena_array(r->source->arena, (size_t)n, sizeof *value);
    if (!value) return log_fail(r->source->log, SATIN_ERROR_MEMORY, "not enough memory");
    for (uint64_t i = 0; i < n; i++) {
        double v;
        if (!read_measured_number(r, &v)) return measured_error(r, "expected a value");
        if (!(v >= 0.0 && v <= 1e9)) return measured_error(r, "values must be from 0 to 1e9");
        value[i] = (float)v;
    }
    skip(r);
    if (r->text.at != r->text.end)
        return measured_error(r, "there are more values than angles ask for");
    g->value = value;
    return SATIN_OK;
}

static satin_status read_grid(struct measured_reader *r, struct brdf_grid *g) {
    static const char *const name[4] = {"theta_o", "phi_o", "theta_i", "phi"};
    int version;
    if (!take(r, "brdf") || !count(r, 1, &version)) return measured_error(r, "expected 'brdf 1'");
    *g = (struct brdf_grid){.kind = BRDF_GRID_DIRECTIONS};
    for (int i = 0; i < 4; i++) {
        satin_status status = read_angles(r, name[i], i % 2 ? 360.0 : 90.0, &g->size[i], &g->at[i]);
        if (status != SATIN_OK) return status;
    }
    if (!take(r, "channels") || !count(r, 3, &g->channels) || g->channels == 2)
        return measured_error(r, "expected 'channels 1' or 'channels 3'");
    if (!take(r, "values")) return measured_error(r, "expected 'values'");
    return read_values(r, g);
}

satin_status load_measured_text(const struct load_source *source, struct brdf_grid *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct measured_reader r = {source, {data, data + size, 1}};
    status = read_grid(&r, out);
    free(data);
    return status;
}
