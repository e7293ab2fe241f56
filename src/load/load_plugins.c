// SPDX-License-Identifier: Apache-2.0
// All plugins of scene files: lookup by name, and their description for the documentation.
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/text.h"
#include "load/load.h"
#include "load/load_params.h"

static const struct plugin_spec *const tables[] = {
    load_shape_plugins,      load_shape06_plugins,  load_group_plugins,    load_bsdf_plugins,
    load_texture_plugins,    load_emitter_plugins,  load_sensor_plugins,   load_film_plugins,
    load_integrator_plugins, load_spectrum_plugins, load_daylight_plugins, NULL};

// Plugins that Mitsuba 3 has and satin does not read.
struct unread_kind {
    enum xml_tag tag;
    const char *const *name;
};

static const char *const unread_shapes[] = {"sdfgrid", "ellipsoids", "ellipsoidsmesh",
                                            "blender", "mesh",       NULL};
static const char *const unread_bsdfs[] = {
    "measured",           "hair", "pplastic", "polarizer", "retarder", "circular",
    "measured_polarized", "hk",   "irawan",   NULL};
static const char *const unread_textures[] = {"volume", "volumeadapter", "wireframe", "curvature",
                                              NULL};
static const char *const unread_emitters[] = {"timed_sunsky", "volumelight", "collimated", NULL};
static const char *const unread_sensors[] = {"distant",       "radiancemeter",   "batch",
                                             "hemispherical", "irradiancemeter", NULL};
static const char *const unread_films[] = {"specfilm", NULL};
static const char *const unread_integrators[] = {"depth", "volprim_rf_basic", "field", NULL};

static const struct unread_kind unread_plugins[] = {
    {XML_SHAPE, unread_shapes},          {XML_BSDF, unread_bsdfs},
    {XML_TEXTURE, unread_textures},      {XML_EMITTER, unread_emitters},
    {XML_SENSOR, unread_sensors},        {XML_FILM, unread_films},
    {XML_INTEGRATOR, unread_integrators}};

const char *load_plugin_noun(enum xml_tag tag) {
    if (tag == XML_BSDF) return "BRDF";
    return tag == XML_RFILTER ? "filter" : load_xml_tag_name(tag);
}

bool load_plugin_unread(const struct xml_node *node) {
    for (size_t i = 0; i < sizeof unread_plugins / sizeof *unread_plugins; i++) {
        if (unread_plugins[i].tag != node->tag) continue;
        for (const char *const *name = unread_plugins[i].name; *name; name++)
            if (strcmp(*name, node->type) == 0) return true;
    }
    return false;
}

static bool is_named(const struct plugin_spec *plugin, const char *type) {
    if (strcmp(plugin->name, type) == 0) return true;
    for (const char *const *name = load_transport; plugin->lenient && *name; name++)
        if (strcmp(*name, type) == 0) return true;
    return false;
}

// The known name that is nearest to a misspelt one.
static const char *nearest_name(const struct xml_node *node) {
    struct text_nearest nearest = {.word = node->type};
    for (int t = 0; tables[t]; t++)
        for (const struct plugin_spec *plugin = tables[t]; plugin->name; plugin++) {
            if (plugin->tag != node->tag) continue;
            text_nearest_try(&nearest, plugin->name);
            for (const char *const *name = load_transport; plugin->lenient && *name; name++)
                text_nearest_try(&nearest, *name);
        }
    return nearest.best;
}

// An unknown sampler, film, filter or integrator hardly changes the image, so it is read as the
// plainest plugin of its kind.
static const char *substitute_type(enum xml_tag tag) {
    switch (tag) {
        case XML_INTEGRATOR:
            return "path";
        case XML_SAMPLER:
            return "independent";
        case XML_FILM:
            return "hdrfilm";
        case XML_RFILTER:
            return "gaussian";
        default:
            return NULL;
    }
}

static const struct plugin_spec *find_named(const struct xml_node *node, const char *name) {
    for (int t = 0; tables[t]; t++)
        for (const struct plugin_spec *plugin = tables[t]; plugin->name; plugin++)
            if (plugin->tag == node->tag && is_named(plugin, name)) return plugin;
    return NULL;
}

// The name of the plugin that the element means if its case does not count, or NULL.
static const char *find_by_any_case(const struct xml_node *node) {
    for (int t = 0; tables[t]; t++)
        for (const struct plugin_spec *plugin = tables[t]; plugin->name; plugin++) {
            if (plugin->tag != node->tag) continue;
            if (strcasecmp(plugin->name, node->type) == 0) return plugin->name;
            for (const char *const *name = load_transport; plugin->lenient && *name; name++)
                if (strcasecmp(*name, node->type) == 0) return *name;
        }
    return NULL;
}

