// SPDX-License-Identifier: Apache-2.0
// Reads the parameters of an element by its plugin's table.
#include "load/load_params.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"

// The elements by which a parameter may be given, as bits 1 << xml_tag.
static unsigned accepted_tags(const struct plugin_spec *plugin, const struct param_spec *spec) {
    const unsigned number = 1u << XML_FLOAT | 1u << XML_INTEGER;
    const unsigned color = 1u << XML_RGB | 1u << XML_SPECTRUM;
    const unsigned point = 1u << XML_POINT | 1u << XML_VECTOR;
    switch (spec->kind) {
        case PARAM_BOOLEAN:
            return 1u << XML_BOOLEAN;
        case PARAM_INTEGER:
            return 1u << XML_INTEGER;
        case PARAM_FLOAT:
            return spec->flags & PARAM_TEXTURE ? number | color : number;
        case PARAM_STRING:
        case PARAM_CHOICE:
            return 1u << XML_STRING;
        case PARAM_POINT:
            return point;
        case PARAM_TRANSFORM:
            return 1u << XML_TRANSFORM;
        case PARAM_COLOR:
        case PARAM_LIGHT:
            return number | color | (plugin->tag == XML_SPECTRUM ? point : 0u);
        case PARAM_IOR:
            return number | 1u << XML_STRING;
    }
    return 0;
}

static int find_spec(const struct plugin_spec *plugin, const char *name) {
    for (int i = 0; plugin->params && plugin->params[i]; i++)
        if (strcmp(plugin->params[i]->name, name) == 0) return i;
    return -1;
}

// A misspelt parameter is an error. One that is far from all known names, or belongs to another
// plugin of the same element, does not change the image and is a warning.
static satin_status unknown_parameter(struct param_source source, const struct plugin_spec *plugin,
                                      const struct xml_node *child) {
    struct log log = source.log;
    struct text_nearest nearest = {.word = child->name};
    for (int i = 0; plugin->params && plugin->params[i]; i++)
        text_nearest_try(&nearest, plugin->params[i]->name);
    const char *noun = load_plugin_noun(plugin->tag), *written = load_xml_get(child, "name");
    if (nearest.best && !load_param_known(plugin->tag, child->name) && !source.lenient) {
        log_error_at(log, child->place, "%s '%s' has no parameter '%s' (did you mean '%s'?)", noun,
                     plugin->name, written, nearest.best);
        return SATIN_ERROR_INPUT;
    }
    if (plugin->lenient)
        log_warning_at(log, child->place, "'%s' has no effect here", written);
    else
        log_warning_at(log, child->place, "%s '%s' has no parameter '%s', which has no effect",
                       noun, plugin->name, written);
    return SATIN_OK;
}

// Logs that an object stands where it cannot.
static satin_status misplaced_object(struct param_source source, const struct plugin_spec *plugin,
                                     const struct xml_node *child, enum xml_tag tag) {
    struct log_spared spared = {source.log, source.each, "it is left out"};
    struct log log = source.lenient ? log_spare(&spared) : source.log;
    static const char *const home[XML_TAG_COUNT] = {
        [XML_BSDF] = "<shape>",   [XML_EMITTER] = "<shape> or <scene>", [XML_FILM] = "<sensor>",
        [XML_RFILTER] = "<film>", [XML_SAMPLER] = "<sensor>",           [XML_SENSOR] = "<scene>",
        [XML_SHAPE] = "<scene>",  [XML_INTEGRATOR] = "<scene>"};
    char parent[128];
    snprintf(parent, sizeof parent, plugin->tag == XML_SCENE ? "<scene>" : "%s '%.99s'",
             load_plugin_noun(plugin->tag), plugin->name);
    log_error_at(log, child->place, "%s takes no <%s>%s%s", parent, load_xml_tag_name(tag),
                 tag == XML_TEXTURE ? " without a name"
                 : home[tag]        ? "; its place is "
                                    : "",
                 home[tag] ? home[tag] : "");
    return source.lenient ? SATIN_OK : SATIN_ERROR_INPUT;
}

// Reads a child that is an object: a texture for a parameter, or another object that the plugin
// takes.
static satin_status read_object(struct param_source source, struct params *out,
                                const struct xml_node *child, struct xml_node *target) {
    struct log log = source.log;
    const struct plugin_spec *plugin = out->plugin;
    int i = target->tag == XML_TEXTURE && child->name ? find_spec(plugin, child->name) : -1;
    if (i >= 0 && (plugin->params[i]->flags & PARAM_TEXTURE)) {
        if (out->value[i].given) {
            log_error_at(log, child->place, "'%s' is given twice", child->name);
            return SATIN_ERROR_INPUT;
        }
        out->value[i].given = true;
        out->value[i].place = child->place;
        out->value[i].texture = target;
        return SATIN_OK;
    }
    if (plugin->children & 1u << target->tag) return SATIN_OK;
    if (i >= 0)
        log_error_at(log, child->place, "%s of %s '%s' cannot be textured", child->name,
                     load_plugin_noun(plugin->tag), plugin->name);
    else if (target->tag == XML_TEXTURE && child->name)
        return unknown_parameter(source, plugin, child);
    else
        return misplaced_object(source, plugin, child, target->tag);
    return SATIN_ERROR_INPUT;
}

