// SPDX-License-Identifier: Apache-2.0
// Materials of a Wavefront OBJ from the files that it names (mtllib), read as by Mitsuba 0.6: each
// becomes a <bsdf> with its name in the element of the shape. Kd and Ks are sRGB.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "base/fileio.h"
#include "load/load_mesh.h"
#include "load/load_mesh_text.h"
#include "load/load_plugins_shape.h"
#include "load/load_state.h"

enum { MATERIALS_MAX = 1024 };  // of one shape

// What a file says, and its line; NULL: nothing. Texts are in the arena of the tree.
struct mtl_text {
    const char *text;
    int line;
};

struct mtl {
    struct mtl_text name, diffuse, specular, exponent, opacity, model;  // the last four: numbers
    struct mtl_text diffuse_map, specular_map, opacity_map, bump;       // files
};

struct mtl_reader {
    struct load_state *loader;
    struct xml_node *shape;
    struct mesh_text text;
    const char *file;
    struct mtl current;
    size_t *count;  // materials of the shape so far
    bool failed;    // for lack of memory
};

// ---- Elements -----------------------------------------------------------------------------------

// Adds an element with these attributes to `parent`; NULL without memory.
static struct xml_node *add_element(struct mtl_reader *reader, struct xml_node *parent,
                                    enum xml_tag tag, const char *type, const char *name,
                                    struct mtl_text value) {
    struct arena *arena = &reader->loader->xml.arena;
    struct xml_node *node = parent ? arena_alloc(arena, sizeof *node) : NULL;
    const char **attribute = arena_array(arena, 7, sizeof *attribute);
    reader->failed = reader->failed || !node || !attribute;
    if (reader->failed) return NULL;
    const char *const pair[3][2] = {{"type", type}, {"name", name}, {"value", value.text}};
    for (int i = 0, n = 0; i < 3; i++) {
        if (!pair[i][1]) continue;
        attribute[n++] = pair[i][0];
        attribute[n++] = pair[i][1];
    }
    *node = (struct xml_node){.tag = tag,
                              .place = {reader->file, value.line, 0},
                              .type = type,
                              .id = tag == XML_BSDF ? name : NULL,
                              .name = name,
                              .attribute = attribute,
                              .mitsuba06 = true,
                              .encoded = tag == XML_RGB};
    load_xml_append(parent, node);
    return node;
}

// An object, at the place of `at`.
static struct xml_node *add_object(struct mtl_reader *reader, struct xml_node *parent,
                                   enum xml_tag tag, const char *type, const char *name,
                                   struct mtl_text at) {
    return add_element(reader, parent, tag, type, name, (struct mtl_text){NULL, at.line});
}

static void add_map(struct mtl_reader *reader, struct xml_node *parent, const char *name,
                    struct mtl_text file, bool raw) {
    struct xml_node *map = add_object(reader, parent, XML_TEXTURE, "bitmap", name, file);
    add_element(reader, map, XML_STRING, NULL, "filename", file);
    if (raw)
        add_element(reader, map, XML_BOOLEAN, NULL, "raw", (struct mtl_text){"true", file.line});
}

static void add_reflectance(struct mtl_reader *reader, struct xml_node *parent, const char *name,
                            struct mtl_text color, struct mtl_text map) {
    if (map.text)
        add_map(reader, parent, name, map, false);
    else
        add_element(reader, parent, XML_RGB, NULL, name,
                    color.text ? color : (struct mtl_text){"0 0 0", reader->current.name.line});
}

static bool is_zero(struct mtl_text numbers) {
    return !numbers.text || strspn(numbers.text, "0. ") == strlen(numbers.text);
}

// The BRDF of the material itself, without its mask and its bumps.
static void add_plain(struct mtl_reader *reader, struct xml_node *parent, const char *name) {
    const struct mtl *m = &reader->current;
    const int model = m->model.text ? (int)strtof(m->model.text, NULL) : 0;
    const bool shiny =
        model == 2 && (!is_zero(m->specular) || m->specular_map.text) && !is_zero(m->exponent);
    const bool metal = model == 5 || model == 8,
               glass = model == 4 || model == 6 || model == 7 || model == 9;
    const char *type = shiny ? "phong" : metal ? "conductor" : glass ? "dielectric" : "diffuse";
    struct xml_node *brdf = add_object(reader, parent, XML_BSDF, type, name, m->name);
    if (!brdf || glass) return;
    if (metal) {
        add_element(reader, brdf, XML_STRING, NULL, "material",
                    (struct mtl_text){"Al", m->model.line});
        return;
    }
    add_reflectance(reader, brdf, shiny ? "diffuse_reflectance" : "reflectance", m->diffuse,
                    m->diffuse_map);
    if (!shiny) return;
    add_reflectance(reader, brdf, "specular_reflectance", m->specular, m->specular_map);
    add_element(reader, brdf, XML_FLOAT, NULL, "exponent", m->exponent);
}

