// SPDX-License-Identifier: Apache-2.0
// Reads PLY, text and binary of both byte orders: positions, normals (nx ny nz) and texture
// coordinates (u v or s t) of the element `vertex`, the polygons of the element `face`, which
// become fans of triangles, and attributes of both. Other elements and properties are ignored. The
// header's reader has checked the counts against the size of the file, so the memory is
// proportional to it.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "load/load_mesh_ply_header.h"

struct ply {
    const struct load_source *source;
    struct mesh_text text;  // the cursor in a binary body too, where its line is not used
    struct ply_header header;
    struct raw_mesh raw;
    uint32_t *index;  // in the arena while all faces are triangles, then from malloc
    size_t index_count, index_capacity;
    bool grown;
    struct ply_attributes attributes;
};

static int line_of(const struct ply *ply) { return ply->header.text ? ply->text.line : 0; }

static satin_status fail_at(const struct ply *ply, const struct ply_element *element, uint64_t item,
                            const char *what) {
    static const char *const name[] = {"vertex", "face", "item"};
    return load_mesh_error(ply->source, line_of(ply), "%s %llu: %s", name[element->kind],
                           (unsigned long long)item, what);
}

// ---- Numbers ------------------------------------------------------------------------------------

static double decode(enum ply_type type, uint64_t bits) {
    float f;
    double d;
    uint32_t word = (uint32_t)bits;
    switch (type) {
        case PLY_INT8:
            return (int8_t)bits;
        case PLY_INT16:
            return (int16_t)bits;
        case PLY_INT32:
            return (int32_t)bits;
        case PLY_FLOAT:
            memcpy(&f, &word, sizeof f);
            return f;
        case PLY_DOUBLE:
            memcpy(&d, &bits, sizeof d);
            return d;
        default:
            return (double)bits;
    }
}

// Reads one number. False at the end of the file or, in text, if there is no number.
static bool read_ply_number(struct ply *ply, enum ply_type type, double *out) {
    if (ply->header.text) {
        load_mesh_text_skip_space(&ply->text);
        return load_mesh_text_number(&ply->text, out);
    }
    size_t size = load_ply_type_size(type);
    if ((size_t)(ply->text.end - ply->text.at) < size) return false;
    const unsigned char *byte = (const unsigned char *)ply->text.at;
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++)
        bits |= (uint64_t)byte[i] << 8 * (ply->header.big_endian ? size - 1 - i : i);
    ply->text.at += size;
    *out = decode(type, bits);
    return true;
}

// Reads the length of a list and checks that the list fits into the rest of the file.
static bool read_length(struct ply *ply, const struct ply_property *property, uint64_t *out) {
    double length;
    if (!read_ply_number(ply, property->count_type, &length)) return false;
    uint64_t left = (uint64_t)(ply->text.end - ply->text.at);
    uint64_t most = ply->header.text ? left : left / load_ply_type_size(property->type);
    if (!(length >= 0.0 && length <= (double)most)) return false;
    *out = (uint64_t)length;
    return (double)*out == length;
}

// Skips a property, or stores it if it belongs to an attribute.
static bool read_other(struct ply *ply, const struct ply_property *property) {
    double number;
    if (property->target) {
        float *value = &ply->attributes.read[property->target - 1];
        if (!read_ply_number(ply, property->type, &number)) return false;
        *value = load_ply_attribute_decode(&ply->attributes.attribute[(property->target - 1) / 3],
                                           property->type, number);
        return isfinite(*value);
    }
    if (!property->count_type) return read_ply_number(ply, property->type, &number);
    uint64_t length;
    if (!read_length(ply, property, &length)) return false;
    if (!ply->header.text) {
        ply->text.at += length * load_ply_type_size(property->type);
        return true;
    }
    for (uint64_t i = 0; i < length; i++)
        if (!read_ply_number(ply, property->type, &number)) return false;
    return true;
}

// ---- Vertices and faces -------------------------------------------------------------------------

static const char cut_short[] = "a number is missing or wrong";

static satin_status read_vertex(struct ply *ply, const struct ply_element *element, uint64_t i) {
    float value[PLY_VERTEX_ROLES] = {0};
    for (int k = element->first; k < element->first + element->properties; k++) {
        const struct ply_property *property = &ply->header.property[k];
        double number;
        if (property->role == PLY_OTHER) {
            if (!read_other(ply, property)) return fail_at(ply, element, i, cut_short);
            continue;
        }
        if (!read_ply_number(ply, property->type, &number))
            return fail_at(ply, element, i, cut_short);
        value[property->role] = (float)number;
        if (!isfinite(value[property->role]))
            return fail_at(ply, element, i, "a coordinate is not finite");
    }
    memcpy(ply->raw.position + i * 3, value + PLY_X, 3 * sizeof(float));
    if (ply->raw.normal) memcpy(ply->raw.normal + i * 3, value + PLY_NX, 3 * sizeof(float));
    if (ply->raw.uv) memcpy(ply->raw.uv + i * 2, value + PLY_U, 2 * sizeof(float));
    load_ply_attributes_vertex(&ply->attributes, i);
    return SATIN_OK;
}

