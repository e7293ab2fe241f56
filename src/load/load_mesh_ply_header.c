// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: lines of `element NAME COUNT` and, below each, `property TYPE NAME` or
// `property list COUNT_TYPE TYPE NAME`, after `ply` and `format`, ended by `end_header`.
#include "load/load_mesh_ply_header.h"

#include <string.h>

size_t load_ply_type_size(enum ply_type type) {
    static const size_t size[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
    return size[type];
}

// One line of the header, split into words.
struct words {
    const char *word[6];
    size_t length[6];
    int count;
};

static bool word_is(const struct words *words, int i, const char *name) {
    return i < words->count && load_mesh_text_is(words->word[i], words->length[i], name);
}

// Splits the line at the cursor into words and advances to the next line.
static struct words read_line(struct mesh_text *text) {
    struct words words = {.count = 0};
    const char *end = memchr(text->at, '\n', (size_t)(text->end - text->at));
    struct mesh_text line = {text->at, end ? end : text->end, text->line};
    for (; words.count < 6; words.count++) {
        load_mesh_text_skip_blanks(&line);
        words.length[words.count] = load_mesh_text_word(&line, &words.word[words.count]);
        if (!words.length[words.count]) break;
    }
    load_mesh_text_next_line(text);
    return words;
}

static enum ply_type read_type(const struct words *words, int i) {
    static const struct {
        const char *name;
        enum ply_type type;
    } names[] = {
        {"char", PLY_INT8},      {"int8", PLY_INT8},     {"uchar", PLY_UINT8},
        {"uint8", PLY_UINT8},    {"short", PLY_INT16},   {"int16", PLY_INT16},
        {"ushort", PLY_UINT16},  {"uint16", PLY_UINT16}, {"int", PLY_INT32},
        {"int32", PLY_INT32},    {"uint", PLY_UINT32},   {"uint32", PLY_UINT32},
        {"float", PLY_FLOAT},    {"float32", PLY_FLOAT}, {"double", PLY_DOUBLE},
        {"float64", PLY_DOUBLE},
    };
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (word_is(words, i, names[k].name)) return names[k].type;
    return PLY_NONE;
}

static enum ply_role vertex_role(const struct words *words) {
    static const struct {
        const char *name;
        enum ply_role role;
    } names[] = {
        {"x", PLY_X},         {"y", PLY_Y},         {"z", PLY_Z},         {"nx", PLY_NX},
        {"ny", PLY_NY},       {"nz", PLY_NZ},       {"u", PLY_U},         {"v", PLY_V},
        {"s", PLY_U},         {"t", PLY_V},         {"texture_u", PLY_U}, {"texture_v", PLY_V},
        {"texture_s", PLY_U}, {"texture_t", PLY_V},
    };
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (word_is(words, words->count - 1, names[k].name)) return names[k].role;
    return PLY_OTHER;
}

static satin_status ply_header_error(const struct load_source *source, const struct mesh_text *text,
                                     const char *what) {
    return load_mesh_error(source, text->line - 1, "%s", what);  // the cursor is after the line
}

static satin_status read_element(const struct load_source *source, struct mesh_text *text,
                                 const struct words *words, struct ply_header *header) {
    if (header->element_count == PLY_ELEMENTS_MAX)
        return ply_header_error(source, text, "too many elements");
    struct ply_element element = {.kind = PLY_SKIPPED, .first = header->property_count};
    struct mesh_text number = {words->word[2], text->end, 0};
    int64_t count = -1;
    if (words->count != 3 || !load_mesh_text_integer(&number, &count) || count < 0 ||
        number.at != words->word[2] + words->length[2])
        return ply_header_error(source, text, "expected: element NAME COUNT");
    element.count = (uint64_t)count;
    if (word_is(words, 1, "vertex")) {
        element.kind = PLY_VERTICES;
        header->vertex_count = element.count;
    } else if (word_is(words, 1, "face")) {
        element.kind = PLY_FACES;
        header->face_count = element.count;
    }
    for (int i = 0; i < header->element_count; i++)
        if (element.kind != PLY_SKIPPED && header->element[i].kind == element.kind)
            return ply_header_error(source, text, "this element was declared before");
    header->element[header->element_count++] = element;
    return SATIN_OK;
}

static satin_status read_property(const struct load_source *source, struct mesh_text *text,
                                  const struct words *words, struct ply_header *header) {
    if (!header->element_count)
        return ply_header_error(source, text, "a property before the first element");
    if (header->property_count == PLY_PROPERTIES_MAX)
        return ply_header_error(source, text, "too many properties");
    struct ply_element *element = &header->element[header->element_count - 1];
    bool list = word_is(words, 1, "list");
    int last = list ? 4 : 2;
    struct ply_property property = {
        .role = PLY_OTHER, .name = words->word[last], .length = words->length[last]};
    property.count_type = list ? read_type(words, 2) : PLY_NONE;
    property.type = read_type(words, list ? 3 : 1);
    if (words->count != last + 1)
        return ply_header_error(source, text, "expected: property [list COUNT_TYPE] TYPE NAME");
    if (!property.type || (list && (!property.count_type || property.count_type >= PLY_FLOAT)))
        return ply_header_error(source, text, "unknown type of a property");
    if (element->kind == PLY_VERTICES && !list) property.role = vertex_role(words);
    if (element->kind == PLY_FACES && list &&
        (word_is(words, 4, "vertex_indices") || word_is(words, 4, "vertex_index")))
        property.role = PLY_CORNERS;
    if (property.role < PLY_VERTEX_ROLES) header->has[property.role] = true;
    header->property[header->property_count++] = property;
    element->properties++;
    return SATIN_OK;
}

// The least number of bytes of one item of the element: in text, a digit and a blank per number.
static uint64_t least_bytes(const struct ply_header *header, const struct ply_element *element) {
    uint64_t bytes = 0;
    for (int i = element->first; i < element->first + element->properties; i++) {
        const struct ply_property *p = &header->property[i];
        bytes += header->text ? 2 : load_ply_type_size(p->count_type ? p->count_type : p->type);
    }
    return bytes;
}

static satin_status check_header(const struct load_source *source, const struct mesh_text *text,
                                 const struct ply_header *header) {
    if (!header->vertex_count || !header->has[PLY_X] || !header->has[PLY_Y] || !header->has[PLY_Z])
        return load_mesh_error(source, 0, "there is no vertex with x, y and z in it");
    bool corners = false;
    for (int i = 0; i < header->property_count; i++)
        corners = corners || header->property[i].role == PLY_CORNERS;
    if (!corners || !header->face_count)
        return load_mesh_error(source, 0, "there is no face with a list of vertices in it");
    uint64_t left = (uint64_t)(text->end - text->at) + 1;  // 1 more, as the last number may end the
                                                           // file
    for (int i = 0; i < header->element_count; i++) {
        const struct ply_element *element = &header->element[i];
        uint64_t least = least_bytes(header, element);
        if (!least) continue;
        if (element->count > left / least)
            return load_mesh_error(source, 0, "%llu items are declared, but the file is too short",
                                   (unsigned long long)element->count);
        left -= element->count * least;
    }
    return SATIN_OK;
}

satin_status load_ply_header_read(const struct load_source *source, struct mesh_text *text,
                                  struct ply_header *out) {
    struct ply_header header = {0};
    struct words words = read_line(text);
    if (words.count != 1 || !word_is(&words, 0, "ply"))
        return load_mesh_error(source, 0, "it is not a PLY file: its first line is not 'ply'");
    bool format = false;
    for (;;) {
        if (text->at == text->end)
            return load_mesh_error(source, 0, "its header has no end_header");
        words = read_line(text);
        satin_status status = SATIN_OK;
        if (word_is(&words, 0, "end_header")) break;
        if (word_is(&words, 0, "format")) {
            header.text = word_is(&words, 1, "ascii");
            header.big_endian = word_is(&words, 1, "binary_big_endian");
            format = header.text || header.big_endian || word_is(&words, 1, "binary_little_endian");
            if (!format || !word_is(&words, 2, "1.0"))
                status = ply_header_error(source, text, "unknown format");
        } else if (word_is(&words, 0, "element")) {
            status = read_element(source, text, &words, &header);
        } else if (word_is(&words, 0, "property")) {
            status = read_property(source, text, &words, &header);
        } else if (words.count && !word_is(&words, 0, "comment") &&
                   !word_is(&words, 0, "obj_info")) {
            status = ply_header_error(source, text, "unknown word in the header");
        }
        if (status != SATIN_OK) return status;
    }
    if (!format) return load_mesh_error(source, 0, "its header names no format");
    satin_status status = check_header(source, text, &header);
    if (status == SATIN_OK) *out = header;
    return status;
}
