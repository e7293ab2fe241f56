// SPDX-License-Identifier: Apache-2.0
// Colours: <rgb> with one number (grey), three (linear sRGB) or #rrggbb (encoded sRGB); <spectrum>
// with a constant, a list of samples, a file or a type; <float>; <vector>. Conversions are those of
// Mitsuba 3's RGB mode.
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "load/load_build.h"
#include "load/load_params.h"
#include "load/load_spectrum.h"

// The linear sRGB of light with equal energy at all wavelengths and luminance 1, by Mitsuba's
// integration.
static const rgb equal_energy = {1.204794f, 0.948291f, 0.908916f};

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static bool read_hex(const char *text, rgb *out) {
    if (strlen(text) != 7) return false;
    float c[3];
    for (int i = 0; i < 3; i++) {
        int high = hex_digit(text[1 + 2 * i]), low = hex_digit(text[2 + 2 * i]);
        if (high < 0 || low < 0) return false;
        c[i] = load_srgb_to_linear((float)(16 * high + low) / 255.0f);
    }
    *out = rgb_make(c[0], c[1], c[2]);
    return true;
}

static satin_status read_rgb(struct log log, const struct xml_node *node, rgb *out) {
    const char *text = load_xml_get(node, "value");
    double d[3];
    if (text[0] == '#') {
        if (read_hex(text, out)) return SATIN_OK;
        log_error_at(log, node->place, "'%s' is not a colour of the form #rrggbb", text);
        return SATIN_ERROR_INPUT;
    }
    int count = load_param_words(text) == 1 ? 1 : 3;
    if (!load_param_numbers(log, node->place, text, count, d)) return SATIN_ERROR_INPUT;
    *out = count == 1 ? rgb_grey((float)d[0]) : rgb_make((float)d[0], (float)d[1], (float)d[2]);
    if (node->encoded)
        *out = rgb_make(load_srgb_to_linear(out->r), load_srgb_to_linear(out->g),
                        load_srgb_to_linear(out->b));
    return SATIN_OK;
}

static satin_status read_spectrum_file(struct param_source source, const struct xml_node *node,
                                       struct spectrum *out) {
    char *path = load_xml_resolve(source.xml, node->place, load_xml_get(node, "filename"));
    if (!path)
        return log_fail(source.log, SATIN_ERROR_MEMORY, "%s: not enough memory for the scene",
                        node->place.file);
    struct log_spared spared = {source.log, source.each, "it is .5 everywhere"};
    satin_status status = load_spectrum_read(source.lenient ? log_spare(&spared) : source.log,
                                             node->place, path, source.hash, out);
    if (status == SATIN_ERROR_INPUT && source.lenient)
        status = load_spectrum_parse(source.log, node->place, "300:.5 900:.5", out);
    if (status == SATIN_OK && !fileio_files_add(source.xml->read, path)) {
        scene_spectrum_free(out);
        status = log_fail(source.log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    }
    free(path);
    return status;
}

static satin_status read_spectrum(struct param_source source, struct xml_node *node, bool light,
                                  rgb *out) {
    const char *text = load_xml_get(node, "value"), *file = load_xml_get(node, "filename");
    if ((text != NULL) + (file != NULL) + (node->type != NULL) != 1) {
        log_error_at(source.log, node->place,
                     "<spectrum> has either a value, a filename or a type");
        return SATIN_ERROR_INPUT;
    }
    if (node->type) return load_spectrum_of(source, node, light, out);
    if (text && !strchr(text, ':') && load_param_words(text) == 3)
        return read_rgb(source.log, node, out);
    if (text && !strchr(text, ':')) {
        double d;
        if (!load_param_numbers(source.log, node->place, text, 1, &d)) return SATIN_ERROR_INPUT;
        *out = rgb_scale(light && !node->mitsuba06 ? equal_energy : rgb_grey(1.0f), (float)d);
        return SATIN_OK;
    }
    struct spectrum spectrum;
    satin_status status = file ? read_spectrum_file(source, node, &spectrum)
                               : load_spectrum_parse(source.log, node->place, text, &spectrum);
    if (status != SATIN_OK) return status;
    *out = scene_spectrum_to_rgb(&spectrum, light);
    scene_spectrum_free(&spectrum);
    return SATIN_OK;
}

satin_status load_color(struct param_source source, struct xml_node *node, bool light, rgb *out) {
    if (node->tag == XML_SPECTRUM) return read_spectrum(source, node, light, out);
    if (node->tag == XML_POINT || node->tag == XML_VECTOR) {
        vec3 v;
        if (!load_param_xyz(source.log, node, NAN, &v)) return SATIN_ERROR_INPUT;
        *out = rgb_make(v.x, v.y, v.z);
        return SATIN_OK;
    }
    return read_rgb(source.log, node, out);
}
