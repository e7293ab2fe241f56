// SPDX-License-Identifier: Apache-2.0
// Private to load/: plugins and their parameters. A table per plugin defines its parameters;
// reading an element by its table gives typed, checked values. The documentation is printed from
// the same tables.
#ifndef LOAD_PARAMS_H
#define LOAD_PARAMS_H

#include "base/mat4.h"
#include "base/vec.h"
#include "load/load_xml.h"

enum param_kind {
    PARAM_BOOLEAN,
    PARAM_INTEGER,
    PARAM_FLOAT,
    PARAM_STRING,
    PARAM_CHOICE,  // one of `choices`; letter case does not matter
    PARAM_POINT,   // <point> or <vector>
    PARAM_TRANSFORM,
    PARAM_COLOR,  // <rgb>, <spectrum> or <float>; in a spectrum also <vector>
    PARAM_LIGHT,  // as PARAM_COLOR, for light: a constant <spectrum> is equal energy, not white
    PARAM_IOR     // <float> or the name of a medium
};

// RANGE_MODEST is 0 to 10^6: numbers whose squares and products must be far from overflow.
// RANGE_TEXEL: a number as RANGE_MODEST, a colour as RANGE_UNIT. RANGE_CLAMPED: values outside [0,
// 1] are clamped, with a warning.
enum param_range {
    RANGE_ANY = 0,
    RANGE_POSITIVE,
    RANGE_NOT_NEGATIVE,
    RANGE_MODEST,
    RANGE_UNIT,
    RANGE_TEXEL,
    RANGE_CLAMPED
};

enum param_flag {
    PARAM_REQUIRED = 1,
    PARAM_TEXTURE = 2,  // a <texture> is accepted
};

struct param_spec {
    const char *name;
    enum param_kind kind;
    const char *default_text;  // the default in the notation of the file; NULL: none
    enum param_range range;
    unsigned flags;
    const char *const *choices;  // NULL-ended
    const char *doc;
};

enum { PARAM_MAX = 24 };  // largest number of parameters of a plugin

struct param_value {
    bool given;              // whether it is in the file; else it has the default, if there is one
    struct log_place place;  // of the value, or of the plugin
    struct xml_node *texture;  // set if it is given by a <texture>; then there is no value
    bool b;
    int i;  // PARAM_CHOICE: index
    float f;
    const char *s;  // valid as long as the tree
    vec3 v;
    rgb color;
    struct mat4 m;
};

struct load_state;
struct params;
struct text_nearest;

// Builds the object that an element describes. `object` is, by element: <bsdf> struct
// material_side, <shape> struct shape, <emitter> struct light, <texture> struct texture, <sensor>
// struct camera, <film> and <rfilter> struct scene_film; else NULL.
typedef satin_status (*plugin_build)(struct load_state *loader, const struct params *params,
                                     void *object);

struct plugin_spec {
    enum xml_tag tag;
    const char *name;  // NULL ends a table
    const char *doc;
    const struct param_spec *const *params;  // NULL-ended; NULL: none
    unsigned children;                       // other objects that it takes: bits 1 << xml_tag
    plugin_build build;
    // The plugin is also read under the names of load_transport, and other parameters have no
    // effect, which is a warning and not an error.
    bool lenient;
};

struct params {
    const struct plugin_spec *plugin;
    struct xml_node *node;
    struct param_value value[PARAM_MAX];
};

// Context for reading parameters.
struct param_source {
    struct log log;
    const struct load_xml *xml;
    uint64_t *hash;  // continued over the files of spectra; may be NULL
    bool lenient;    // what is missing or unknown is left out, with a warning in the log `each`
    struct log each;
};

// Reads all parameters of an element. A parameter that is unknown, of another kind, given twice,
// out of range or missing is an error, of which one is logged.
satin_status load_params_read(struct param_source source, const struct plugin_spec *plugin,
                              struct xml_node *node, struct params *out);

// Whether the plugin has a parameter of that name.
bool load_params_has(const struct params *params, const char *name);
// A parameter by its name, which must be in the table.
const struct param_value *load_param(const struct params *params, const char *name);

