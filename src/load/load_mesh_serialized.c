// SPDX-License-Identifier: Apache-2.0
// Mitsuba's serialized meshes, versions 3 and 4, little-endian:
//
//   uint16 0x041C, uint16 version    at the start of every mesh
//   then a zlib stream:
//     uint32 flags                   1 normals, 2 uv, 8 colours, 0x2000 double, else float;
//                                    0x10, face normals, does nothing, as in Mitsuba 3
//     text, 0                        the name; version 4 only
//     uint64 vertices, uint64 triangles
//     3 numbers per vertex           positions
//     3 numbers per vertex           normals, if flagged
//     2 numbers per vertex           uv, if flagged
//     3 numbers per vertex           colours, if flagged
//     3 uint32 per triangle          indices
//   at the end of the file: where each mesh starts (uint64, in version 3 uint32), uint32 meshes
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/array.h"
#include "load/load_mesh.h"

enum {
    MESH_MAGIC = 0x041C,
    FLAG_NORMALS = 1,
    FLAG_UV = 2,
    FLAG_COLORS = 8,
    FLAG_DOUBLE = 0x2000,
    NAME_MAX_BYTES = 65536,
    INFLATE_STEP = 1 << 16  // numbers that are inflated at a time
};

struct packed {
    const struct load_source *source;
    const char *color;  // name of the attribute for colours; NULL: colours are not needed
    z_stream stream;
    bool no_memory;  // whether zlib had no memory, which is no error of the file
    unsigned version;
};

// Inflates exactly `size` bytes. False if there are fewer.
static bool inflate_bytes(struct packed *packed, void *data, size_t size) {
    packed->stream.next_out = data;
    packed->stream.avail_out = (uInt)size;
    while (packed->stream.avail_out > 0) {
        int result = inflate(&packed->stream, Z_NO_FLUSH);
        if (result == Z_STREAM_END) break;
        packed->no_memory = result == Z_MEM_ERROR;
        if (result != Z_OK) return false;
    }
    return packed->stream.avail_out == 0;
}

static satin_status inflate_failed(const struct packed *packed) {
    if (packed->no_memory) return load_mesh_no_memory(packed->source);
    return load_mesh_error(packed->source, 0, "its compressed data is cut short or damaged");
}

static uint64_t little_endian(const unsigned char *byte, size_t size) {
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++) value |= (uint64_t)byte[i] << 8 * i;
    return value;
}

static bool inflate_integer(struct packed *packed, size_t size, uint64_t *out) {
    unsigned char byte[8];
    if (!inflate_bytes(packed, byte, size)) return false;
    *out = little_endian(byte, size);
    return true;
}

// Converts a number of `size` bytes (8: double, 4: float or uint32) to 4 bytes.
static uint32_t decode_word(const unsigned char *byte, size_t size) {
    uint64_t bits = little_endian(byte, size);
    if (size == 4) return (uint32_t)bits;
    double d;
    memcpy(&d, &bits, sizeof d);
    float f = (float)d;
    uint32_t word;
    memcpy(&word, &f, sizeof word);
    return word;
}

// Inflates `count` numbers of `size` bytes to a malloc'ed array of 4-byte numbers. The array grows
// with the data, so that a false count takes no memory. If `out` is NULL, the numbers are dropped.
static satin_status inflate_words(struct packed *packed, size_t count, size_t size, void **out) {
    unsigned char *buffer = malloc((size_t)INFLATE_STEP * size);
    uint32_t *word = NULL;
    size_t done = 0, capacity = 0;
    satin_status status = buffer ? SATIN_OK : load_mesh_no_memory(packed->source);
    while (status == SATIN_OK && done < count) {
        size_t n = count - done < INFLATE_STEP ? count - done : INFLATE_STEP;
        if (!inflate_bytes(packed, buffer, n * size)) {
            status = inflate_failed(packed);
        } else if (out && !array_reserve((void **)&word, &capacity, done + n, sizeof *word)) {
            status = load_mesh_no_memory(packed->source);
        } else {
            for (size_t i = 0; out && i < n; i++)
                word[done + i] = decode_word(buffer + i * size, size);
            done += n;
        }
    }
    free(buffer);
    if (status == SATIN_OK && out)
        *out = word;
    else
        free(word);
    return status;
}