// There are more triangles than faces: moves the indices from the arena to an array that grows.
static bool grow_index(struct ply *ply) {
    void *items = ply->grown ? ply->index : NULL;
    size_t capacity = ply->grown ? ply->index_capacity : 0;
    if (!array_reserve(&items, &capacity, ply->index_count + 3, sizeof *ply->index)) return false;
    if (!ply->grown) memcpy(items, ply->index, ply->index_count * sizeof *ply->index);
    ply->grown = true;
    ply->index = items;
    ply->index_capacity = capacity;
    return true;
}

static bool add_ply_triangle(struct ply *ply, uint32_t a, uint32_t b, uint32_t c) {
    if (ply->index_count + 3 > ply->index_capacity && !grow_index(ply)) return false;
    ply->index[ply->index_count++] = a;
    ply->index[ply->index_count++] = b;
    ply->index[ply->index_count++] = c;
    return true;
}

static satin_status read_corners(struct ply *ply, const struct ply_element *element, uint64_t i,
                                 const struct ply_property *property) {
    uint64_t length;
    if (!read_length(ply, property, &length))
        return fail_at(ply, element, i, "its list of vertices is cut short or too long");
    uint32_t first = 0, previous = 0;
    for (uint64_t k = 0; k < length; k++) {
        double number;
        if (!read_ply_number(ply, property->type, &number))
            return fail_at(ply, element, i, cut_short);
        if (!(number >= 0.0 && number < (double)ply->header.vertex_count))
            return load_mesh_error(
                ply->source, line_of(ply), "face %llu refers to vertex %.0f, but there are %llu",
                (unsigned long long)i, number, (unsigned long long)ply->header.vertex_count);
        uint32_t vertex = (uint32_t)number;
        if (k >= 2 && !add_ply_triangle(ply, first, previous, vertex))
            return load_mesh_no_memory(ply->source);
        if (k == 0) first = vertex;
        previous = vertex;
    }
    return SATIN_OK;
}

static satin_status read_ply_item(struct ply *ply, const struct ply_element *element, uint64_t i) {
    if (element->kind == PLY_VERTICES) return read_vertex(ply, element, i);
    for (int k = element->first; k < element->first + element->properties; k++) {
        const struct ply_property *property = &ply->header.property[k];
        satin_status status = SATIN_OK;
        if (property->role == PLY_CORNERS)
            status = read_corners(ply, element, i, property);
        else if (!read_other(ply, property))
            status = fail_at(ply, element, i, cut_short);
        if (status != SATIN_OK) return status;
    }
    bool ok = element->kind != PLY_FACES ||
              load_ply_attributes_face(&ply->attributes, ply->index_count / 3);
    return ok ? SATIN_OK : load_mesh_no_memory(ply->source);
}

// ---- The file -----------------------------------------------------------------------------------

static satin_status read_body(struct ply *ply) {
    const struct ply_header *header = &ply->header;
    bool normals = header->has[PLY_NX] && header->has[PLY_NY] && header->has[PLY_NZ];
    bool uvs = header->has[PLY_U] && header->has[PLY_V];
    satin_status status =
        load_mesh_allocate(ply->source, (uint32_t)header->vertex_count, normals, uvs, &ply->raw);
    ply->index_capacity = (size_t)header->face_count * 3;
    ply->index = arena_array(ply->source->arena, ply->index_capacity, sizeof *ply->index);
    if (status == SATIN_OK && !ply->index) return load_mesh_no_memory(ply->source);
    for (int e = 0; e < header->element_count && status == SATIN_OK; e++) {
        const struct ply_element *element = &header->element[e];
        // Elements without properties take no bytes, so their count is not checked.
        if (!element->properties) continue;
        for (uint64_t i = 0; i < element->count && status == SATIN_OK; i++)
            status = read_ply_item(ply, element, i);
    }
    if (status != SATIN_OK) return status;
    if (!ply->index_count) return load_mesh_error(ply->source, 0, "no face has three corners");
    if (ply->index_count / 3 > UINT32_MAX)
        return load_mesh_error(ply->source, 0, "there are too many triangles in it");
    ply->raw.triangle_count = (uint32_t)(ply->index_count / 3);
    ply->raw.index = ply->index;
    if (!ply->grown) return SATIN_OK;
    ply->raw.index = arena_array(ply->source->arena, ply->index_count, sizeof(uint32_t));
    if (!ply->raw.index) return load_mesh_no_memory(ply->source);
    memcpy(ply->raw.index, ply->index, ply->index_count * sizeof(uint32_t));
    return SATIN_OK;
}

satin_status load_mesh_ply(const struct load_source *source, const struct mesh_request *request,
                           struct mesh *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct ply ply = {.source = source, .text = {data, data + size, 1}};
    status = load_ply_header_read(source, &ply.text, &ply.header);
    if (status == SATIN_OK)
        status = load_ply_attributes_find(source, request, &ply.header, &ply.attributes);
    if (status == SATIN_OK) status = read_body(&ply);
    if (status == SATIN_OK) status = load_ply_attributes_keep(source, &ply.attributes, &ply.raw);
    load_ply_attributes_free(&ply.attributes);
    if (ply.grown) free(ply.index);
    free(data);
    return status == SATIN_OK ? load_mesh_finish(source, request, &ply.raw, out) : status;
}