static bool has_material(const struct mtl_reader *reader, const char *name) {
    for (const struct xml_node *child = reader->shape->child; child; child = child->next)
        if (child->tag == XML_BSDF && child->name && strcmp(child->name, name) == 0) return true;
    return false;
}

// Adds the material that was read, if there is one; the first of each name counts.
static void finish_mtl(struct mtl_reader *reader) {
    const struct mtl *m = &reader->current;
    const char *name = m->name.text;
    if (!name || *reader->count == MATERIALS_MAX || has_material(reader, name)) return;
    if (++*reader->count == MATERIALS_MAX)
        log_warning_at(reader->loader->log, (struct log_place){reader->file, m->name.line, 0},
                       "only the first %d materials are read", MATERIALS_MAX);
    struct xml_node *parent = reader->shape;
    if (m->opacity_map.text || (m->opacity.text && strtof(m->opacity.text, NULL) != 1.0f)) {
        parent = add_object(reader, parent, XML_BSDF, "mask", name, m->name);
        if (m->opacity_map.text)
            add_map(reader, parent, "opacity", m->opacity_map, false);
        else
            add_element(reader, parent, XML_FLOAT, NULL, "opacity", m->opacity);
        name = NULL;
    }
    if (m->bump.text) {
        parent = add_object(reader, parent, XML_BSDF, "bumpmap", name, m->name);
        add_map(reader, parent, NULL, m->bump, true);
        name = NULL;
    }
    add_plain(reader, parent, name);
}

// ---- Lines --------------------------------------------------------------------------------------

static struct mtl_text keep_text(struct mtl_reader *reader, const char *text, size_t length) {
    const char *copy = arena_text(&reader->loader->xml.arena, text, length);
    reader->failed = reader->failed || !copy;
    return (struct mtl_text){copy, reader->text.line};
}

// The rest of the line without blanks at its ends; its text is NULL if it is empty.
static struct mtl_text rest_of_line(struct mtl_reader *reader) {
    load_mesh_text_skip_blanks(&reader->text);
    const char *begin = reader->text.at, *end = begin;
    while (end < reader->text.end && *end != '\n') end++;
    while (end > begin && strchr(" \t\r", end[-1])) end--;
    return end > begin ? keep_text(reader, begin, (size_t)(end - begin)) : (struct mtl_text){0};
}

// The file of a map, which follows its options, such as `-s 1 1 1`.
static struct mtl_text read_map(struct mtl_reader *reader) {
    const struct mtl_text all = rest_of_line(reader);
    const char *last = all.text && all.text[0] == '-' ? strpbrk(all.text, " \t") : NULL;
    for (const char *next = last; next; next = strpbrk(next + 1, " \t")) last = next;
    return (struct mtl_text){last ? last + 1 : all.text, all.line};
}

// Up to three numbers, those out of [0, most] at its nearer end. Other words have no meaning.
static struct mtl_text read_mtl_numbers(struct mtl_reader *reader, float most) {
    char text[3 * 24] = "";
    double number, last = 0.0;
    bool clamped = false;
    int n = 0;
    for (; n < 3; n++) {
        load_mesh_text_skip_blanks(&reader->text);
        if (!load_mesh_text_number(&reader->text, &number)) break;
        last = fmin(fmax(number, 0.0), (double)most);  // of NaN 0
        clamped = clamped || !(last == number);
        snprintf(text + strlen(text), 24, "%s%.9g", n ? " " : "", last);
    }
    if (n == 2) snprintf(text + strlen(text), 24, " %.9g", last);
    const struct log_place place = {reader->file, reader->text.line, 0};
    if (clamped)
        log_warning_at(reader->loader->log, place, "a number is not in [0, %g], and counts as %s",
                       (double)most, text);
    if (n) return keep_text(reader, text, strlen(text));
    log_warning_at(reader->loader->log, place, "there is no number in it; it has no effect");
    return (struct mtl_text){0};
}

static bool is_mtl_key(const char *word, size_t length, const char *key) {
    return length == strlen(key) && strncasecmp(word, key, length) == 0;
}

