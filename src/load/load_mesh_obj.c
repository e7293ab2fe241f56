// SPDX-License-Identifier: Apache-2.0
// Reads Wavefront OBJ: v, vt, vn, f and, if the request names materials, usemtl. Groups and
// everything else are ignored, so that a file is one mesh per material. Polygons become fans of
// triangles. A vertex is a distinct triple of position, texture coordinate and normal, as in
// Mitsuba, so that normals that are computed are not smooth across seams of texture coordinates.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/rng.h"
#include "load/load_mesh.h"
#include "load/load_mesh_text.h"

// Indices of one corner of a face, from 0; -1 is absent.
struct obj_corner {
    int32_t position, uv, normal;
};

struct floats {
    float *value;
    size_t count, capacity;
};

struct obj {
    const struct load_source *source;
    const struct mesh_request *request;
    struct mesh_text text;
    struct floats position, uv, normal;  // as in the file: 3, 2 and 3 per item
    struct obj_corner *corner;           // the vertices of the mesh, in order of first use
    size_t corner_count, corner_capacity;
    uint32_t *index;
    size_t index_count, index_capacity;
    size_t *material;  // of each triangle, if the request has materials: index, or their number
    size_t material_capacity, current_material;
    uint32_t *vertex;  // of each corner in the mesh of a material, from 1; 0: it has none
    uint32_t *slot;  // hash table of corners: vertex + 1, or 0 if empty; its size is a power of two
    size_t slot_count;
};

static void obj_free(struct obj *obj) {
    free(obj->position.value);
    free(obj->uv.value);
    free(obj->normal.value);
    free(obj->corner);
    free(obj->index);
    free(obj->material);
    free(obj->vertex);
    free(obj->slot);
}

static satin_status obj_error(const struct obj *obj, const char *what) {
    return load_mesh_error(obj->source, obj->text.line, "%s", what);
}

static bool line_ended(const struct mesh_text *text) {
    return text->at == text->end || *text->at == '\n' || *text->at == '#';
}

// ---- Vertices -----------------------------------------------------------------------------------

// Reads `least` to `most` numbers of the line. Missing ones are 0.
static satin_status read_obj_item(struct obj *obj, struct floats *items, int least, int most) {
    if (!array_reserve((void **)&items->value, &items->capacity, items->count + (size_t)most,
                       sizeof(float)))
        return load_mesh_no_memory(obj->source);
    for (int i = 0; i < most; i++) {
        double number = 0.0;
        load_mesh_text_skip_blanks(&obj->text);
        if (line_ended(&obj->text) ? i < least : !load_mesh_text_number(&obj->text, &number))
            return obj_error(obj, "expected a number");
        if (!isfinite((float)number)) return obj_error(obj, "a coordinate is not finite");
        items->value[items->count++] = (float)number;
    }
    return SATIN_OK;
}

// ---- Faces --------------------------------------------------------------------------------------

static size_t corner_hash(struct obj_corner c) {
    uint64_t key = ((uint64_t)(uint32_t)c.position << 32) | (uint32_t)c.uv;
    return (size_t)rng_mix(key ^ rng_mix((uint32_t)c.normal));
}

// The slot of the corner in the hash table, or the empty slot where it is to be inserted.
static size_t find_slot(const struct obj *obj, struct obj_corner c) {
    size_t i = corner_hash(c) & (obj->slot_count - 1);
    while (obj->slot[i]) {
        const struct obj_corner *other = &obj->corner[obj->slot[i] - 1];
        if (other->position == c.position && other->uv == c.uv && other->normal == c.normal) break;
        i = (i + 1) & (obj->slot_count - 1);
    }
    return i;
}

static bool grow_slots(struct obj *obj) {
    size_t count = obj->slot_count ? obj->slot_count * 2 : 1024;
    uint32_t *slot = calloc(count, sizeof *slot);
    if (!slot) return false;
    free(obj->slot);
    obj->slot = slot;
    obj->slot_count = count;
    for (size_t i = 0; i < obj->corner_count; i++)
        slot[find_slot(obj, obj->corner[i])] = (uint32_t)i + 1;
    return true;
}

static satin_status corner_vertex(struct obj *obj, struct obj_corner c, uint32_t *vertex) {
    if (obj->corner_count * 2 >= obj->slot_count && !grow_slots(obj))
        return load_mesh_no_memory(obj->source);
    size_t i = find_slot(obj, c);
    if (!obj->slot[i]) {
        if (!array_reserve((void **)&obj->corner, &obj->corner_capacity, obj->corner_count + 1,
                           sizeof *obj->corner))
            return load_mesh_no_memory(obj->source);
        obj->corner[obj->corner_count++] = c;
        obj->slot[i] = (uint32_t)obj->corner_count;
    }
    *vertex = obj->slot[i] - 1;
    return SATIN_OK;
}

