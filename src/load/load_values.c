// SPDX-License-Identifier: Apache-2.0
// Reads values of parameters from text: numbers, lists, names and colours, with their ranges.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "load/load_params.h"

static const char blanks[] = " \t\r\n,";

int load_param_words(const char *text) {
    int count = 0;
    for (text += strspn(text, blanks); *text; text += strspn(text, blanks)) {
        text += strcspn(text, blanks);
        count++;
    }
    return count;
}

bool load_param_number(struct log log, struct log_place place, const char **text, double *out) {
    char word[64];
    *text += strspn(*text, blanks);
    size_t n = strcspn(*text, blanks);
    if (n < sizeof word) {
        memcpy(word, *text, n);
        word[n] = 0;
    }
    // A number that is larger than any float counts as infinite.
    if (n >= sizeof word || !text_double(word, out) || fabs(*out) > 3e38) {
        log_error_at(log, place, "'%.*s' is not a number", n < 60 ? (int)n : 60, *text);
        return false;
    }
    *text += n;
    return true;
}

bool load_param_numbers(struct log log, struct log_place place, const char *text, int count,
                        double *out) {
    int words = load_param_words(text);
    if (words != count) {
        log_error_at(log, place, "expected %d number%s, found '%.60s'", count,
                     count == 1 ? "" : "s", text);
        return false;
    }
    for (int i = 0; i < count; i++)
        if (!load_param_number(log, place, &text, &out[i])) return false;
    return true;
}

bool load_param_xyz(struct log log, const struct xml_node *node, float missing, vec3 *out) {
    const char *value = load_xml_get(node, "value");
    const char *component[3] = {load_xml_get(node, "x"), load_xml_get(node, "y"),
                                load_xml_get(node, "z")};
    double d[3] = {missing, missing, missing};
    if (value) {
        if (component[0] || component[1] || component[2]) {
            log_error_at(log, node->place, "<%s> has both a value and x, y or z",
                         load_xml_tag_name(node->tag));
            return false;
        }
        int count = load_param_words(value) == 1 ? 1 : 3;
        if (!load_param_numbers(log, node->place, value, count, d)) return false;
        if (count == 1) d[1] = d[2] = d[0];
    }
    for (int i = 0; i < 3 && !value; i++) {
        if (component[i] && !load_param_numbers(log, node->place, component[i], 1, &d[i]))
            return false;
        if (!isnan(d[i])) continue;
        log_error_at(log, node->place, "<%s> needs the attribute '%c'",
                     load_xml_tag_name(node->tag), "xyz"[i]);
        return false;
    }
    *out = v3((float)d[0], (float)d[1], (float)d[2]);
    return true;
}

static bool value_in_range(enum param_range range, float x) {
    switch (range) {
        case RANGE_POSITIVE:
            return x > 0.0f;
        case RANGE_NOT_NEGATIVE:
            return x >= 0.0f;
        case RANGE_MODEST:
            return x >= 0.0f && x <= 1e6f;
        case RANGE_UNIT:
        case RANGE_CLAMPED:
            return x >= 0.0f && x <= 1.0f;
        default:
            return true;
    }
}

static satin_status check_in(struct log log, const struct param_spec *spec, enum param_range range,
                             struct log_place place, float x) {
    static const char *const text[] = {"", "positive", "0 or more", "0 to 1e6", "in [0, 1]"};
    if (value_in_range(range, x)) return SATIN_OK;
    if (range == RANGE_CLAMPED) {
        log_warning_at(log, place, "%s is %g, which counts as %d", spec->name, x, x > 0.5f);
        return SATIN_OK;
    }
    char shown[32];
    snprintf(shown, sizeof shown, "%g", (double)x);
    if (value_in_range(range, strtof(shown, NULL)))
        snprintf(shown, sizeof shown, "%.9g", (double)x);  // as 1.00000012
    log_error_at(log, place, "%s is %s, but must be %s", spec->name, shown, text[range]);
    return SATIN_ERROR_INPUT;
}