void load_plugin_correct_case(struct log log, struct xml_node *node) {
    if (!load_xml_is_object(node->tag) || node->tag == XML_SCENE || !node->type) return;
    const char *known = load_plugin_known(node) ? NULL : find_by_any_case(node);
    if (!known) return;
    log_warning_at(log, node->place, "unknown %s '%s', which is read as '%s'",
                   load_plugin_noun(node->tag), node->type, known);
    node->type = known;
}

bool load_plugin_known(const struct xml_node *node) { return find_named(node, node->type) != NULL; }

const struct plugin_spec *load_plugin_find(struct log log, const struct xml_node *node) {
    const struct plugin_spec *plugin = find_named(node, node->type);
    if (plugin) return plugin;
    const char *noun = load_plugin_noun(node->tag), *nearest = nearest_name(node);
    const char *plain = substitute_type(node->tag);
    if (load_plugin_unread(node)) {
        log_error_at(log, node->place, "%s '%s' is not supported", noun, node->type);
    } else if (plain) {
        const bool hint = nearest && strcmp(nearest, plain) != 0;
        log_warning_at(log, node->place, "unknown %s '%s'%s%s%s, which is read as '%s'", noun,
                       node->type, hint ? " (did you mean '" : "", hint ? nearest : "",
                       hint ? "'?)" : "", plain);
        return find_named(node, plain);
    } else if (nearest) {
        log_error_at(log, node->place, "unknown %s '%s' (did you mean '%s'?)", noun, node->type,
                     nearest);
    } else {
        log_error_at(log, node->place, "unknown %s '%s' (`satin help plugins` lists all)", noun,
                     node->type);
    }
    return NULL;
}

bool load_param_known(enum xml_tag tag, const char *name) {
    for (int t = 0; tables[t]; t++)
        for (const struct plugin_spec *plugin = tables[t]; plugin->name; plugin++)
            for (int i = 0; plugin->tag == tag && plugin->params && plugin->params[i]; i++)
                if (strcmp(plugin->params[i]->name, name) == 0) return true;
    return false;
}

// ---- Documentation ------------------------------------------------------------------------------

static const struct plugin_spec *plugin_at(int index) {
    for (int t = 0; tables[t]; t++)
        for (const struct plugin_spec *plugin = tables[t]; plugin->name; plugin++)
            if (index-- == 0) return plugin;
    return NULL;
}

bool load_plugin_describe(int index, struct load_plugin_info *out) {
    const struct plugin_spec *plugin = index >= 0 ? plugin_at(index) : NULL;
    if (!plugin) return false;
    *out = (struct load_plugin_info){load_xml_tag_name(plugin->tag), plugin->name, plugin->doc};
    return true;
}

// How a parameter is written: its elements, or its choices.
static void describe_kind(const struct param_spec *spec, char *text, size_t size) {
    static const char *const elements[] = {[PARAM_BOOLEAN] = "boolean",
                                           [PARAM_INTEGER] = "integer",
                                           [PARAM_FLOAT] = "float",
                                           [PARAM_STRING] = "string",
                                           [PARAM_CHOICE] = "",
                                           [PARAM_POINT] = "point",
                                           [PARAM_TRANSFORM] = "transform",
                                           [PARAM_COLOR] = "rgb or spectrum",
                                           [PARAM_LIGHT] = "rgb or spectrum",
                                           [PARAM_IOR] = "float or string"};
    snprintf(text, size, "%s%s", elements[spec->kind],
             spec->flags & PARAM_TEXTURE ? " or texture" : "");
    for (int i = 0; spec->choices && spec->choices[i]; i++) {
        size_t n = strlen(text);
        snprintf(text + n, size - n, "%s%s", i ? ", " : "", spec->choices[i]);
    }
}

bool load_param_describe(int plugin_index, int index, struct load_param_info *out) {
    static const char *const ranges[] = {
        "", "> 0", ">= 0", "0 to 1e6", "0 to 1", "numbers 0 to 1e6, colours 0 to 1", "0 to 1"};
    const struct plugin_spec *plugin = plugin_index >= 0 ? plugin_at(plugin_index) : NULL;
    if (!plugin || !plugin->params || index < 0) return false;
    for (int i = 0; i <= index; i++)
        if (!plugin->params[i]) return false;
    const struct param_spec *spec = plugin->params[index];
    *out = (struct load_param_info){.name = spec->name,
                                    .value = spec->default_text,
                                    .range = ranges[spec->range],
                                    .required = (spec->flags & PARAM_REQUIRED) != 0,
                                    .doc = spec->doc};
    if (spec->kind == PARAM_TRANSFORM) out->value = "identity";
    describe_kind(spec, out->kind, sizeof out->kind);
    return true;
}

bool load_unread_describe(int index, struct load_plugin_info *out) {
    for (size_t i = 0; index >= 0 && i < sizeof unread_plugins / sizeof *unread_plugins; i++)
        for (const char *const *name = unread_plugins[i].name; *name; name++)
            if (index-- == 0) {
                *out = (struct load_plugin_info){load_xml_tag_name(unread_plugins[i].tag), *name,
                                                 NULL};
                return true;
            }
    return false;
}
