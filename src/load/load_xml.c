// SPDX-License-Identifier: Apache-2.0
// Reads scene files by expat to a tree of elements. Parameters, includes and aliases take effect in
// the order of reading, as in Mitsuba 3: a <default> is valid for everything after it, even beyond
// the end of its file. Text between elements has no meaning and gives a warning.
#include "load/load_xml.h"

#include <errno.h>
#include <expat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/text.h"
#include "load/load_build.h"
#include "load/load_define.h"
#include "load/load_mitsuba06.h"
#include "load/load_params.h"

// State for reading the main file and its includes.
struct xml_reader {
    struct log log, each;
    bool lenient;
    struct load_xml *xml;
    struct load_defines defines;
    uint64_t *hash;
    satin_status status;  // the first failure, which stops parsing
    int files;
    size_t nodes;
    struct xml_node *open[XML_DEPTH_MAX];  // elements that are not closed yet
    int depth;
    int skipped;  // number of open elements that are not read, below those of `depth`
};

// A file that is being read.
struct file {
    struct xml_reader *reader;
    XML_Parser parser;
    const char *path;
    char *real;                 // canonical path, to detect cycles; NULL if it is unknown
    const struct file *parent;  // the file that includes it
    const char *name;           // of the <include>, for the root element of this file; or NULL
    int base_depth;
    bool mitsuba06;  // whether it has the names of version 0.6
};

static satin_status read_xml_file(struct xml_reader *reader, const struct file *parent,
                                  struct log_place place, const char *path, const char *name);

static struct log_place current_place(const struct file *file) {
    return (struct log_place){file->path, (int)XML_GetCurrentLineNumber(file->parser),
                              (int)XML_GetCurrentColumnNumber(file->parser) + 1};
}

static void stop_parsing(struct file *file, satin_status status) {
    if (status == SATIN_ERROR_MEMORY && file->reader->status == SATIN_OK)
        log_fail(file->reader->log, status, "%s: not enough memory for the scene", file->path);
    file->reader->status = status;
    XML_StopParser(file->parser, XML_FALSE);
}

