// SPDX-License-Identifier: Apache-2.0
// <spectrum type="...">: spectra by name, with the names and parameters of Mitsuba 3. Its RGB mode
// does not support blackbody, regular and irregular; here they are converted as a list of the same
// samples is, with the scale of its spectral mode.
#include <string.h>

#include "load/load_params.h"
#include "load/load_spectrum.h"

static const struct param_spec temperature = {"temperature",
                                              PARAM_FLOAT,
                                              NULL,
                                              RANGE_POSITIVE,
                                              PARAM_REQUIRED,
                                              NULL,
                                              "The temperature of the body, in kelvin."};
static const struct param_spec first = {"wavelength_min",
                                        PARAM_FLOAT,
                                        "360",
                                        RANGE_NOT_NEGATIVE,
                                        0,
                                        NULL,
                                        "The shortest wavelength that is emitted, in nm."};
static const struct param_spec last = {"wavelength_max",
                                       PARAM_FLOAT,
                                       "830",
                                       RANGE_NOT_NEGATIVE,
                                       0,
                                       NULL,
                                       "The longest wavelength that is emitted, in nm."};
static const struct param_spec from = {"wavelength_min",
                                       PARAM_FLOAT,
                                       NULL,
                                       RANGE_NOT_NEGATIVE,
                                       PARAM_REQUIRED,
                                       NULL,
                                       "The wavelength of the first value, in nm."};
static const struct param_spec to = {"wavelength_max",
                                     PARAM_FLOAT,
                                     NULL,
                                     RANGE_NOT_NEGATIVE,
                                     PARAM_REQUIRED,
                                     NULL,
                                     "The wavelength of the last value, in nm."};
static const struct param_spec spectrum_scale = {"scale", PARAM_FLOAT, "1", RANGE_NOT_NEGATIVE, 0,
                                                 NULL,    "A factor."};
static const struct param_spec d65_color = {
    "color", PARAM_COLOR, "1", RANGE_NOT_NEGATIVE, 0, NULL, "The colour of a surface lit by D65."};
static const struct param_spec number = {"value",
                                         PARAM_FLOAT,
                                         NULL,
                                         RANGE_NOT_NEGATIVE,
                                         PARAM_REQUIRED,
                                         NULL,
                                         "The value of red, green and blue."};
// Plugins `rgb` and `srgb` have the same parameter under different names.
#define LINEAR_COLOR(name)                                                 \
    {                                                                      \
        name, PARAM_COLOR, NULL, RANGE_NOT_NEGATIVE, PARAM_REQUIRED, NULL, \
            "The colour in linear sRGB."                                   \
    }
static const struct param_spec rgb_value = LINEAR_COLOR("value"),
                               srgb_color = LINEAR_COLOR("color");
static const struct param_spec unbounded = {
    "unbounded",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "It has no effect: the range is that of the parameter."};
static const struct param_spec values = {"values", PARAM_STRING,        NULL, 0, PARAM_REQUIRED,
                                         NULL,     "A list of numbers."};
static const struct param_spec wavelengths = {
    "wavelengths", PARAM_STRING, NULL, 0, PARAM_REQUIRED, NULL, "A list of wavelengths, in nm."};

typedef const struct param_spec *const param_list[];
static param_list blackbody_params = {&temperature, &first, &last, &spectrum_scale, NULL};
static param_list d65_params = {&d65_color, &spectrum_scale, NULL};
static param_list regular_params = {&values, &from, &to, NULL};
static param_list irregular_params = {&wavelengths, &values, NULL};
static param_list uniform_params = {&number, NULL};
static param_list rgb_params = {&rgb_value, NULL};
static param_list srgb_params = {&srgb_color, &unbounded, NULL};