// Reads an index, which counts from 1, or backwards from -1.
static satin_status read_index(struct obj *obj, size_t count, const char *what, int32_t *out) {
    int64_t i;
    if (!load_mesh_text_integer(&obj->text, &i))
        return obj_error(obj, "expected the index of a face corner");
    int64_t from_zero = i < 0 ? (int64_t)count + i : i - 1;
    if (from_zero < 0 || from_zero >= (int64_t)count)
        return load_mesh_error(obj->source, obj->text.line,
                               "a face refers to %s %lld, but there are %zu so far", what,
                               (long long)i, count);
    *out = (int32_t)from_zero;
    return SATIN_OK;
}

static bool read_slash(struct mesh_text *text) {
    if (text->at >= text->end || *text->at != '/') return false;
    text->at++;
    return true;
}

// Reads a corner: p, p/t, p//n or p/t/n.
static satin_status read_corner(struct obj *obj, struct obj_corner *out) {
    struct obj_corner c = {-1, -1, -1};
    satin_status status = read_index(obj, obj->position.count / 3, "vertex", &c.position);
    if (status == SATIN_OK && read_slash(&obj->text)) {
        if (obj->text.at < obj->text.end && *obj->text.at != '/')
            status = read_index(obj, obj->uv.count / 2, "texture coordinate", &c.uv);
        if (status == SATIN_OK && read_slash(&obj->text))
            status = read_index(obj, obj->normal.count / 3, "normal", &c.normal);
    }
    *out = c;
    return status;
}

static satin_status add_obj_triangle(struct obj *obj, uint32_t a, uint32_t b, uint32_t c) {
    if (!array_reserve((void **)&obj->index, &obj->index_capacity, obj->index_count + 3,
                       sizeof *obj->index))
        return load_mesh_no_memory(obj->source);
    const size_t triangle = obj->index_count / 3;
    if (obj->request->material_count) {
        if (!array_reserve((void **)&obj->material, &obj->material_capacity, triangle + 1,
                           sizeof *obj->material))
            return load_mesh_no_memory(obj->source);
        obj->material[triangle] = obj->current_material;
    }
    obj->index[obj->index_count++] = a;
    obj->index[obj->index_count++] = b;
    obj->index[obj->index_count++] = c;
    return SATIN_OK;
}

static satin_status read_face(struct obj *obj) {
    uint32_t first = 0, previous = 0, vertex = 0;
    for (size_t n = 0;; n++) {
        load_mesh_text_skip_blanks(&obj->text);
        if (line_ended(&obj->text))
            return n >= 3 ? SATIN_OK : obj_error(obj, "a face needs at least three corners");
        struct obj_corner corner;
        satin_status status = read_corner(obj, &corner);
        if (status == SATIN_OK) status = corner_vertex(obj, corner, &vertex);
        if (status == SATIN_OK && n >= 2) status = add_obj_triangle(obj, first, previous, vertex);
        if (status != SATIN_OK) return status;
        if (n == 0) first = vertex;
        previous = vertex;
    }
}

// ---- The file -----------------------------------------------------------------------------------

// Reads the name of a material, which may have blanks in it, to the end of the line.
static void read_usemtl(struct obj *obj) {
    load_mesh_text_skip_blanks(&obj->text);
    const char *name = obj->text.at, *end = name;
    while (end < obj->text.end && *end != '\n') end++;
    while (end > name && strchr(" \t\r", end[-1])) end--;
    size_t i = 0;
    while (i < obj->request->material_count &&
           !load_mesh_text_is(name, (size_t)(end - name), obj->request->material[i]))
        i++;
    if (i == obj->request->material_count && i > 0 && !obj->request->others)
        log_warning_at(obj->source->log, (struct log_place){obj->source->path, obj->text.line, 0},
                       "there is no material '%.*s': its faces are grey",
                       (int)(end - name < 200 ? end - name : 200), name);
    obj->current_material = i;
}

static satin_status read_obj_lines(struct obj *obj) {
    for (; obj->text.at < obj->text.end; load_mesh_text_next_line(&obj->text)) {
        const char *word;
        load_mesh_text_skip_blanks(&obj->text);
        size_t length = load_mesh_text_word(&obj->text, &word);
        satin_status status = SATIN_OK;
        if (load_mesh_text_is(word, length, "v"))
            status = read_obj_item(obj, &obj->position, 3, 3);
        else if (load_mesh_text_is(word, length, "vt"))
            status = read_obj_item(obj, &obj->uv, 1, 2);
        else if (load_mesh_text_is(word, length, "vn"))
            status = read_obj_item(obj, &obj->normal, 3, 3);
        else if (load_mesh_text_is(word, length, "f"))
            status = read_face(obj);
        else if (load_mesh_text_is(word, length, "usemtl"))
            read_usemtl(obj);
        if (status != SATIN_OK) return status;
    }
    return SATIN_OK;
}

// The triangles of a material, in the order of the file: all, if the request has no materials.
struct obj_selection {
    uint32_t *index;   // 3 vertices per triangle
    uint32_t *corner;  // of each vertex, in order of first use
    size_t index_count, vertex_count;
};

