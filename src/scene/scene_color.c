// SPDX-License-Identifier: Apache-2.0
// Colours: <rgb> as one number (grey), three (linear sRGB) or #rrggbb (encoded sRGB); <spectrum>
// as a constant; <float>. Conversions are those of Mitsuba 3 in its RGB mode.
#include <string.h>

#include "base/text.h"
#include "scene/scene_params.h"

// Linear sRGB of light of equal energy at all wavelengths, luminance 1, as Mitsuba integrates it.
static const rgb equal_energy = {1.204794f, 0.948291f, 0.908916f};

static float srgb_decode(int byte) {
    float x = (float)byte / 255.0f;
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

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
        c[i] = srgb_decode(16 * high + low);
    }
    *out = rgb_make(c[0], c[1], c[2]);
    return true;
}

static satin_status read_rgb(struct log log, const struct xml_node *node, rgb *out) {
    const char *text = xml_get(node, "value");
    double d[3];
    if (text[0] == '#') {
        if (read_hex(text, out)) return SATIN_OK;
        log_error_at(log, node->place, "'%s' is not a colour of the form #rrggbb", text);
        return SATIN_ERROR_INPUT;
    }
    int count = param_words(text) == 1 ? 1 : 3;
    if (!param_numbers(log, node->place, text, count, d)) return SATIN_ERROR_INPUT;
    *out = count == 1 ? rgb_grey((float)d[0]) : rgb_make((float)d[0], (float)d[1], (float)d[2]);
    return SATIN_OK;
}

static satin_status read_spectrum(struct log log, const struct xml_node *node, bool light,
                                  rgb *out) {
    const char *text = xml_get(node, "value");
    if (!text || strchr(text, ':') || xml_get(node, "filename") || node->type) {
        log_error_at(log, node->place, "'%s': only constant spectra are supported", node->name);
        return SATIN_ERROR_INPUT;
    }
    double d;
    if (!param_numbers(log, node->place, text, 1, &d)) return SATIN_ERROR_INPUT;
    *out = rgb_scale(light ? equal_energy : rgb_grey(1.0f), (float)d);
    return SATIN_OK;
}

satin_status scene_color_read(struct log log, const struct xml_node *node, bool light, rgb *out) {
    if (node->tag == XML_SPECTRUM) return read_spectrum(log, node, light, out);
    return read_rgb(log, node, out);
}