// Copies the text of an attribute with parameters substituted. Logs failures except lack of memory.
static satin_status copy_text(struct file *file, const char *text, const char **out) {
    struct xml_reader *reader = file->reader;
    struct arena *arena = &reader->xml->arena;
    if (arena->bytes > XML_TREE_BYTES_MAX) {
        log_error_at(reader->log, current_place(file), "the scene file is too large");
        return SATIN_ERROR_INPUT;
    }
    if (!strchr(text, '$')) {
        *out = arena_text(arena, text, strlen(text));
        return *out ? SATIN_OK : SATIN_ERROR_MEMORY;
    }
    const char *problem;
    satin_status status = load_define_expand(&reader->defines, arena, text, out, &problem);
    if (status != SATIN_ERROR_INPUT) return status;
    if (!problem) {
        log_error_at(reader->log, current_place(file), "attribute longer than %d bytes",
                     LOAD_ATTRIBUTE_MAX);
        return status;
    }
    // In a label of version 0.6, as `$film['width']`, the program itself fills it in.
    if (file->mitsuba06 && strchr(text, '[')) {
        *out = arena_text(arena, text, strlen(text));
        return *out ? SATIN_OK : SATIN_ERROR_MEMORY;
    }
    int n = 1 + (int)strspn(problem + 1,
                            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
    log_error_at(reader->log, current_place(file),
                 "undefined parameter '%.*s' (-D %.*s=VALUE defines it)", n, problem, n - 1,
                 problem + 1);
    return status;
}

// Copies the attributes that the element has. Default values of an ATTLIST, which come after them,
// are not copied.
static satin_status copy_attributes(struct file *file, const char **from, struct xml_node *node) {
    const size_t count = (size_t)XML_GetSpecifiedAttributeCount(file->parser);
    const char **copy = arena_array(&file->reader->xml->arena, count + 1, sizeof *copy);
    if (!copy) return SATIN_ERROR_MEMORY;
    node->attribute = copy;
    for (size_t i = 0; i < count; i++) {
        satin_status status = copy_text(file, from[i], &copy[i]);
        if (status != SATIN_OK) return status;
    }
    node->type = load_xml_get(node, "type");
    node->id = load_xml_get(node, "id");
    node->name = load_xml_get(node, "name");
    // Mitsuba's own writer uses <texture> for spectra too.
    if (node->tag == XML_TEXTURE && node->type && load_spectrum_named(node->type))
        node->tag = XML_SPECTRUM;
    return SATIN_OK;
}

// Whether the element may stand in its parent; else logs why not.
static bool check_parent_element(const struct file *file, const struct xml_node *node) {
    const struct xml_reader *reader = file->reader;
    bool root = reader->depth == file->base_depth;
    const char *name = load_xml_tag_name(node->tag);
    if (reader->depth == 0 && node->tag != XML_SCENE) {
        log_error_at(reader->log, node->place, "the root element is <%s>, not <scene>", name);
        return false;
    }
    if (!root && node->tag == XML_SCENE) {
        log_error_at(reader->log, node->place, "<scene> cannot stand inside <%s>",
                     load_xml_tag_name(reader->open[reader->depth - 1]->tag));
        return false;
    }
    if (!load_xml_attributes_valid(reader->log, node, root)) return false;
    if (reader->depth == 0) return true;
    if (root) {
        if (load_xml_is_object(node->tag)) return true;
        log_error_at(reader->log, node->place, "<%s> cannot be the root element", name);
        return false;
    }
    enum xml_tag parent = reader->open[reader->depth - 1]->tag;
    if (load_xml_may_contain(parent, node->tag)) return true;
    log_error_at(reader->log, node->place, "<%s> cannot stand inside <%s>", name,
                 load_xml_tag_name(parent));
    return false;
}

static satin_status take_include(struct file *file, const struct xml_node *node) {
    struct xml_reader *reader = file->reader;
    char *path = load_xml_resolve(reader->xml, node->place, load_xml_get(node, "filename"));
    const char *copy = path ? arena_text(&reader->xml->arena, path, strlen(path)) : NULL;
    free(path);
    if (!copy) return SATIN_ERROR_MEMORY;
    return read_xml_file(reader, file, node->place, copy, node->name);
}

static satin_status take_default(struct file *file, const struct xml_node *node) {
    struct xml_reader *reader = file->reader;
    if (!node->name[0]) {
        log_error_at(reader->log, node->place, "<default> with an empty name");
        return SATIN_ERROR_INPUT;
    }
    if (load_define_add(&reader->defines, node->name, load_xml_get(node, "value"), false))
        return SATIN_OK;
    log_error_at(reader->log, node->place, "more than %d parameters", LOAD_DEFINE_MAX);
    return SATIN_ERROR_INPUT;
}

// Adds an element to the tree, or to the tables of ids and parameters.
static satin_status take_element(struct file *file, struct xml_node *node) {
    struct xml_reader *reader = file->reader;
    struct xml_id id = {node->id, node, NULL, node->place, node->number};
    switch (node->tag) {
        case XML_INCLUDE:
            return take_include(file, node);
        case XML_DEFAULT:
            return take_default(file, node);
        case XML_PATH:
            return load_path_add(reader->xml, reader->log, node);
        case XML_ALIAS:
            id = (struct xml_id){load_xml_get(node, "as"), NULL, node->id, node->place,
                                 node->number};
            return load_ids_add(reader->xml, id);
        default:
            break;
    }
    if (reader->depth == 0)
        reader->xml->root = node;
    else
        load_xml_append(reader->open[reader->depth - 1], node);
    if (load_xml_is_shared(node->tag) && node->id && node->id[0])
        return load_ids_add(reader->xml, id);
    return SATIN_OK;
}

static bool is_mitsuba06(const char **attributes) {
    for (; *attributes; attributes += 2)
        if (strcmp(attributes[0], "version") == 0) return load_xml_version_mitsuba06(attributes[1]);
    return false;
}

// Converts an element of version 0.6 to the names of version 3.
static satin_status respell(struct file *file, struct xml_node *node, bool *keep) {
    struct xml_reader *reader = file->reader;
    struct xml_node *parent = reader->depth ? reader->open[reader->depth - 1] : NULL;
    return load_mitsuba06_respell(reader->log, &reader->xml->arena, parent, node, keep);
}

static satin_status too_deep(const struct file *file) {
    log_error_at(file->reader->log, current_place(file), "elements are nested more than %d deep",
                 XML_DEPTH_MAX);
    return SATIN_ERROR_INPUT;
}

static satin_status open_element(struct file *file, const char *name, const char **attributes) {
    struct xml_reader *reader = file->reader;
    struct log_place place = current_place(file);
    if (reader->depth == XML_DEPTH_MAX) return too_deep(file);
    struct xml_node *node = arena_alloc(&reader->xml->arena, sizeof *node);
    if (!node) return SATIN_ERROR_MEMORY;
    node->place = place;
    node->number = reader->nodes++;
    bool keep = true, root = reader->depth == file->base_depth;
    if (root) file->mitsuba06 = is_mitsuba06(attributes);
    node->mitsuba06 = file->mitsuba06;
    node->encoded = file->mitsuba06 && strcmp(name, "srgb") == 0;
    node->animated = strcmp(name, "animation") == 0;
    if (node->animated) name = "transform";
    node->tag =
        load_xml_tag_find(reader->log, place, file->mitsuba06 ? load_mitsuba06_tag(name) : name);
    if (node->tag == XML_TAG_COUNT) return SATIN_ERROR_INPUT;
    satin_status status = copy_attributes(file, attributes, node);
    if (status != SATIN_OK) return status;
    if (!check_parent_element(file, node)) return SATIN_ERROR_INPUT;
    load_plugin_correct_case(reader->log, node);
    if (node->animated)
        log_warning_at(reader->log, place,
                       "<animation>: motion is not supported; its first key is taken");
    if (file->mitsuba06) status = respell(file, node, &keep);
    const bool included = root && file->parent && node->tag == XML_SCENE;
    struct xml_node *parent = reader->depth ? reader->open[reader->depth - 1] : NULL;
    if (included || (file->mitsuba06 && load_mitsuba06_dissolves(parent, node))) {
        node = parent;  // its children become those of the parent
    } else if (status == SATIN_OK && keep) {
        if (root && file->parent) node->name = file->name;
        status = take_element(file, node);
    }
    if (status == SATIN_OK) reader->open[reader->depth++] = node;
    return status;
}

// Whether an element is a key of an <animation>.
static bool is_key(const struct xml_reader *reader, const char *name) {
    const int top = reader->depth - 1;
    if (top < 1 || !reader->open[top]->animated || reader->open[top - 1] == reader->open[top])
        return false;
    return strcmp(name, "transform") == 0;
}

// The steps of the first key become those of the <animation>; other keys are not read.
static satin_status open_key(struct file *file) {
    struct xml_reader *reader = file->reader;
    struct xml_node *animation = reader->open[reader->depth - 1];
    if (animation->keys++ > 0) {
        reader->skipped++;
        return SATIN_OK;
    }
    if (reader->depth == XML_DEPTH_MAX) return too_deep(file);
    reader->open[reader->depth++] = animation;
    return SATIN_OK;
}

// Whether an element is not read, with all that it contains: a medium or a volume.
static bool skips(const struct file *file, const char *name) {
    const struct xml_reader *reader = file->reader;
    if (reader->skipped > 0) return true;
    const struct xml_node *parent = reader->depth ? reader->open[reader->depth - 1] : NULL;
    return parent && load_xml_tag_spared(parent->tag, name);
}

// Reports the outermost element that is not read. If it has an id, references to it are valid.
static satin_status skip_element(struct file *file, const char *name, const char **attributes) {
    struct xml_reader *reader = file->reader;
    struct arena *arena = &reader->xml->arena;
    struct xml_node *parent = reader->open[reader->depth - 1];
    const bool used = parent->tag != XML_SCENE;
    parent->medium = parent->medium || strcmp(name, "medium") == 0;
    log_warning_at(reader->log, current_place(file), "<%s> is not supported%s", name,
                   used ? ": the image is without it" : "; it is not used");
    while (*attributes && strcmp(attributes[0], "id") != 0) attributes += 2;
    if (!*attributes || !attributes[1][0]) return SATIN_OK;
    struct xml_node *node = arena_alloc(arena, sizeof *node);
    const char *id = arena_text(arena, attributes[1], strlen(attributes[1])),
               *type = arena_text(arena, name, strlen(name));
    if (!node || !id || !type) return SATIN_ERROR_MEMORY;
    *node =
        (struct xml_node){.tag = XML_UNREAD, .place = current_place(file), .type = type, .id = id};
    node->number = reader->nodes++;
    return load_ids_add(reader->xml, (struct xml_id){id, node, NULL, node->place, node->number});
}

static void XMLCALL on_start(void *user, const char *name, const char **attributes) {
    struct file *file = user;
    if (file->reader->status != SATIN_OK) return;
    const bool skipped = skips(file, name);
    satin_status status = SATIN_OK;
    if (!skipped && is_key(file->reader, name))
        status = open_key(file);
    else if (!skipped)
        status = open_element(file, name, attributes);
    else if (file->reader->skipped++ == 0)
        status = skip_element(file, name, attributes);
    if (status != SATIN_OK) stop_parsing(file, status);
}

static void XMLCALL on_end(void *user, const char *name) {
    (void)name;
    struct file *file = user;
    if (file->reader->status != SATIN_OK) return;
    if (file->reader->skipped > 0)
        file->reader->skipped--;
    else
        file->reader->depth--;
}

// Expat splits text at line breaks, and seldom within a line.
static void XMLCALL on_text(void *user, const char *text, int length) {
    struct file *file = user;
    int first = 0;
    while (first < length && strchr(" \t\r\n", text[first])) first++;
    if (first == length || file->reader->status != SATIN_OK || file->reader->skipped > 0) return;
    log_warning_at(file->reader->log, current_place(file), "the text '%.*s' has no meaning here",
                   length - first < 40 ? length - first : 40, text + first);
}

// Declarations in other files, of the document type or of parameter entities, are not read.
static int XMLCALL on_outer_declarations(void *user) {
    const struct file *file = user;
    log_warning_at(
        file->reader->log, current_place(file),
        "declarations in other files are not read; entities that they declare are empty");
    return XML_STATUS_OK;
}

static int XMLCALL on_external_entity(XML_Parser parser, const char *context, const char *base,
                                      const char *system_id, const char *public_id) {
    (void)context, (void)base, (void)public_id;
    struct file *file = XML_GetUserData(parser);
    log_error_at(file->reader->log, current_place(file),
                 "an entity that is the file '%s' is not read; <include> reads files", system_id);
    stop_parsing(file, SATIN_ERROR_INPUT);
    return XML_STATUS_ERROR;
}

static void log_syntax_error(const struct file *file, const char *data, size_t size) {
    const struct xml_reader *reader = file->reader;
    const enum XML_Error error = XML_GetErrorCode(file->parser);
    const XML_Index index = XML_GetCurrentByteIndex(file->parser);
    const bool token = error == XML_ERROR_INVALID_TOKEN && index >= 0 && (size_t)index < size;
    const bool unclosed = (error == XML_ERROR_TAG_MISMATCH || error == XML_ERROR_NO_ELEMENTS) &&
                          reader->depth > file->base_depth && reader->skipped == 0;
    const bool empty = strspn(data, " \t\r\n") == size;
    load_xml_log_syntax(reader->log, current_place(file), empty ? NULL : XML_ErrorString(error),
                        token ? data + index : NULL,
                        unclosed ? reader->open[reader->depth - 1] : NULL);
}

// Expat replaces the entities that the file declares, and limits their growth: to 8 MiB, or to 100
// times the file.
static satin_status parse(struct file *file, const char *data, size_t size) {
    struct xml_reader *reader = file->reader;
    XML_SetUserData(file->parser, file);
    XML_SetElementHandler(file->parser, on_start, on_end);
    XML_SetCharacterDataHandler(file->parser, on_text);
    XML_SetNotStandaloneHandler(file->parser, on_outer_declarations);
    XML_SetExternalEntityRefHandler(file->parser, on_external_entity);
    if (XML_Parse(file->parser, data, (int)size, XML_TRUE) == XML_STATUS_OK) return reader->status;
    if (reader->status != SATIN_OK) return reader->status;
    if (XML_GetErrorCode(file->parser) == XML_ERROR_NO_MEMORY)
        return log_fail(reader->log, SATIN_ERROR_MEMORY, "%s: not enough memory for the scene",
                        file->path);
    log_syntax_error(file, data, size);
    return SATIN_ERROR_INPUT;
}

// Whether the file is not being read already; else logs an error.
static bool check_include(const struct file *file, struct log_place place) {
    struct log log = file->reader->log;
    int depth = 0;
    for (const struct file *f = file->parent; f; f = f->parent) {
        if (f->real && file->real && strcmp(f->real, file->real) == 0) {
            log_error_at(log, place, "'%s' includes itself", file->path);
            return false;
        }
        depth++;
    }
    if (depth <= XML_INCLUDE_DEPTH_MAX && ++file->reader->files <= XML_FILES_MAX) return true;
    log_error_at(log, place, "too many includes (at most %d, %d deep)", XML_FILES_MAX,
                 XML_INCLUDE_DEPTH_MAX);
    return false;
}

static satin_status read_xml_file(struct xml_reader *reader, const struct file *parent,
                                  struct log_place place, const char *path, const char *name) {
    char *data = NULL;
    size_t size = 0;
    const bool spared = parent && reader->lenient;
    struct log_spared missing = {reader->log, reader->each, "it is left out"};
    struct log log = spared ? log_spare(&missing) : reader->log;
    satin_status status = !parent && reader->xml->stream
                              ? fileio_read_stream(log, place, path, LOAD_XML_MAX, &data, &size)
                              : fileio_read(log, place, path, LOAD_XML_MAX, &data, &size);
    if (status == SATIN_ERROR_INPUT && spared) return SATIN_OK;
    if (status != SATIN_OK) return reader->status = status;
    if (!fileio_files_add(reader->xml->read, path)) {
        free(data);
        return reader->status =
                   log_fail(reader->log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    }
    *reader->hash = fileio_hash(*reader->hash, data, size);
    char *real = realpath(path, NULL);
    const int real_error = errno;
    struct file file = {reader, XML_ParserCreate(NULL), path, real, parent,
                        name,   reader->depth,          false};
    // A file without a name in the file system, such as a pipe, has no canonical path and cannot
    // include itself.
    if (!file.parser || (!file.real && real_error == ENOMEM))
        status = log_fail(reader->log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    else if (!check_include(&file, place))
        status = SATIN_ERROR_INPUT;
    else
        status = load_xml_clean(&data, &size)
                     ? parse(&file, data, size)
                     : log_fail(reader->log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    if (file.parser) XML_ParserFree(file.parser);
    free(file.real);
    free(data);
    return reader->status = status;
}

// A define that nothing uses is probably misspelt.
static satin_status check_defines(const struct xml_reader *reader, const char *path) {
    const struct load_defines *defines = &reader->defines;
    for (int i = 0; i < defines->count; i++) {
        if (!defines->item[i].given || defines->item[i].used) continue;
        struct text_nearest nearest = {.word = defines->item[i].name};
        for (int j = 0; j < defines->count; j++)
            if (!defines->item[j].given) text_nearest_try(&nearest, defines->item[j].name);
        if (nearest.best)
            return log_fail(reader->log, SATIN_ERROR_INPUT,
                            "%s: parameter '%s' is defined but not used (did you mean '%s'?)", path,
                            nearest.word, nearest.best);
        return log_fail(reader->log, SATIN_ERROR_INPUT,
                        "%s: parameter '%s' is defined but not used", path, nearest.word);
    }
    return SATIN_OK;
}

satin_status load_xml_read(struct log log, struct log each, const char *path,
                           const satin_scene_request *request, uint64_t *hash,
                           struct load_xml *out) {
    struct load_xml xml = {.stream = (request->flags & SATIN_SCENE_STREAM) != 0};
    struct xml_reader reader = {.log = log,
                                .each = each,
                                .lenient = (request->flags & SATIN_SCENE_LENIENT) != 0,
                                .xml = &xml,
                                .hash = hash};
    for (size_t i = 0; i < request->define_count; i++) {
        const satin_define *define = &request->defines[i];
        *hash = fileio_hash(*hash, define->name, strlen(define->name) + 1);
        *hash = fileio_hash(*hash, define->value, strlen(define->value) + 1);
        if (!load_define_add(&reader.defines, define->name, define->value, true))
            return log_fail(log, SATIN_ERROR_INPUT, "%s: more than %d parameters", path,
                            LOAD_DEFINE_MAX);
    }
    const char *copy = arena_text(&xml.arena, path, strlen(path));
    satin_status status = SATIN_ERROR_MEMORY;
    xml.path = copy;
    xml.read = arena_alloc(&xml.arena, sizeof *xml.read);
    if (copy && xml.read)
        status = read_xml_file(&reader, NULL, (struct log_place){0}, copy, NULL);
    else
        log_fail(log, status, "%s: not enough memory for the scene", path);
    if (status == SATIN_OK)
        status = load_ids_resolve(&xml, reader.lenient ? each : log, reader.lenient);
    if (status == SATIN_OK) status = check_defines(&reader, path);
    if (status == SATIN_OK)
        *out = xml;
    else
        load_xml_free(&xml);
    return status;
}

void load_xml_free(struct load_xml *xml) {
    if (xml->read) fileio_files_free(xml->read);
    arena_free(&xml->arena);
    free(xml->id);
    *xml = (struct load_xml){0};
}