const struct plugin_spec load_spectrum_plugins[] = {
    {XML_SPECTRUM, "blackbody", "the emission of a black body [W m^-2 sr^-1 nm^-1]",
     blackbody_params, 0, NULL, false},
    {XML_SPECTRUM, "d65", "daylight, scaled to white of luminance 1", d65_params, 0, NULL, false},
    {XML_SPECTRUM, "regular", "a spectrum sampled at equal distances", regular_params, 0, NULL,
     false},
    {XML_SPECTRUM, "irregular", "a spectrum sampled at any wavelengths", irregular_params, 0, NULL,
     false},
    {XML_SPECTRUM, "uniform", "a grey value", uniform_params, 0, NULL, false},
    {XML_SPECTRUM, "rgb", "a colour", rgb_params, 0, NULL, false},
    {XML_SPECTRUM, "srgb", "a colour", srgb_params, 0, NULL, false},
    {0}};

bool load_spectrum_named(const char *type) {
    for (const struct plugin_spec *plugin = load_spectrum_plugins; plugin->name; plugin++)
        if (strcmp(plugin->name, type) == 0) return true;
    return false;
}

// Reads `values` to a new spectrum. `at` has the wavelengths; if it is NULL, they are at equal
// distances between `ends`.
static satin_status read_samples(struct log log, const struct params *p, const double ends[2],
                                 struct spectrum *spectrum) {
    const struct param_value *value = load_param(p, "values");
    const char *wavelength = ends ? NULL : load_param(p, "wavelengths")->s, *text = value->s;
    int count = load_param_words(text);
    if (count < 2 || (wavelength && load_param_words(wavelength) != count)) {
        log_error_at(log, value->place, "a spectrum needs two values or more, one per wavelength");
        return SATIN_ERROR_INPUT;
    }
    satin_status status = SATIN_OK;
    for (int i = 0; i < count && status == SATIN_OK; i++) {
        double x, y;
        if (!load_param_number(log, value->place, &text, &y)) return SATIN_ERROR_INPUT;
        if (ends)
            x = ends[0] + (ends[1] - ends[0]) * i / (count - 1);
        else if (!load_param_number(log, value->place, &wavelength, &x))
            return SATIN_ERROR_INPUT;
        status = load_spectrum_add(log, value->place, spectrum, x, y);
    }
    return status;
}

static satin_status read_list(struct log log, const struct params *p, bool light, rgb *out) {
    struct spectrum spectrum = {0};
    bool regular = strcmp(p->plugin->name, "regular") == 0;
    double ends[2] = {0.0, 0.0};
    if (regular) {
        ends[0] = load_param(p, "wavelength_min")->f;
        ends[1] = load_param(p, "wavelength_max")->f;
    }
    satin_status status = read_samples(log, p, regular ? ends : NULL, &spectrum);
    if (status == SATIN_OK) *out = scene_spectrum_to_rgb(&spectrum, light);
    scene_spectrum_free(&spectrum);
    return status;
}

satin_status load_spectrum_of(struct param_source source, struct xml_node *node, bool light,
                              rgb *out) {
    const struct plugin_spec *plugin = load_plugin_find(source.log, node);
    if (!plugin) return SATIN_ERROR_INPUT;
    struct params p;
    satin_status status = load_params_read(source, plugin, node, &p);
    if (status != SATIN_OK) return status;
    if (plugin->params == regular_params || plugin->params == irregular_params)
        return read_list(source.log, &p, light, out);
    if (plugin->params == uniform_params) {
        *out = rgb_grey(load_param(&p, "value")->f);
    } else if (plugin->params == d65_params) {
        *out = rgb_scale(load_param(&p, "color")->color, load_param(&p, "scale")->f);
    } else if (plugin->params == blackbody_params) {
        if (!light) {
            log_error_at(source.log, node->place, "a black body is light, not a reflectance");
            return SATIN_ERROR_INPUT;
        }
        *out = rgb_scale(scene_spectrum_blackbody(load_param(&p, "temperature")->f,
                                                  load_param(&p, "wavelength_min")->f,
                                                  load_param(&p, "wavelength_max")->f),
                         load_param(&p, "scale")->f);
    } else {
        *out = load_param(&p, plugin->params == rgb_params ? "value" : "color")->color;
    }
    return SATIN_OK;
}
