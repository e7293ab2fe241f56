// SPDX-License-Identifier: Apache-2.0
// Scene files of versions 0.4 to 0.6: `toWorld` is `to_world`, `intIOR` is `int_ior`, and some
// names differ by more than their spelling. Only elements of the same meaning are translated; all
// others are left for the tables of version 3, by which they are refused.
#include "load/load_mitsuba06.h"

#include <ctype.h>
#include <string.h>

#include "base/text.h"

struct pair {
    const char *from, *to;
};

static const char *map_name(const struct pair *pairs, const char *name) {
    for (; pairs->from; pairs++)
        if (strcmp(pairs->from, name) == 0) return pairs->to;
    return name;
}

const char *load_mitsuba06_tag(const char *name) {
    static const struct pair tags[] = {
        {"lookAt", "lookat"}, {"srgb", "rgb"}, {"blackbody", "spectrum"}, {NULL, NULL}};
    return map_name(tags, name);
}

bool load_mitsuba06_attribute(enum xml_tag tag, const char *name) {
    if ((tag == XML_RGB || tag == XML_SPECTRUM) && strcmp(name, "intent") == 0) return true;
    return tag == XML_SPECTRUM && (strcmp(name, "temperature") == 0 || strcmp(name, "scale") == 0);
}

// ---- Names --------------------------------------------------------------------------------------

// Converts a name to snake case: capitals become small letters, and a capital after a small letter
// gets an underscore before it.
static const char *snake_case(struct arena *arena, const char *name) {
    char *out = arena_alloc(arena, 2 * strlen(name) + 1);
    if (!out) return NULL;
    size_t n = 0;
    for (size_t i = 0; name[i]; i++) {
        bool capital = isupper((unsigned char)name[i]) != 0;
        if (capital && i && !isupper((unsigned char)name[i - 1]) && name[i - 1] != '_')
            out[n++] = '_';
        out[n++] = (char)tolower((unsigned char)name[i]);
    }
    out[n] = 0;
    return out;
}

// The name in version 3 of a plugin that was renamed.
static const char *plugin_name(const struct xml_node *node) {
    static const struct pair films[] = {{"ldrfilm", "hdrfilm"}, {NULL, NULL}};
    static const struct pair samplers[] = {
        {"halton", "ldsampler"}, {"hammersley", "ldsampler"}, {"sobol", "ldsampler"}, {NULL, NULL}};
    static const struct pair bsdfs[] = {{"bump", "bumpmap"}, {NULL, NULL}};
    if (node->tag == XML_FILM) return map_name(films, node->type);
    if (node->tag == XML_BSDF) return map_name(bsdfs, node->type);
    return node->tag == XML_SAMPLER ? map_name(samplers, node->type) : node->type;
}

static bool is_element(const struct xml_node *node, enum xml_tag tag, const char *type) {
    return node && node->tag == tag && (!type || strcmp(node->type, type) == 0);
}

static bool is_one_of(const char *name, const char *const *list) {
    for (; *list; list++)
        if (strcmp(*list, name) == 0) return true;
    return false;
}

// Whether a parameter never changed the image.
static bool is_idle(const struct xml_node *parent, const char *name) {
    static const char *const film[] = {"banner", "attach_log", NULL};
    static const char *const texture[] = {"cache", "max_anisotropy", NULL};
    if (parent->tag == XML_FILM) return is_one_of(name, film);
    return parent->tag == XML_TEXTURE && is_one_of(name, texture);
}

// Whether a parameter of a film says how the pixels of its file differ from the image.
static bool is_tonemap(const struct xml_node *parent, const char *name) {
    static const char *const film[] = {"gamma", "exposure", "tonemap_method", "key", "burn", NULL};
    return parent->tag == XML_FILM && is_one_of(name, film);
}

// ---- Values -------------------------------------------------------------------------------------

static satin_status set_attribute(struct arena *arena, struct xml_node *node, const char *name,
                                  const char *value) {
    size_t count = 0;
    while (node->attribute[count]) count++;
    const char **copy = arena_array(arena, count + 3, sizeof *copy);
    if (!copy) return SATIN_ERROR_MEMORY;
    bool found = false;
    for (size_t i = 0; i < count; i += 2) {
        bool same = strcmp(node->attribute[i], name) == 0;
        copy[i] = node->attribute[i];
        copy[i + 1] = same ? value : node->attribute[i + 1];
        found = found || same;
    }
    if (!found) {
        copy[count] = name;
        copy[count + 1] = value;
    }
    node->attribute = copy;
    return SATIN_OK;
}

static struct xml_node *new_node(struct arena *arena, const struct xml_node *from, enum xml_tag tag,
                                 const char *name, const char *value) {
    static const char *const names[] = {"name", "value", "x", "y"};
    struct xml_node *node = arena_alloc(arena, sizeof *node);
    const char **attribute = arena_array(arena, 3, sizeof *attribute);
    if (!node || !attribute) return NULL;
    for (int i = 0; i < 4; i++)
        if (strcmp(names[i], name) == 0) attribute[0] = names[i];
    attribute[1] = value;
    *node = (struct xml_node){.tag = tag, .place = from->place, .number = from->number};
    node->attribute = attribute;
    return node;
}

