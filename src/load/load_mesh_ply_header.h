// SPDX-License-Identifier: Apache-2.0
// Private to load_mesh_ply.c: the declarations in the header of a PLY file, and attributes.
#ifndef LOAD_MESH_PLY_HEADER_H
#define LOAD_MESH_PLY_HEADER_H

#include "load/load_mesh.h"
#include "load/load_mesh_text.h"

enum { PLY_ELEMENTS_MAX = 32, PLY_PROPERTIES_MAX = 512 };

enum ply_type {
    PLY_NONE = 0,
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT,
    PLY_DOUBLE
};

// The meaning of a property.
enum ply_role {
    PLY_X = 0,
    PLY_Y,
    PLY_Z,
    PLY_NX,
    PLY_NY,
    PLY_NZ,
    PLY_U,
    PLY_V,
    PLY_VERTEX_ROLES,
    PLY_CORNERS,  // the list of a face's vertices
    PLY_OTHER     // skipped
};

struct ply_property {
    enum ply_type type;
    enum ply_type count_type;  // type of a list's length; PLY_NONE: a scalar
    enum ply_role role;
    const char *name;  // in the file
    size_t length;
    int target;  // 1 + index in ply_attributes.read; 0: none
};

enum ply_kind { PLY_VERTICES = 0, PLY_FACES, PLY_SKIPPED };

struct ply_element {
    enum ply_kind kind;
    uint64_t count;
    int first, properties;  // range in ply_header.property
};

struct ply_header {
    bool text, big_endian;
    int element_count, property_count;
    struct ply_element element[PLY_ELEMENTS_MAX];
    struct ply_property property[PLY_PROPERTIES_MAX];
    uint64_t vertex_count, face_count;
    bool has[PLY_VERTEX_ROLES];
};

size_t load_ply_type_size(enum ply_type type);

// Reads the header and leaves `text` at the line after end_header. Checks that there are vertices
// with x, y and z and faces with a list of vertices, and that the declared counts fit into the rest
// of the file.
satin_status load_ply_header_read(const struct load_source *source, struct mesh_text *text,
                                  struct ply_header *out);

// Properties that form an attribute of the mesh (load_mesh_ply_attribute.c).
struct ply_attribute {
    const char *name;
    bool per_face;
    bool fractions;  // LOAD_VERTEX_COLORS: integers are fractions of their largest value
    bool srgb;       // all values are sRGB
    int channels, property[3];
    float *value;  // of vertices: in the arena; of triangles: from malloc
    size_t count, capacity;
};

struct ply_attributes {
    int count;
    struct ply_attribute attribute[ATTRIBUTES_MAX];
    float read[3 * ATTRIBUTES_MAX];  // values of the vertex or face that is being read
};

// Finds the attributes that are asked for, marks their properties and allocates their values.
satin_status load_ply_attributes_find(const struct load_source *source,
                                      const struct mesh_request *request, struct ply_header *header,
                                      struct ply_attributes *out);
// The value of a number in the file, for the attribute to which it belongs.
float load_ply_attribute_decode(const struct ply_attribute *attribute, enum ply_type type,
                                double number);
// Store the values that were read for a vertex, and for a face, after which there are `triangles`
// triangles. The second returns false if there is no memory.
void load_ply_attributes_vertex(struct ply_attributes *attributes, uint64_t vertex);
bool load_ply_attributes_face(struct ply_attributes *attributes, size_t triangles);
// Moves the attributes to the arena.
satin_status load_ply_attributes_keep(const struct load_source *source,
                                      const struct ply_attributes *attributes,
                                      struct raw_mesh *raw);
void load_ply_attributes_free(struct ply_attributes *attributes);

#endif