static satin_status inflate_floats(struct packed *packed, size_t count, size_t size, float **out) {
    void *words = NULL;
    satin_status status = inflate_words(packed, count, size, &words);
    if (status != SATIN_OK) return status;
    const float *value = words;
    for (size_t i = 0; i < count; i++)
        if (!isfinite(value[i])) {
            free(words);
            return load_mesh_error(packed->source, 0, "a number is not finite");
        }
    *out = words;
    return SATIN_OK;
}

// ---- The mesh -----------------------------------------------------------------------------------

struct packed_header {
    uint64_t flags, vertices, triangles;
};

static satin_status read_packed_header(struct packed *packed, struct packed_header *out) {
    uint64_t flags, vertices, triangles, c = 1;
    bool ok = inflate_integer(packed, 4, &flags);
    for (int i = 0; ok && packed->version == 4 && c; i++)
        ok = i < NAME_MAX_BYTES && inflate_integer(packed, 1, &c);
    ok = ok && inflate_integer(packed, 8, &vertices) && inflate_integer(packed, 8, &triangles);
    if (!ok) return inflate_failed(packed);
    // Deflate compresses by 1032 at most, and a vertex takes at least 12 bytes.
    uint64_t most = (uint64_t)LOAD_FILE_MAX * 1032 / 12;
    if (vertices == 0 || triangles == 0 || vertices > UINT32_MAX || triangles > UINT32_MAX ||
        vertices > most || triangles > most)
        return load_mesh_error(packed->source, 0, "%llu vertices and %llu triangles are not a mesh",
                               (unsigned long long)vertices, (unsigned long long)triangles);
    *out = (struct packed_header){flags, vertices, triangles};
    return SATIN_OK;
}

// The arrays of the file, from malloc.
struct arrays {
    float *position, *normal, *uv, *color;
    void *index;
};

static satin_status read_arrays(struct packed *packed, const struct packed_header *header,
                                struct arrays *out) {
    size_t n = (size_t)header->vertices, size = header->flags & FLAG_DOUBLE ? 8 : 4;
    satin_status status = inflate_floats(packed, n * 3, size, &out->position);
    if (status == SATIN_OK && header->flags & FLAG_NORMALS)
        status = inflate_floats(packed, n * 3, size, &out->normal);
    if (status == SATIN_OK && header->flags & FLAG_UV)
        status = inflate_floats(packed, n * 2, size, &out->uv);
    if (status == SATIN_OK && header->flags & FLAG_COLORS)
        status = packed->color ? inflate_floats(packed, n * 3, size, &out->color)
                               : inflate_words(packed, n * 3, size, NULL);
    if (status == SATIN_OK)
        status = inflate_words(packed, (size_t)header->triangles * 3, 4, &out->index);
    return status;
}

// Stores the colours as an attribute.
static satin_status keep_color(const struct packed *packed, const float *color,
                               struct raw_mesh *raw) {
    size_t n = (size_t)raw->vertex_count * 3;
    struct mesh_attribute *kept = arena_alloc(packed->source->arena, sizeof *kept);
    float *value = arena_array(packed->source->arena, n, sizeof *value);
    if (!kept || !value) return load_mesh_no_memory(packed->source);
    memcpy(value, color, n * sizeof *value);
    load_mesh_attribute_check(packed->source, packed->color, value, n);
    *kept = (struct mesh_attribute){packed->color, false, 3, value};
    raw->attribute = kept;
    raw->attribute_count = 1;
    return SATIN_OK;
}