// The next child of an element after `after` (NULL: the first child) that is, or refers to, an
// object of that tag. NULL at the end.
struct xml_node *load_params_child(const struct load_xml *xml, const struct xml_node *node,
                                   enum xml_tag tag, struct xml_node **after);

// ---- load_values.c
// Read values from text; each logs an error at `place`. Numbers are finite; lists are separated by
// blanks or commas.
bool load_param_numbers(struct log log, struct log_place place, const char *text, int count,
                        double *out);
// Reads the next number of a list and advances *text. Logs an error if it is not a number.
bool load_param_number(struct log log, struct log_place place, const char **text, double *out);
// The number of words of `text`.
int load_param_words(const char *text);
// Reads x, y and z, or the value, of an element. Absent coordinates are `missing`; if that is NaN,
// they are an error.
bool load_param_xyz(struct log log, const struct xml_node *node, float missing, vec3 *out);

// Logs that nearest->word, the value of the parameter `name`, is none of those in `list`, of which
// the nearest is named if it is near: SATIN_ERROR_INPUT.
satin_status load_value_unknown(struct log log, const char *name, struct log_place place,
                                const struct text_nearest *nearest, const char *list);

// Reads the value of a parameter from an element, or its default.
satin_status load_param_read(struct param_source source, const struct param_spec *spec,
                             struct xml_node *node, struct param_value *value);
satin_status load_param_read_default(struct log log, const struct param_spec *spec,
                                     struct param_value *value);

// The product of the steps of a <transform> (load_transform.c).
satin_status load_transform(struct log log, const struct xml_node *node, struct mat4 *out);
// Whether m maps spheres to spheres, to one part in a thousand.
bool load_transform_similar(const struct mat4 *m);
// The rotation, mirrored if m mirrors, under which the y axis and the plane of x and y are where m
// has them, and the translation of m. m is not singular.
struct mat4 load_transform_unstretched(const struct mat4 *m);
// A colour from <rgb>, <spectrum> or <float> (load_color.c).
satin_status load_color(struct param_source source, struct xml_node *node, bool light, rgb *out);
// Whether this is a type of <spectrum> (load_plugins_spectrum.c).
bool load_spectrum_named(const char *type);
// A colour from a <spectrum> with a type.
satin_status load_spectrum_of(struct param_source source, struct xml_node *node, bool light,
                              rgb *out);

// All plugins (load_plugins.c). Finds the plugin of an element. If there is none, logs an error
// with the nearest name and returns NULL.
const struct plugin_spec *load_plugin_find(struct log log, const struct xml_node *node);
// Whether some plugin of an element has a parameter of that name.
bool load_param_known(enum xml_tag tag, const char *name);
// Integrators that are read like `path` (load_plugins_integrator.c), NULL-ended.
extern const char *const load_transport[];
// A reflectance over 1, or a sum of them, is scaled to this, as in Mitsuba 0.6.
#define ALBEDO_MOST 0.99f

// Whether satin reads the plugin of an object.
bool load_plugin_known(const struct xml_node *node);
// Corrects the type of an element that differs from a known one in case only, with a warning.
void load_plugin_correct_case(struct log log, struct xml_node *node);
// Whether Mitsuba has the plugin of an object and satin does not read it.
bool load_plugin_unread(const struct xml_node *node);
// The word for an object in messages: BRDF, shape, ...
const char *load_plugin_noun(enum xml_tag tag);

extern const struct plugin_spec load_bsdf_plugins[], load_texture_plugins[], load_shape_plugins[],
    load_shape06_plugins[], load_group_plugins[], load_emitter_plugins[], load_sensor_plugins[],
    load_film_plugins[], load_integrator_plugins[], load_spectrum_plugins[],
    load_daylight_plugins[];

// Named indices of refraction (load_ior.c). False if the name is unknown. The names can be listed
// by index; NULL beyond the last.
bool load_ior_find(const char *name, float *ior);
const char *load_ior_name(int index);
bool load_metal_find(const char *name, rgb *eta, rgb *k);
const char *load_metal_name(int index);
// Writes the names, separated by commas, and returns `out`. Those that do not fit are cut off.
const char *load_names_list(const char *(*name)(int), char *out, size_t size);

#endif
