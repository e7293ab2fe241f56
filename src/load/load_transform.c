// SPDX-License-Identifier: Apache-2.0
// <transform>: its steps are applied to the object in the order in which they are written, so each
// one multiplies from the left. The product is in double precision until the end.
#include "base/frame.h"
#include "load/load_params.h"

struct matrix {
    double m[4][4];
};

static struct matrix matrix_of(const struct mat4 *a) {
    struct matrix out;
    for (int i = 0; i < 16; i++) out.m[i / 4][i % 4] = (double)a->m[i / 4][i % 4];
    return out;
}

static struct matrix matrix_product(const struct matrix *a, const struct matrix *b) {
    struct matrix out = {0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            for (int k = 0; k < 4; k++) out.m[i][j] += a->m[i][k] * b->m[k][j];
    return out;
}

static satin_status transform_error(struct log log, const struct xml_node *step, const char *why) {
    log_error_at(log, step->place, "<%s>: %s", load_xml_tag_name(step->tag), why);
    return SATIN_ERROR_INPUT;
}

static satin_status read_translate(struct log log, const struct xml_node *step,
                                   struct matrix *out) {
    vec3 t;
    if (!load_param_xyz(log, step, 0.0f, &t)) return SATIN_ERROR_INPUT;
    struct mat4 m = mat4_translate(t);
    *out = matrix_of(&m);
    return SATIN_OK;
}

static satin_status read_scale(struct log log, const struct xml_node *step, struct matrix *out) {
    vec3 s;
    if (!load_param_xyz(log, step, 1.0f, &s)) return SATIN_ERROR_INPUT;
    struct mat4 m = mat4_scale(s);
    *out = matrix_of(&m);
    return SATIN_OK;
}

static satin_status read_rotate(struct log log, const struct xml_node *step, struct matrix *out) {
    vec3 axis;
    double angle;
    if (!load_param_xyz(log, step, 0.0f, &axis)) return SATIN_ERROR_INPUT;
    if (!load_param_numbers(log, step->place, load_xml_get(step, "angle"), 1, &angle))
        return SATIN_ERROR_INPUT;
    if (v3_max_abs(axis) == 0.0f) return transform_error(log, step, "the axis is zero");
    struct mat4 m = mat4_rotate(axis, (float)angle);
    *out = matrix_of(&m);
    return SATIN_OK;
}

static bool read_triple(struct log log, const struct xml_node *step, const char *attribute,
                        vec3 *out) {
    const char *text = load_xml_get(step, attribute);
    double d[3] = {0.0, 0.0, 0.0};
    if (text && !load_param_numbers(log, step->place, text, 3, d)) return false;
    *out = v3((float)d[0], (float)d[1], (float)d[2]);
    return true;
}

static satin_status read_lookat(struct log log, const struct xml_node *step, struct matrix *out) {
    vec3 origin, target, up;
    if (!read_triple(log, step, "origin", &origin) || !read_triple(log, step, "target", &target) ||
        !read_triple(log, step, "up", &up))
        return SATIN_ERROR_INPUT;
    // If the up vector is missing or parallel to the direction, any one is valid; this is the one
    // that Mitsuba takes if it is missing.
    vec3 d = v3_unit(v3_sub(target, origin));
    struct mat4 m;
    if (v3_max_abs(up) == 0.0f || !mat4_look_at(origin, target, up, &m)) {
        if (!mat4_look_at(origin, target, frame_from_normal(d).u, &m))
            return transform_error(log, step, "origin and target coincide");
        if (load_xml_get(step, "up"))
            log_warning_at(log, step->place,
                           "<lookat>: up is %s; one at right angles to the view is taken",
                           v3_max_abs(up) == 0.0f ? "zero" : "along the view");
    }
    *out = matrix_of(&m);
    return SATIN_OK;
}

// Reads 16 numbers by rows, or 9 for the upper left 3x3 block.
static satin_status read_matrix(struct log log, const struct xml_node *step, struct matrix *out) {
    const char *text = load_xml_get(step, "value");
    double d[16];
    const int words = load_param_words(text), size = words == 9 ? 3 : 4;
    if (words != 9 && words != 16) {
        log_error_at(log, step->place,
                     "<matrix>: expected 16 numbers by rows, or 9 of the upper 3 x 3, found %d",
                     words);
        return SATIN_ERROR_INPUT;
    }
    if (!load_param_numbers(log, step->place, text, size * size, d)) return SATIN_ERROR_INPUT;
    struct mat4 identity = mat4_identity();
    *out = matrix_of(&identity);
    if (size == 4 && (d[12] != 0.0 || d[13] != 0.0 || d[14] != 0.0 || !(d[15] != 0.0)))
        return transform_error(log, step, "its last row is not 0 0 0 1");
    for (int i = 0; i < size * size; i++)
        out->m[i / size][i % size] = size == 4 ? d[i] / d[15] : d[i];
    return SATIN_OK;
}

static satin_status read_step(struct log log, const struct xml_node *step, struct matrix *out) {
    switch (step->tag) {
        case XML_TRANSLATE:
            return read_translate(log, step, out);
        case XML_SCALE:
            return read_scale(log, step, out);
        case XML_ROTATE:
            return read_rotate(log, step, out);
        case XML_LOOKAT:
            return read_lookat(log, step, out);
        default:
            return read_matrix(log, step, out);
    }
}

satin_status load_transform(struct log log, const struct xml_node *node, struct mat4 *out) {
    struct mat4 result = mat4_identity();
    struct matrix total = matrix_of(&result);
    for (const struct xml_node *step = node->child; step; step = step->next) {
        struct matrix m;
        satin_status status = read_step(log, step, &m);
        if (status != SATIN_OK) return status;
        total = matrix_product(&m, &total);
    }
    for (int i = 0; i < 16; i++) {
        result.m[i / 4][i % 4] = (float)total.m[i / 4][i % 4];
        if (!isfinite(result.m[i / 4][i % 4]))
            return transform_error(log, node, "the product overflows");
    }
    *out = result;
    return SATIN_OK;
}

static vec3 column(const struct mat4 *m, int j) { return v3(m->m[0][j], m->m[1][j], m->m[2][j]); }

// In double precision, as squares of large and small lengths are not floats.
static double dot_columns(const struct mat4 *m, int i, int j) {
    double sum = 0.0;
    for (int k = 0; k < 3; k++) sum += (double)m->m[k][i] * (double)m->m[k][j];
    return sum;
}

bool load_transform_similar(const struct mat4 *m) {
    const double l2 = dot_columns(m, 0, 0), tolerance = 1e-3 * l2;
    return fabs(dot_columns(m, 1, 1) - l2) <= tolerance &&
           fabs(dot_columns(m, 2, 2) - l2) <= tolerance &&
           fabs(dot_columns(m, 0, 1)) <= tolerance && fabs(dot_columns(m, 1, 2)) <= tolerance &&
           fabs(dot_columns(m, 2, 0)) <= tolerance;
}

struct mat4 load_transform_unstretched(const struct mat4 *m) {
    const vec3 y = v3_unit(column(m, 1)), a = column(m, 0),
               x = v3_unit(v3_sub(a, v3_mul(y, v3_dot(a, y)))), z = v3_cross(x, y),
               c = mat4_det3(m) < 0.0 ? v3_neg(z) : z;
    return (struct mat4){{{x.x, y.x, c.x, m->m[0][3]},
                          {x.y, y.y, c.y, m->m[1][3]},
                          {x.z, y.z, c.z, m->m[2][3]},
                          {0.0f, 0.0f, 0.0f, 1.0f}}};
}
