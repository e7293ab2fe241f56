// SPDX-License-Identifier: Apache-2.0
// Materials of a Wavefront OBJ from the files that it names (mtllib), read as by Mitsuba 0.6: each
// becomes a <bsdf> with its name in the element of the shape. Kd and Ks are sRGB.
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "load/load_mesh.h"
#include "load/load_mesh_text.h"
#include "load/load_plugins_shape.h"
#include "load/load_state.h"

enum { MATERIALS_MAX = 1024, LINE_MAX = 1024 };

// What a file says about a material. Texts are in the arena of the tree; NULL: not given.
struct mtl {
    const char *name, *diffuse, *specular, *exponent, *opacity;   // numbers
    const char *diffuse_map, *specular_map, *opacity_map, *bump;  // files
    int model;                                                    // illum
};

struct mtl_reader {
    struct load_state *loader;
    struct xml_node *shape;
    struct mesh_text text;
    struct log_place place;
    struct mtl current;
    size_t count;
    bool failed;  // for lack of memory
};

// ---- Elements -----------------------------------------------------------------------------------

// Adds an element with these attributes to `parent`; NULL without memory.
static struct xml_node *add_element(struct mtl_reader *reader, struct xml_node *parent,
                                    enum xml_tag tag, const char *type, const char *name,
                                    const char *value) {
    struct arena *arena = &reader->loader->xml.arena;
    struct xml_node *node = arena_alloc(arena, sizeof *node);
    const char **attribute = arena_array(arena, 7, sizeof *attribute);
    reader->failed = reader->failed || !node || !attribute;
    if (reader->failed) return NULL;
    const char *const pair[3][2] = {{"type", type}, {"name", name}, {"value", value}};
    for (int i = 0, n = 0; i < 3; i++) {
        if (!pair[i][1]) continue;
        attribute[n++] = pair[i][0];
        attribute[n++] = pair[i][1];
    }
    *node = (struct xml_node){.tag = tag,
                              .place = reader->place,
                              .type = type,
                              .id = tag == XML_BSDF ? name : NULL,
                              .name = name,
                              .attribute = attribute,
                              .mitsuba06 = true,
                              .encoded = tag == XML_RGB};
    if (parent) load_xml_append(parent, node);
    return node;
}

static void add_map(struct mtl_reader *reader, struct xml_node *parent, const char *name,
                    const char *file, bool raw) {
    struct xml_node *map = add_element(reader, parent, XML_TEXTURE, "bitmap", name, NULL);
    if (!map) return;
    add_element(reader, map, XML_STRING, NULL, "filename", file);
    if (raw) add_element(reader, map, XML_BOOLEAN, NULL, "raw", "true");
}

static void add_reflectance(struct mtl_reader *reader, struct xml_node *parent, const char *name,
                            const char *color, const char *map) {
    if (map)
        add_map(reader, parent, name, map, false);
    else
        add_element(reader, parent, XML_RGB, NULL, name, color ? color : "0 0 0");
}

static bool is_zero(const char *numbers) {
    return !numbers || strspn(numbers, "0. \t") == strlen(numbers);
}