static void read_mtl_line(struct mtl_reader *reader) {
    struct mtl *m = &reader->current;
    const struct {
        const char *key;
        struct mtl_text *to;
        float most;  // of numbers; 0: the file of a map
    } keys[] = {{"Kd", &m->diffuse, 1.0f},          {"Ks", &m->specular, 1.0f},
                {"Ns", &m->exponent, 1e6f},         {"d", &m->opacity, 1.0f},
                {"illum", &m->model, 100.0f},       {"map_Kd", &m->diffuse_map, 0.0f},
                {"map_Ks", &m->specular_map, 0.0f}, {"map_d", &m->opacity_map, 0.0f},
                {"bump", &m->bump, 0.0f},           {"map_bump", &m->bump, 0.0f}};
    const char *word;
    load_mesh_text_skip_blanks(&reader->text);
    const size_t length = load_mesh_text_word(&reader->text, &word);
    if (is_mtl_key(word, length, "newmtl")) {
        finish_mtl(reader);
        *m = (struct mtl){.name = rest_of_line(reader)};
    }
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (is_mtl_key(word, length, keys[i].key))
            *keys[i].to =
                keys[i].most > 0.0f ? read_mtl_numbers(reader, keys[i].most) : read_map(reader);
}

// ---- Files --------------------------------------------------------------------------------------

static struct mesh_text mtl_text_of(const char *data, size_t size) {
    const size_t mark = size >= 3 && memcmp(data, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    return (struct mesh_text){data + mark, data + size, 1};
}

// Reads a file of materials. One that is missing is a warning.
static satin_status read_mtl(struct mtl_reader *reader, const struct load_source *obj,
                             const char *name) {
    struct load_state *loader = reader->loader;
    const struct param_value value = {.s = name, .place = {obj->path, reader->text.line, 0}};
    struct log_spared missing = {loader->log, loader->log, "its materials are grey"};
    struct load_source source;
    satin_status status = load_file_source(loader, &value, &source);
    if (status != SATIN_OK) return status;
    const char *file = load_keep_text(loader, source.path);
    source.log = log_spare(&missing);
    char *data = NULL;
    size_t size;
    status = file ? load_source_read(&source, LOAD_XML_MAX, &data, &size) : load_no_memory(loader);
    free((char *)source.path);
    if (status != SATIN_OK) return status == SATIN_ERROR_INPUT ? SATIN_OK : status;
    const size_t before = *reader->count;
    struct mtl_reader inner = *reader;
    inner.file = file;
    inner.text = mtl_text_of(data, size);
    for (; inner.text.at < inner.text.end && !inner.failed; load_mesh_text_next_line(&inner.text))
        read_mtl_line(&inner);
    finish_mtl(&inner);
    free(data);
    if (*reader->count == before)
        log_warning_at(loader->log, (struct log_place){file, 0, 0}, "there is no material in it");
    return inner.failed ? load_no_memory(loader) : SATIN_OK;
}

// Whether there is a file of that name, relative to the OBJ.
static bool has_file(const struct mtl_reader *reader, const struct load_source *obj,
                     const char *name) {
    char *path = load_xml_resolve(&reader->loader->xml, (struct log_place){obj->path, 0, 0}, name);
    const bool found = path && access(path, F_OK) == 0;
    free(path);
    return found;
}

// Reads the files that an mtllib names: one whose name has blanks, or several.
static satin_status read_libraries(struct mtl_reader *reader, const struct load_source *obj) {
    const struct mtl_text all = rest_of_line(reader);
    if (reader->failed) return load_no_memory(reader->loader);
    if (!all.text || *reader->count == MATERIALS_MAX) return SATIN_OK;
    if (!strpbrk(all.text, " \t") || has_file(reader, obj, all.text))
        return read_mtl(reader, obj, all.text);
    satin_status status = SATIN_OK;
    for (const char *at = all.text; *at && status == SATIN_OK; at += strspn(at, " \t")) {
        const size_t length = strcspn(at, " \t");
        const struct mtl_text name = keep_text(reader, at, length);
        status = name.text ? read_mtl(reader, obj, name.text) : load_no_memory(reader->loader);
        at += length;
    }
    return status;
}

satin_status load_mesh_mtl(struct load_state *loader, const struct params *p) {
    struct load_source source;
    satin_status status = load_file_source(loader, load_param(p, "filename"), &source);
    if (status != SATIN_OK) return status;
    char *data;
    size_t size, count = 0;
    struct load_source quiet = source;
    quiet.log = (struct log){0};
    quiet.hash = NULL;
    // What is wrong with the file is reported when its mesh is read.
    status = load_source_read(&quiet, LOAD_FILE_MAX, &data, &size);
    if (status == SATIN_OK) {
        struct mtl_reader reader = {
            .loader = loader, .shape = p->node, .text = mtl_text_of(data, size), .count = &count};
        for (; reader.text.at < reader.text.end && status == SATIN_OK;
             load_mesh_text_next_line(&reader.text)) {
            const char *word;
            load_mesh_text_skip_blanks(&reader.text);
            const size_t length = load_mesh_text_word(&reader.text, &word);
            if (load_mesh_text_is(word, length, "mtllib"))
                status = read_libraries(&reader, &source);
        }
        free(data);
    }
    free((char *)source.path);
    return status == SATIN_ERROR_INPUT ? SATIN_OK : status;
}