// Converts uvscale, uscale, vscale, uoffset and voffset of a texture to steps of its `to_uv`, in
// which scales come before translations.
static satin_status move_to_uv(struct arena *arena, struct xml_node *parent,
                               const struct xml_node *node) {
    struct xml_node *steps = parent->child;
    while (steps && !(steps->tag == XML_TRANSFORM && strcmp(steps->name, "to_uv") == 0))
        steps = steps->next;
    if (!steps) {
        steps = new_node(arena, node, XML_TRANSFORM, "name", "to_uv");
        if (!steps) return SATIN_ERROR_MEMORY;
        steps->name = "to_uv";
        load_xml_append(parent, steps);
    }
    const bool both = strcmp(node->name, "uvscale") == 0;
    bool scale = both || strcmp(node->name + 1, "scale") == 0;
    struct xml_node *step = new_node(arena, node, scale ? XML_SCALE : XML_TRANSLATE,
                                     both                   ? "value"
                                     : node->name[0] == 'u' ? "x"
                                                            : "y",
                                     load_xml_get(node, "value"));
    if (!step) return SATIN_ERROR_MEMORY;
    if (!scale || !steps->child) {
        load_xml_append(steps, step);
    } else {
        step->next = steps->child;
        steps->child = step;
    }
    return SATIN_OK;
}

// <blackbody name="..." temperature="5000K" scale="..."/>
static satin_status respell_blackbody(struct arena *arena, struct xml_node *node) {
    const char *kelvin = load_xml_get(node, "temperature"), *scale = load_xml_get(node, "scale");
    size_t n = strlen(kelvin);
    if (n && (kelvin[n - 1] == 'K' || kelvin[n - 1] == 'k')) n--;
    const char *text = arena_text(arena, kelvin, n);
    struct xml_node *t = text ? new_node(arena, node, XML_FLOAT, "value", text) : NULL;
    struct xml_node *s = new_node(arena, node, XML_FLOAT, "value", scale ? scale : "1");
    if (!t || !s) return SATIN_ERROR_MEMORY;
    t->name = "temperature";
    s->name = "scale";
    node->type = "blackbody";
    load_xml_append(node, t);
    load_xml_append(node, s);
    return SATIN_OK;
}

static bool is_uv_transform(const char *name) {
    return strcmp(name, "uscale") == 0 || strcmp(name, "vscale") == 0 ||
           strcmp(name, "uoffset") == 0 || strcmp(name, "voffset") == 0 ||
           strcmp(name, "uvscale") == 0;
}

static satin_status respell_value(struct log log, struct arena *arena, struct xml_node *parent,
                                  struct xml_node *node, bool *keep) {
    const bool tonemap = is_tonemap(parent, node->name);
    *keep = !tonemap && !is_idle(parent, node->name);
    if (tonemap)
        log_warning_at(log, node->place, "'%s' has no effect here", load_xml_get(node, "name"));
    if (!*keep) return SATIN_OK;
    if (is_element(parent, XML_TEXTURE, NULL) && node->tag == XML_FLOAT &&
        is_uv_transform(node->name)) {
        *keep = false;
        return move_to_uv(arena, parent, node);
    }
    const char *text = load_xml_get(node, "value");
    double gamma;
    if (is_element(parent, XML_TEXTURE, "bitmap") && strcmp(node->name, "gamma") == 0 &&
        text_double(text, &gamma) && (gamma == 1.0 || gamma == -1.0 || gamma == 2.2)) {
        if (gamma == 2.2) log_warning_at(log, node->place, "a gamma of 2.2 is read as sRGB's");
        node->tag = XML_BOOLEAN;  // 1: plain numbers; else as the file says
        node->name = "raw";
        return set_attribute(arena, node, "value", gamma == 1.0 ? "true" : "false");
    }
    if (is_element(parent, XML_TEXTURE, "bitmap") && strcmp(node->name, "gamma") == 0) {
        log_error_at(log, node->place, "gamma is '%s', but must be 1, 2.2 or -1", text ? text : "");
        return SATIN_ERROR_INPUT;
    }
    static const struct pair facets[] = {{"phong", "beckmann"}, {"as", "beckmann"}, {NULL, NULL}};
    if (is_element(parent, XML_BSDF, NULL) && strncmp(parent->type, "rough", 5) == 0 &&
        strcmp(node->name, "distribution") == 0 && text && map_name(facets, text) != text) {
        log_warning_at(log, node->place,
                       "the distribution '%s' is read as 'beckmann', whose facets are alike", text);
        return set_attribute(arena, node, "value", "beckmann");
    }
    static const struct pair filters[] = {
        {"trilinear", "bilinear"}, {"ewa", "bilinear"}, {NULL, NULL}};
    if (strcmp(node->name, "filter_type") == 0 && node->tag == XML_STRING)
        return set_attribute(arena, node, "value", map_name(filters, text));
    return SATIN_OK;
}

satin_status load_mitsuba06_respell(struct log log, struct arena *arena, struct xml_node *parent,
                                    struct xml_node *node, bool *keep) {
    *keep = true;
    node->mitsuba06 = true;
    if (load_xml_is_object(node->tag) && node->type) node->type = plugin_name(node);
    // The BRDFs of an OBJ have the names of its materials.
    const bool material =
        is_element(parent, XML_SHAPE, NULL) && (node->tag == XML_BSDF || node->tag == XML_REF);
    if (node->name && !material && !(node->name = snake_case(arena, node->name)))
        return SATIN_ERROR_MEMORY;
    if ((is_element(parent, XML_BSDF, "diffuse") || is_element(parent, XML_BSDF, "roughdiffuse")) &&
        node->name && strcmp(node->name, "diffuse_reflectance") == 0)
        node->name = "reflectance";
    if (node->tag == XML_SPECTRUM && load_xml_get(node, "temperature"))
        return respell_blackbody(arena, node);
    bool value = node->tag >= XML_BOOLEAN && node->tag <= XML_TRANSFORM;
    return parent && value && node->name ? respell_value(log, arena, parent, node, keep) : SATIN_OK;
}

bool load_mitsuba06_dissolves(const struct xml_node *parent, const struct xml_node *node) {
    return is_element(parent, XML_BSDF, "bumpmap") && is_element(node, XML_TEXTURE, "scale");
}
