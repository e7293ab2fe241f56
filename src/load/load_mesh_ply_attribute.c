// SPDX-License-Identifier: Apache-2.0
// Attributes in PLY files, with the names of Mitsuba 3.9 (measured): `color` is r, g, b (or red,
// green, blue). Any other attribute is a run of 1 or 3 properties: PREFIX_x, _y, _z, or _0, _1, _2,
// or _1, _2, _3 with the name PREFIX, or PREFIX_r, _g, _b with the name PREFIX_color. The name is
// preceded by vertex_ or face_. Bytes have their value as it is; other integers are fractions of
// their largest value, in sRGB. LOAD_VERTEX_COLORS are the same colours, or diffuse_red,
// diffuse_green, diffuse_blue, with the values of Mitsuba 0.6.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "load/load_mesh_ply_header.h"

// ---- Names --------------------------------------------------------------------------------------

static bool is_ply_property(const struct ply_property *property, const char *name) {
    return !property->count_type && load_mesh_text_is(property->name, property->length, name);
}

static int find_ply_property(const struct ply_header *header, const struct ply_element *element,
                             const char *name) {
    for (int k = element->first; k < element->first + element->properties; k++)
        if (is_ply_property(&header->property[k], name)) return k;
    return -1;
}

// Finds the colours by the first `forms` names.
static int find_color(const struct ply_header *header, const struct ply_element *element, int forms,
                      int property[3]) {
    static const char *const name[3][3] = {{"r", "g", "b"},
                                           {"red", "green", "blue"},
                                           {"diffuse_red", "diffuse_green", "diffuse_blue"}};
    for (int form = 0; form < forms; form++) {
        int found = 0;
        for (int c = 0; c < 3; c++) {
            property[c] = find_ply_property(header, element, name[form][c]);
            found += property[c] >= 0;
        }
        if (found == 3) return 3;
    }
    return 0;
}

// The last letter of a property PREFIX_?; 0 if it has another form.
static char ending(const struct ply_property *property, const char *prefix, size_t length) {
    if (property->count_type || property->role != PLY_OTHER || property->length != length + 2 ||
        memcmp(property->name, prefix, length) != 0 || property->name[length] != '_')
        return 0;
    return property->name[length + 1];
}

static int find_run(const struct ply_header *header, const struct ply_element *element,
                    const char *name, int property[3]) {
    static const char *const order[] = {"xyzw", "0123", "1234", "rgba"};
    static const char color[] = "_color";
    size_t length = strlen(name), tail = sizeof color - 1;
    bool colored = length > tail && strcmp(name + length - tail, color) == 0;
    if (colored) length -= tail;
    int k = element->first, end = k + element->properties;
    while (k < end && !ending(&header->property[k], name, length)) k++;
    if (k == end) return 0;
    char first = ending(&header->property[k], name, length);
    for (int form = colored ? 3 : 0; form < (colored ? 4 : 3); form++) {
        if (order[form][0] != first) continue;
        int count = 0;
        for (; k + count < end && count < 4; count++)
            if (ending(&header->property[k + count], name, length) != order[form][count]) break;
        for (int c = 0; c < count && c < 3; c++) property[c] = k + c;
        return count == 2 ? 0 : count > 3 ? 3 : count;
    }
    return 0;
}

static bool find_ply_attribute(const struct ply_header *header, struct ply_attribute *out) {
    const char *rest = out->fractions ? "color" : strchr(out->name, '_') + 1;
    out->per_face = out->name[0] == 'f';
    for (int e = 0; e < header->element_count; e++) {
        const struct ply_element *element = &header->element[e];
        if (element->kind != (out->per_face ? PLY_FACES : PLY_VERTICES)) continue;
        out->channels = strcmp(rest, "color") == 0
                            ? find_color(header, element, out->fractions ? 3 : 2, out->property)
                            : find_run(header, element, rest, out->property);
    }
    return out->channels > 0;
}