// Divides the triangles by their materials. `first` has the place of the first one of each in
// `triangle`, and their number at its end.
static void order_triangles(const struct obj *obj, size_t *first, uint32_t *triangle) {
    const size_t count = obj->index_count / 3, meshes = obj->request->material_count + 1;
    for (size_t i = 0; i < count; i++) first[obj->material ? obj->material[i] : 0]++;
    for (size_t m = meshes, end = count; m-- > 0; first[m] = end) end -= first[m];
    first[meshes] = count;
    for (size_t i = 0; i < count; i++)
        triangle[first[obj->material ? obj->material[i] : 0]++] = (uint32_t)i;
    for (size_t m = meshes; m-- > 1;) first[m] = first[m - 1];
    first[0] = 0;
}

static bool select_triangles(const struct obj *obj, const uint32_t *triangle, size_t count,
                             struct obj_selection *out) {
    out->index = malloc(3 * count * sizeof *out->index);
    out->corner = malloc(3 * count * sizeof *out->corner);
    if (!out->index || !out->corner) return false;
    for (size_t i = 0; i < 3 * count; i++) {
        const uint32_t corner = obj->index[3 * (size_t)triangle[i / 3] + i % 3];
        if (!obj->vertex[corner]) {
            out->corner[out->vertex_count++] = corner;
            obj->vertex[corner] = (uint32_t)out->vertex_count;
        }
        out->index[out->index_count++] = obj->vertex[corner] - 1;
    }
    for (size_t i = 0; i < out->vertex_count; i++) obj->vertex[out->corner[i]] = 0;
    return true;
}

static satin_status assemble_obj(const struct obj *obj, const struct obj_selection *selection,
                                 struct raw_mesh *out) {
    bool normals = false, uvs = false;
    for (size_t i = 0; i < selection->vertex_count; i++) {
        normals = normals || obj->corner[selection->corner[i]].normal >= 0;
        uvs = uvs || obj->corner[selection->corner[i]].uv >= 0;
    }
    satin_status status =
        load_mesh_allocate(obj->source, (uint32_t)selection->vertex_count, normals, uvs, out);
    if (status != SATIN_OK) return status;
    for (size_t i = 0; i < selection->vertex_count; i++) {
        const struct obj_corner c = obj->corner[selection->corner[i]];
        memcpy(out->position + i * 3, obj->position.value + (size_t)c.position * 3,
               3 * sizeof(float));
        if (c.uv >= 0) memcpy(out->uv + i * 2, obj->uv.value + (size_t)c.uv * 2, 2 * sizeof(float));
        if (c.normal >= 0)
            memcpy(out->normal + i * 3, obj->normal.value + (size_t)c.normal * 3,
                   3 * sizeof(float));
    }
    out->triangle_count = (uint32_t)(selection->index_count / 3);
    out->index = arena_array(obj->source->arena, selection->index_count, sizeof(uint32_t));
    if (!out->index) return load_mesh_no_memory(obj->source);
    memcpy(out->index, selection->index, selection->index_count * sizeof(uint32_t));
    return SATIN_OK;
}

// Makes the mesh of some triangles.
static satin_status finish_obj_mesh(const struct obj *obj, const uint32_t *triangle, size_t count,
                                    struct mesh *out) {
    struct obj_selection selection = {0};
    struct raw_mesh raw;
    satin_status status = select_triangles(obj, triangle, count, &selection)
                              ? assemble_obj(obj, &selection, &raw)
                              : load_mesh_no_memory(obj->source);
    free(selection.index);
    free(selection.corner);
    return status == SATIN_OK ? load_mesh_finish(obj->source, obj->request, &raw, out) : status;
}

// Makes the mesh of each material.
static satin_status finish_obj(struct obj *obj, struct mesh *out) {
    const size_t meshes = obj->request->material_count + 1;
    size_t *first = calloc(meshes + 1, sizeof *first);
    uint32_t *triangle = malloc(obj->index_count / 3 * sizeof *triangle);
    obj->vertex = calloc(obj->corner_count, sizeof *obj->vertex);
    satin_status status = SATIN_OK;
    if (first && triangle && obj->vertex)
        order_triangles(obj, first, triangle);
    else
        status = load_mesh_no_memory(obj->source);
    for (size_t m = 0; m < meshes && status == SATIN_OK; m++) {
        out[m] = (struct mesh){0};
        const size_t count = first[m + 1] - first[m];
        if (count) status = finish_obj_mesh(obj, triangle + first[m], count, &out[m]);
    }
    free(first);
    free(triangle);
    return status;
}

satin_status load_mesh_obj(const struct load_source *source, const struct mesh_request *request,
                           struct mesh *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct obj obj = {.source = source,
                      .request = request,
                      .text = {data, data + size, 1},
                      .current_material = request->material_count};
    status = read_obj_lines(&obj);
    if (status == SATIN_OK && obj.index_count == 0)
        status = load_mesh_error(source, 0, "there is no face in it");
    if (status == SATIN_OK) status = finish_obj(&obj, out);
    obj_free(&obj);
    free(data);
    return status;
}