static satin_status check_range(struct log log, const struct param_spec *spec,
                                struct log_place place, float x) {
    return check_in(log, spec, spec->range, place, x);
}

satin_status load_value_unknown(struct log log, const char *name, struct log_place place,
                                const struct text_nearest *nearest, const char *list) {
    if (nearest->best)
        log_error_at(log, place, "%s: unknown value '%s' (did you mean '%s'?)", name, nearest->word,
                     nearest->best);
    else
        log_error_at(log, place, "%s: unknown value '%s'; known are %s", name, nearest->word, list);
    return SATIN_ERROR_INPUT;
}

enum { VALUE_LIST = 512 };  // bytes of a list of values in a message

static satin_status read_choice(struct log log, const struct param_spec *spec, const char *text,
                                struct param_value *value) {
    for (value->i = 0; spec->choices[value->i]; value->i++)
        if (text_same_name(spec->choices[value->i], text)) return SATIN_OK;
    struct text_nearest nearest = {.word = text};
    char list[VALUE_LIST] = "";
    size_t n = 0;
    for (int i = 0; spec->choices[i]; i++) {
        text_nearest_try(&nearest, spec->choices[i]);
        if (n < sizeof list)
            n += (size_t)snprintf(list + n, sizeof list - n, "%s%s", i ? ", " : "",
                                  spec->choices[i]);
    }
    return load_value_unknown(log, spec->name, value->place, &nearest, list);
}

static satin_status read_ior(struct log log, const struct param_spec *spec, const char *text,
                             struct param_value *value) {
    if (load_ior_find(text, &value->f)) return SATIN_OK;
    struct text_nearest nearest = {.word = text};
    char list[VALUE_LIST];
    for (int i = 0; load_ior_name(i); i++) text_nearest_try(&nearest, load_ior_name(i));
    return load_value_unknown(log, spec->name, value->place, &nearest,
                              load_names_list(load_ior_name, list, sizeof list));
}

static satin_status read_param_number(struct log log, const struct param_spec *spec,
                                      const char *text, struct param_value *value) {
    double d;
    if (!load_param_numbers(log, value->place, text, 1, &d)) return SATIN_ERROR_INPUT;
    value->f = (float)d;
    value->i = fabs(d) <= 2147483647.0 ? (int)d : 0;
    if (spec->kind != PARAM_INTEGER) return check_range(log, spec, value->place, value->f);
    if (strpbrk(text, ".eE") || d != (double)value->i) {
        log_error_at(log, value->place, "%s: '%s' is not an integer, or too large", spec->name,
                     text);
        return SATIN_ERROR_INPUT;
    }
    return check_range(log, spec, value->place, value->f);
}

static satin_status read_boolean(struct log log, const struct param_spec *spec, const char *text,
                                 struct param_value *value) {
    value->b = text_same_name(text, "true");
    if (value->b || text_same_name(text, "false")) return SATIN_OK;
    log_error_at(log, value->place, "%s: '%s' is neither true nor false", spec->name, text);
    return SATIN_ERROR_INPUT;
}

// Reads a number that may be textured from a colour: the mean.
static satin_status read_mean(struct param_source source, const struct param_spec *spec,
                              struct xml_node *node, struct param_value *value) {
    satin_status status = load_color(source, node, false, &value->color);
    if (status != SATIN_OK) return status;
    value->f = rgb_mean(value->color);
    return check_range(source.log, spec, value->place, value->f);
}

// Reads a value that is written as text; `tag` is that of its element.
static satin_status read_text(struct log log, const struct param_spec *spec, enum xml_tag tag,
                              const char *text, struct param_value *value) {
    switch (spec->kind) {
        case PARAM_BOOLEAN:
            return read_boolean(log, spec, text, value);
        case PARAM_STRING:
            value->s = text;
            return SATIN_OK;
        case PARAM_CHOICE:
            return read_choice(log, spec, text, value);
        case PARAM_IOR:
            if (tag == XML_STRING) return read_ior(log, spec, text, value);
            return read_param_number(log, spec, text, value);
        default:
            return read_param_number(log, spec, text, value);
    }
}