satin_status load_ply_attributes_find(const struct load_source *source,
                                      const struct mesh_request *request, struct ply_header *header,
                                      struct ply_attributes *out) {
    for (int i = 0; i < request->attributes.count; i++) {
        struct ply_attribute *a = &out->attribute[out->count];
        const char *name = request->attributes.name[i];
        const bool old = strcmp(name, LOAD_VERTEX_COLORS) == 0;
        *a = (struct ply_attribute){
            .name = name, .fractions = old, .srgb = old && !request->linear_colors};
        // A property belongs to one attribute: the same colours by the rules of both versions are
        // not read twice.
        if (!find_ply_attribute(header, a) || header->property[a->property[0]].target) continue;
        for (int c = 0; c < a->channels; c++)
            header->property[a->property[c]].target = 1 + 3 * out->count + c;
        out->count++;
        if (a->per_face) continue;
        a->value = arena_array(source->arena, header->vertex_count * (size_t)a->channels,
                               sizeof *a->value);
        if (!a->value) return load_mesh_no_memory(source);
    }
    return SATIN_OK;
}

// ---- Values -------------------------------------------------------------------------------------

float load_ply_attribute_decode(const struct ply_attribute *attribute, enum ply_type type,
                                double number) {
    static const double largest[] = {
        [PLY_INT8] = 127.0,         [PLY_INT16] = 32767.0,       [PLY_UINT16] = 65535.0,
        [PLY_INT32] = 2147483647.0, [PLY_UINT32] = 4294967295.0, [PLY_DOUBLE] = 0.0};
    const double most = attribute->fractions && type == PLY_UINT8 ? 255.0 : largest[type];
    const float value = (float)(most > 0.0 ? number / most : number);
    const bool srgb = attribute->fractions ? attribute->srgb : most > 0.0;
    return srgb ? load_srgb_to_linear(value) : value;
}

void load_ply_attributes_vertex(struct ply_attributes *attributes, uint64_t vertex) {
    for (int i = 0; i < attributes->count; i++) {
        const struct ply_attribute *a = &attributes->attribute[i];
        size_t n = (size_t)a->channels;
        if (!a->per_face)
            memcpy(a->value + vertex * n, attributes->read + 3 * i, n * sizeof *a->value);
    }
}

bool load_ply_attributes_face(struct ply_attributes *attributes, size_t triangles) {
    for (int i = 0; i < attributes->count; i++) {
        struct ply_attribute *a = &attributes->attribute[i];
        size_t n = (size_t)a->channels;
        if (!a->per_face) continue;
        void *items = a->value;
        if (!array_reserve(&items, &a->capacity, triangles * n, sizeof *a->value)) return false;
        a->value = items;
        for (; a->count < triangles * n; a->count += n)
            memcpy(a->value + a->count, attributes->read + 3 * i, n * sizeof *a->value);
    }
    return true;
}

satin_status load_ply_attributes_keep(const struct load_source *source,
                                      const struct ply_attributes *attributes,
                                      struct raw_mesh *raw) {
    if (!attributes->count) return SATIN_OK;
    struct mesh_attribute *kept =
        arena_array(source->arena, (size_t)attributes->count, sizeof *kept);
    if (!kept) return load_mesh_no_memory(source);
    for (int i = 0; i < attributes->count; i++) {
        const struct ply_attribute *a = &attributes->attribute[i];
        float *value = a->value;
        size_t count = a->per_face ? a->count : (size_t)raw->vertex_count * (size_t)a->channels;
        load_mesh_attribute_check(source, a->name, value, count);
        if (a->per_face) {
            value = arena_array(source->arena, a->count, sizeof *value);
            if (!value) return load_mesh_no_memory(source);
            memcpy(value, a->value, a->count * sizeof *value);
        }
        kept[i] = (struct mesh_attribute){a->name, a->per_face, a->channels, value};
    }
    raw->attribute = kept;
    raw->attribute_count = attributes->count;
    return SATIN_OK;
}

void load_ply_attributes_free(struct ply_attributes *attributes) {
    for (int i = 0; i < attributes->count; i++)
        if (attributes->attribute[i].per_face) free(attributes->attribute[i].value);
}
