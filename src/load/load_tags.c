// SPDX-License-Identifier: Apache-2.0
// The elements of a scene file: names, attributes, and which elements may be children of which, as
// in Mitsuba 3.
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "load/load_mitsuba06.h"

struct tag_info {
    const char *name;
    const char *required[3], *optional[5];
};

static const struct tag_info tags[XML_TAG_COUNT] = {
    [XML_SCENE] = {"scene", {NULL}, {"id", "name"}},
    [XML_SHAPE] = {"shape", {"type"}, {"id", "name"}},
    [XML_BSDF] = {"bsdf", {"type"}, {"id", "name"}},
    [XML_TEXTURE] = {"texture", {"type"}, {"id", "name"}},
    [XML_EMITTER] = {"emitter", {"type"}, {"id", "name"}},
    [XML_SENSOR] = {"sensor", {"type"}, {"id", "name"}},
    [XML_FILM] = {"film", {"type"}, {"id", "name"}},
    [XML_RFILTER] = {"rfilter", {"type"}, {"id", "name"}},
    [XML_SAMPLER] = {"sampler", {"type"}, {"id", "name"}},
    [XML_INTEGRATOR] = {"integrator", {"type"}, {"id", "name"}},
    [XML_BOOLEAN] = {"boolean", {"name", "value"}, {NULL}},
    [XML_INTEGER] = {"integer", {"name", "value"}, {NULL}},
    [XML_FLOAT] = {"float", {"name", "value"}, {NULL}},
    [XML_STRING] = {"string", {"name", "value"}, {NULL}},
    [XML_POINT] = {"point", {"name"}, {"value", "x", "y", "z"}},
    [XML_VECTOR] = {"vector", {"name"}, {"value", "x", "y", "z"}},
    [XML_RGB] = {"rgb", {"value"}, {"name", "id"}},
    [XML_SPECTRUM] = {"spectrum", {NULL}, {"name", "value", "filename", "type", "id"}},
    [XML_TRANSFORM] = {"transform", {"name"}, {NULL}},
    [XML_TRANSLATE] = {"translate", {NULL}, {"value", "x", "y", "z"}},
    [XML_ROTATE] = {"rotate", {"angle"}, {"value", "x", "y", "z"}},
    [XML_SCALE] = {"scale", {NULL}, {"value", "x", "y", "z"}},
    [XML_LOOKAT] = {"lookat", {"origin", "target"}, {"up"}},
    [XML_MATRIX] = {"matrix", {"value"}, {NULL}},
    [XML_REF] = {"ref", {"id"}, {"name"}},
    [XML_ALIAS] = {"alias", {"id", "as"}, {NULL}},
    [XML_DEFAULT] = {"default", {"name", "value"}, {NULL}},
    [XML_INCLUDE] = {"include", {"filename"}, {"name"}},
    [XML_PATH] = {"path", {"value"}, {NULL}},
    [XML_UNREAD] = {"", {NULL}, {NULL}},
};

// Elements that Mitsuba has and satin does not read.
static const char *const unread_tags[] = {"medium", "phase", "volume", "field", "subsurface", NULL};

const char *load_xml_tag_name(enum xml_tag tag) { return tags[tag].name; }

bool load_xml_tag_unread(const char *name) {
    for (int i = 0; unread_tags[i]; i++)
        if (strcmp(unread_tags[i], name) == 0) return true;
    return false;
}

bool load_xml_tag_spared(enum xml_tag parent, const char *name) {
    if (parent == XML_SCENE) return load_xml_tag_unread(name);
    if (parent == XML_BSDF) return strcmp(name, "phase") == 0;
    return (parent == XML_SHAPE || parent == XML_SENSOR || parent == XML_EMITTER) &&
           (strcmp(name, "medium") == 0 || strcmp(name, "subsurface") == 0);
}

enum xml_tag load_xml_tag_find(struct log log, struct log_place place, const char *name) {
    for (int i = 0; i < XML_UNREAD; i++)
        if (strcmp(tags[i].name, name) == 0) return (enum xml_tag)i;
    if (load_xml_tag_unread(name)) {
        log_error_at(log, place, "<%s> is not supported", name);
        return XML_TAG_COUNT;
    }
    if (strcmp(name, "camera") == 0 || strcmp(name, "luminaire") == 0) {
        log_error_at(log, place, "<%s> is of Mitsuba 0.3, which is not supported", name);
        return XML_TAG_COUNT;
    }
    struct text_nearest nearest = {.word = name};
    for (int i = 0; i < XML_UNREAD; i++) text_nearest_try(&nearest, tags[i].name);
    if (nearest.best)
        log_error_at(log, place, "unknown element <%s> (did you mean <%s>?)", name, nearest.best);
    else
        log_error_at(log, place, "unknown element <%s>", name);
    return XML_TAG_COUNT;
}

bool load_xml_may_contain(enum xml_tag parent, enum xml_tag child) {
    bool step = child >= XML_TRANSLATE && child <= XML_MATRIX;
    if (parent == XML_TRANSFORM) return step;
    if (child == XML_PATH) return parent == XML_SCENE;
    if (parent == XML_SPECTRUM) return child >= XML_BOOLEAN && child <= XML_SPECTRUM;
    return load_xml_is_object(parent) && !step && child != XML_SCENE;
}

static bool is_listed(const char *const *list, int count, const char *name) {
    for (int i = 0; i < count && list[i]; i++)
        if (strcmp(list[i], name) == 0) return true;
    return false;
}

bool load_xml_attributes_valid(struct log log, const struct xml_node *node, bool root) {
    const struct tag_info *info = &tags[node->tag];
    for (const char *const *a = node->attribute; *a; a += 2) {
        if (is_listed(info->required, 3, *a) || is_listed(info->optional, 5, *a)) continue;
        if (strcmp(*a, "version") == 0) continue;
        if (node->mitsuba06 && load_mitsuba06_attribute(node->tag, *a)) continue;
        log_error_at(log, node->place, "<%s> has no attribute '%s'", info->name, *a);
        return false;
    }
    for (int i = 0; i < 3 && info->required[i]; i++) {
        if (load_xml_get(node, info->required[i])) continue;
        log_error_at(log, node->place, "<%s> needs the attribute '%s'", info->name,
                     info->required[i]);
        return false;
    }
    if (!root) return true;
    const char *version = load_xml_get(node, "version");
    if (!version) {
        log_error_at(log, node->place, "<%s> needs the attribute 'version'", info->name);
        return false;
    }
    if (strncmp(version, "3.", 2) == 0 || strncmp(version, "2.", 2) == 0 ||
        load_xml_version_mitsuba06(version))
        return true;
    if (strtol(version, NULL, 10) > 3) {
        log_warning_at(log, node->place, "version '%s' is read as 3.x", version);
        return true;
    }
    log_error_at(log, node->place, "version '%s' is not supported: 0.x, 2.x and 3.x are", version);
    return false;
}

bool load_xml_version_mitsuba06(const char *version) { return strncmp(version, "0.", 2) == 0; }

const char *load_xml_get(const struct xml_node *node, const char *attribute) {
    for (const char *const *a = node->attribute; *a; a += 2)
        if (strcmp(a[0], attribute) == 0) return a[1];
    return NULL;
}