static satin_status assemble_serialized(const struct packed *packed,
                                        const struct packed_header *header,
                                        const struct arrays *arrays, struct raw_mesh *out) {
    struct raw_mesh raw;
    size_t n = (size_t)header->vertices;
    satin_status status =
        load_mesh_allocate(packed->source, (uint32_t)n, arrays->normal, arrays->uv, &raw);
    if (status != SATIN_OK) return status;
    memcpy(raw.position, arrays->position, n * 3 * sizeof(float));
    if (raw.normal) memcpy(raw.normal, arrays->normal, n * 3 * sizeof(float));
    if (raw.uv) memcpy(raw.uv, arrays->uv, n * 2 * sizeof(float));
    raw.triangle_count = (uint32_t)header->triangles;
    raw.index = arena_array(packed->source->arena, (size_t)header->triangles * 3, sizeof(uint32_t));
    if (!raw.index) return load_mesh_no_memory(packed->source);
    memcpy(raw.index, arrays->index, (size_t)header->triangles * 3 * sizeof(uint32_t));
    *out = raw;
    return arrays->color ? keep_color(packed, arrays->color, out) : SATIN_OK;
}

static satin_status read_packed_mesh(struct packed *packed, struct raw_mesh *out) {
    struct packed_header header = {0};
    satin_status status = read_packed_header(packed, &header);
    if (status != SATIN_OK) return status;
    struct arrays arrays = {0};
    status = read_arrays(packed, &header, &arrays);
    if (status == SATIN_OK) status = assemble_serialized(packed, &header, &arrays, out);
    free(arrays.position);
    free(arrays.normal);
    free(arrays.uv);
    free(arrays.color);
    free(arrays.index);
    return status;
}

// ---- The file -----------------------------------------------------------------------------------

// Finds the offset of mesh `index` in the table at the end of the file.
static satin_status find_mesh(const struct load_source *source, const unsigned char *data,
                              size_t size, unsigned version, int index, size_t *start) {
    *start = 0;
    if (index == 0) return SATIN_OK;
    size_t entry = version == 4 ? 8 : 4;
    uint64_t count = size >= 4 ? little_endian(data + size - 4, 4) : 0;
    if (count > (size - 4) / entry)
        return load_mesh_error(source, 0, "the table at its end is damaged");
    if (index < 0 || (uint64_t)index >= count)
        return load_mesh_error(source, 0, "there is no mesh %d in it, only 0 to %lld", index,
                               (long long)count - 1);
    uint64_t at = little_endian(data + size - 4 - (count - (uint64_t)index) * entry, entry);
    if (at > size) return load_mesh_error(source, 0, "the table at its end is damaged");
    *start = (size_t)at;
    return SATIN_OK;
}

// The version of the mesh that starts at offset `at`; 0 if there is none.
static unsigned version_at(const unsigned char *data, size_t size, size_t at) {
    if (size < 4 || at > size - 4 || little_endian(data + at, 2) != MESH_MAGIC) return 0;
    unsigned version = (unsigned)little_endian(data + at + 2, 2);
    return version == 3 || version == 4 ? version : 0;
}

static satin_status read_serialized_file(const struct load_source *source,
                                         const struct mesh_request *request, unsigned char *data,
                                         size_t size, struct raw_mesh *out) {
    struct packed packed = {.source = source, .version = version_at(data, size, 0)};
    for (int i = 0; i < request->attributes.count; i++)
        if (strcmp(request->attributes.name[i], "vertex_color") == 0 ||
            strcmp(request->attributes.name[i], LOAD_VERTEX_COLORS) == 0)
            packed.color = request->attributes.name[i];
    if (!packed.version)
        return load_mesh_error(source, 0, "it is not a serialized mesh of version 3 or 4");
    size_t start;
    satin_status status =
        find_mesh(source, data, size, packed.version, request->shape_index, &start);
    if (status != SATIN_OK) return status;
    packed.version = version_at(data, size, start);
    if (!packed.version) return load_mesh_error(source, 0, "no mesh starts where its table says");
    if (inflateInit(&packed.stream) != Z_OK) return load_mesh_no_memory(source);
    packed.stream.next_in = data + start + 4;
    packed.stream.avail_in = (uInt)(size - start - 4);
    status = read_packed_mesh(&packed, out);
    inflateEnd(&packed.stream);
    return status;
}

satin_status load_mesh_serialized(const struct load_source *source,
                                  const struct mesh_request *request, struct mesh *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct raw_mesh raw;
    status = read_serialized_file(source, request, (unsigned char *)data, size, &raw);
    free(data);
    return status == SATIN_OK ? load_mesh_finish(source, request, &raw, out) : status;
}