// Whether a colour is from samples of a spectrum, which may be outside the gamut of sRGB without
// being wrong.
static bool is_sampled(const struct xml_node *node) {
    if (node->tag != XML_SPECTRUM) return false;
    if (node->type) return strcmp(node->type, "uniform") != 0 && !strstr(node->type, "rgb");
    const char *value = load_xml_get(node, "value");
    return !value || strchr(value, ':');
}

static bool is_number(const struct xml_node *node) {
    return node->tag != XML_RGB && !is_sampled(node) && !(node->type && strstr(node->type, "rgb"));
}

// Scales a reflectance over 1 as Mitsuba 0.6 does.
static void scale_to_unit(struct log log, const struct param_spec *spec,
                          const struct xml_node *node, rgb *color) {
    const float most = rgb_max(*color), scale = ALBEDO_MOST / most;
    if (!(most > 1.0f)) return;
    *color = rgb_scale(*color, scale);
    log_warning_at(log, node->place, "%s is %g, and is scaled by %.3g as in Mitsuba 0.6",
                   spec->name, (double)most, (double)scale);
}

static satin_status read_color(struct param_source source, const struct param_spec *spec,
                               struct xml_node *node, struct param_value *value) {
    struct log log = source.log;
    satin_status status = load_color(source, node, spec->kind == PARAM_LIGHT, &value->color);
    if (status != SATIN_OK) return status;
    enum param_range range = spec->range;
    if (range == RANGE_TEXEL) range = is_number(node) ? RANGE_MODEST : RANGE_UNIT;
    if (range == RANGE_UNIT && is_sampled(node))
        value->color = rgb_make(fminf(value->color.r, 1.0f), fminf(value->color.g, 1.0f),
                                fminf(value->color.b, 1.0f));
    if (spec->range == RANGE_UNIT && node->mitsuba06) scale_to_unit(log, spec, node, &value->color);
    const float c[3] = {value->color.r, value->color.g, value->color.b};
    for (int i = 0; i < 3 && status == SATIN_OK; i++) {
        if (value_in_range(range, c[i])) continue;
        status = check_in(log, spec, range, node->place, c[i]);
        if (range == RANGE_CLAMPED) break;  // one warning is enough
    }
    return status;
}

satin_status load_param_read(struct param_source source, const struct param_spec *spec,
                             struct xml_node *node, struct param_value *value) {
    struct log log = source.log;
    switch (spec->kind) {
        case PARAM_TRANSFORM:
            return load_transform(log, node, &value->m);
        case PARAM_POINT:
            return load_param_xyz(log, node, NAN, &value->v) ? SATIN_OK : SATIN_ERROR_INPUT;
        case PARAM_COLOR:
        case PARAM_LIGHT:
            return read_color(source, spec, node, value);
        case PARAM_FLOAT:
            if (node->tag == XML_RGB || node->tag == XML_SPECTRUM)
                return read_mean(source, spec, node, value);
            return read_text(log, spec, node->tag, load_xml_get(node, "value"), value);
        default:
            return read_text(log, spec, node->tag, load_xml_get(node, "value"), value);
    }
}

satin_status load_param_read_default(struct log log, const struct param_spec *spec,
                                     struct param_value *value) {
    double d[3];
    switch (spec->kind) {
        case PARAM_TRANSFORM:
            value->m = mat4_identity();
            return SATIN_OK;
        case PARAM_POINT:
            if (!load_param_numbers(log, value->place, spec->default_text, 3, d))
                return SATIN_ERROR_INTERNAL;
            value->v = v3((float)d[0], (float)d[1], (float)d[2]);
            return SATIN_OK;
        case PARAM_COLOR:
        case PARAM_LIGHT:
            if (!load_param_numbers(log, value->place, spec->default_text, 1, d))
                return SATIN_ERROR_INTERNAL;
            value->color = rgb_grey((float)d[0]);
            return SATIN_OK;
        default:
            return read_text(log, spec, XML_STRING, spec->default_text, value);
    }
}