enum { TAG_LIST = 64 };  // enough for four names of elements

// Lists the accepted elements: "<integer> or <float>".
static void list_tags(unsigned accepted, char text[TAG_LIST]) {
    size_t length = 0;
    for (int tag = 0; accepted && length < TAG_LIST; tag++) {
        if (!(accepted & 1u << tag)) continue;
        accepted &= ~(1u << tag);
        const char *before = length == 0 ? "" : accepted ? ", " : " or ";
        length += (size_t)snprintf(text + length, TAG_LIST - length, "%s<%s>", before,
                                   load_xml_tag_name((enum xml_tag)tag));
    }
}

// Reads an index of refraction by its name. If that is unknown, the parameter is not given.
static satin_status read_known_ior(struct param_source source, const struct param_spec *spec,
                                   struct xml_node *node, struct param_value *value) {
    struct log_spared unknown = {source.log, source.each, "it has the default"};
    source.log = log_spare(&unknown);
    value->given = load_param_read(source, spec, node, value) == SATIN_OK;
    return SATIN_OK;
}

// Reads a child that gives a value, or that (`child`) refers to one (`target`).
static satin_status read_child(struct param_source source, struct params *out,
                               const struct xml_node *child, struct xml_node *target) {
    struct log log = source.log;
    const struct plugin_spec *plugin = out->plugin;
    if (!child->name) {
        log_error_at(log, child->place, "<%s> needs the attribute 'name'",
                     load_xml_tag_name(child->tag));
        return SATIN_ERROR_INPUT;
    }
    int i = find_spec(plugin, child->name);
    if (i < 0) return unknown_parameter(source, plugin, child);
    const struct param_spec *spec = plugin->params[i];
    struct param_value *value = &out->value[i];
    if (value->given) {
        log_error_at(log, child->place, "'%s' is given twice", child->name);
        return SATIN_ERROR_INPUT;
    }
    unsigned accepted = accepted_tags(plugin, spec);
    if (!(accepted & 1u << target->tag)) {
        char list[TAG_LIST];
        list_tags(accepted, list);
        log_error_at(log, child->place, "'%s' must be %s, not <%s>", child->name, list,
                     load_xml_tag_name(target->tag));
        return SATIN_ERROR_INPUT;
    }
    value->given = true;
    value->place = child->place;
    if (source.lenient && spec->kind == PARAM_IOR && target->tag == XML_STRING)
        return read_known_ior(source, spec, target, value);
    return load_param_read(source, spec, target, value);
}

satin_status load_params_read(struct param_source source, const struct plugin_spec *plugin,
                              struct xml_node *node, struct params *out) {
    *out = (struct params){.plugin = plugin, .node = node};
    for (struct xml_node *child = node->child; child; child = child->next) {
        struct log_spared missing = {source.log, source.each, "it is left out"};
        struct xml_node *target =
            load_xml_target(source.xml, source.lenient ? log_spare(&missing) : source.log, child);
        if (!target && source.lenient) continue;
        if (!target) return SATIN_ERROR_INPUT;
        if (target->tag == XML_UNREAD) {
            log_warning_at(source.log, child->place,
                           "'%s' is a <%s>, which is not supported: the image is without it",
                           target->id, target->type);
            node->medium = node->medium || strcmp(target->type, "medium") == 0;
            continue;
        }
        // A colour that is only defined for references.
        if (plugin->tag == XML_SCENE && target->id && !load_xml_is_object(target->tag)) continue;
        satin_status status = load_xml_is_object(target->tag)
                                  ? read_object(source, out, child, target)
                                  : read_child(source, out, child, target);
        if (status != SATIN_OK) return status;
    }
    for (int i = 0; plugin->params && plugin->params[i]; i++) {
        const struct param_spec *spec = plugin->params[i];
        if (out->value[i].given) continue;
        out->value[i].place = node->place;
        if (spec->flags & PARAM_REQUIRED) {
            log_error_at(source.log, node->place, "%s '%s' needs the parameter '%s'",
                         load_plugin_noun(plugin->tag), plugin->name, spec->name);
            return SATIN_ERROR_INPUT;
        }
        if (!spec->default_text) continue;
        satin_status status = load_param_read_default(source.log, spec, &out->value[i]);
        if (status != SATIN_OK) return status;
    }
    return SATIN_OK;
}

bool load_params_has(const struct params *params, const char *name) {
    return find_spec(params->plugin, name) >= 0;
}

const struct param_value *load_param(const struct params *params, const char *name) {
    int i = find_spec(params->plugin, name);
    assert(i >= 0);
    return &params->value[i];
}

struct xml_node *load_params_child(const struct load_xml *xml, const struct xml_node *node,
                                   enum xml_tag tag, struct xml_node **after) {
    struct xml_node *child = *after ? (*after)->next : node->child;
    for (; child; child = child->next) {
        struct xml_node *target = load_xml_target(xml, (struct log){0}, child);
        if (!target || target->tag != tag) continue;
        *after = child;
        return target;
    }
    return NULL;
}