// The BRDF of the material itself, without its mask and its bumps.
static void add_plain(struct mtl_reader *reader, struct xml_node *parent, const char *name) {
    const struct mtl *m = &reader->current;
    const bool shiny =
        m->model == 2 && !(is_zero(m->specular) && !m->specular_map) && !is_zero(m->exponent);
    const bool metal = m->model == 5 || m->model == 8,
               glass = m->model == 4 || m->model == 6 || m->model == 7 || m->model == 9;
    const char *type = shiny ? "phong" : metal ? "conductor" : glass ? "dielectric" : "diffuse";
    struct xml_node *brdf = add_element(reader, parent, XML_BSDF, type, name, NULL);
    if (!brdf || glass) return;
    if (metal) {
        add_element(reader, brdf, XML_STRING, NULL, "material", "Al");
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
    if (!m->name || reader->count == MATERIALS_MAX || has_material(reader, m->name)) return;
    reader->count++;
    struct xml_node *parent = reader->shape;
    const char *name = m->name;
    const bool mask = m->opacity_map || (m->opacity && strtof(m->opacity, NULL) != 1.0f);
    if (mask) {
        parent = add_element(reader, parent, XML_BSDF, "mask", name, NULL);
        if (parent && m->opacity_map)
            add_map(reader, parent, "opacity", m->opacity_map, false);
        else if (parent)
            add_element(reader, parent, XML_FLOAT, NULL, "opacity", m->opacity);
        name = NULL;
    }
    if (parent && m->bump) {
        parent = add_element(reader, parent, XML_BSDF, "bumpmap", name, NULL);
        if (parent) add_map(reader, parent, NULL, m->bump, true);
        name = NULL;
    }
    if (parent) add_plain(reader, parent, name);
}

// ---- Files --------------------------------------------------------------------------------------

// The rest of the line without blanks at its ends, in the arena of the tree. NULL if it is empty.
static const char *rest_of_line(struct mtl_reader *reader) {
    load_mesh_text_skip_blanks(&reader->text);
    const char *begin = reader->text.at, *end = begin;
    while (end < reader->text.end && *end != '\n' && end - begin < LINE_MAX) end++;
    while (end > begin && strchr(" \t\r", end[-1])) end--;
    if (end == begin) return NULL;
    const char *text = arena_text(&reader->loader->xml.arena, begin, (size_t)(end - begin));
    reader->failed = reader->failed || !text;
    return text;
}

static void read_mtl_line(struct mtl_reader *reader) {
    struct mtl *m = &reader->current;
    const struct {
        const char *key;
        const char **to;
    } keys[] = {{"Kd", &m->diffuse},         {"Ks", &m->specular},
                {"Ns", &m->exponent},        {"d", &m->opacity},
                {"map_Kd", &m->diffuse_map}, {"map_Ks", &m->specular_map},
                {"map_d", &m->opacity_map},  {"bump", &m->bump}};
    const char *word;
    load_mesh_text_skip_blanks(&reader->text);
    const size_t length = load_mesh_text_word(&reader->text, &word);
    reader->place.line = reader->text.line;
    if (load_mesh_text_is(word, length, "newmtl")) {
        finish_mtl(reader);
        *m = (struct mtl){.name = rest_of_line(reader)};
    } else if (load_mesh_text_is(word, length, "illum")) {
        const char *model = rest_of_line(reader);
        m->model = model ? (int)strtol(model, NULL, 10) : 0;
    }
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (load_mesh_text_is(word, length, keys[i].key)) *keys[i].to = rest_of_line(reader);
}

// Reads a file of materials. One that is missing is a warning.
static satin_status read_mtl(struct load_state *loader, struct xml_node *shape,
                             const struct load_source *obj, const char *name) {
    const struct log_place beside = {obj->path, 0, 0};
    char *path = load_xml_resolve(&loader->xml, beside, name);
    if (!path) return load_no_memory(loader);
    const char *file = arena_text(&loader->xml.arena, path, strlen(path));
    free(path);
    if (!file || !fileio_files_add(loader->xml.read, file)) return load_no_memory(loader);
    struct log_spared missing = {loader->log, loader->log, "its materials are grey"};
    struct load_source source = *obj;
    source.log = log_spare(&missing);
    source.path = file;
    source.hash = &loader->scene->world;
    char *data;
    size_t size;
    satin_status status = load_source_read(&source, LOAD_XML_MAX, &data, &size);
    if (status == SATIN_ERROR_INPUT) return SATIN_OK;
    if (status != SATIN_OK) return status;
    struct mtl_reader reader = {
        .loader = loader, .shape = shape, .text = {data, data + size, 1}, .place = {file, 1, 0}};
    for (; reader.text.at < reader.text.end && !reader.failed;
         load_mesh_text_next_line(&reader.text))
        read_mtl_line(&reader);
    finish_mtl(&reader);
    free(data);
    return reader.failed ? load_no_memory(loader) : SATIN_OK;
}

satin_status load_mesh_mtl(struct load_state *loader, const struct params *p) {
    struct load_source source;
    satin_status status = load_file_source(loader, load_param(p, "filename"), &source);
    if (status != SATIN_OK) return status;
    char *data;
    size_t size;
    struct load_source quiet = source;
    quiet.log = (struct log){0};
    quiet.hash = NULL;
    // What is wrong with the file is reported when its mesh is read.
    status = load_source_read(&quiet, LOAD_FILE_MAX, &data, &size);
    if (status == SATIN_OK) {
        struct mtl_reader line = {.loader = loader, .text = {data, data + size, 1}};
        for (; line.text.at < line.text.end && status == SATIN_OK;
             load_mesh_text_next_line(&line.text)) {
            const char *word;
            load_mesh_text_skip_blanks(&line.text);
            const size_t length = load_mesh_text_word(&line.text, &word);
            if (!load_mesh_text_is(word, length, "mtllib")) continue;
            const char *name = rest_of_line(&line);
            if (name) status = read_mtl(loader, p->node, &source, name);
        }
        free(data);
    }
    free((char *)source.path);
    return status == SATIN_ERROR_INPUT ? SATIN_OK : status;
}
