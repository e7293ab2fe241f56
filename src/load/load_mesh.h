// SPDX-License-Identifier: Apache-2.0
// Private to load/: what is common to the mesh readers.
#ifndef LOAD_MESH_H
#define LOAD_MESH_H

#include "load/load_build.h"

// A mesh being read, in object space. All arrays are in the source's arena.
struct mesh_parts {
    uint32_t vertex_count, triangle_count;
    float *position;  // 3 per vertex, with 1 float of padding
    float *normal;    // 3 per vertex, any length, zero where the file has none; or NULL
    float *uv;        // 2 per vertex or NULL
    uint32_t *index;  // 3 per triangle
    struct mesh_attribute *attribute;
    int attribute_count;
};

// An error that concerns the whole file, or `line` of a text file (0: unknown). SATIN_ERROR_INPUT.
satin_status mesh_error(const struct load_source *source, int line, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
satin_status mesh_no_memory(const struct load_source *source);

// Arrays of a mesh with `vertices` vertices; normal and uv only if asked for, index NULL.
satin_status mesh_allocate(const struct load_source *source, uint32_t vertices, bool normals,
                           bool uvs, struct mesh_parts *out);

// What is below 0 of an attribute's values becomes 0, with a warning, as in images.
void mesh_attribute_check(const struct load_source *source, const char *name, float *value,
                          size_t count);

// Makes normals that are smooth over edges flatter than an angle (load_mesh_smooth.c).
satin_status mesh_smooth(const struct load_source *source, float degrees, struct mesh_parts *parts);

// Checks the indices and transforms into world space; makes normals, winds the triangles, flips.
satin_status mesh_finish(const struct load_source *source, const struct mesh_request *request,
                         struct mesh_parts *parts, struct mesh *out);

#endif
