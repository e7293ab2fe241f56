// SPDX-License-Identifier: Apache-2.0
// Private to load/: functions that all mesh readers use.
#ifndef LOAD_MESH_H
#define LOAD_MESH_H

#include "load/load_build.h"

// A mesh being read, in object space. All arrays are in the source's arena.
struct raw_mesh {
    uint32_t vertex_count, triangle_count;
    float *position;  // 3 per vertex, with 1 float of padding
    float *normal;    // 3 per vertex, any length, zero where the file has none; NULL: no normals
    float *uv;        // 2 per vertex or NULL
    uint32_t *index;  // 3 per triangle
    struct mesh_attribute *attribute;
    int attribute_count;
};

// Logs an error in the whole file, or in `line` of a text file (0: unknown). Returns
// SATIN_ERROR_INPUT.
satin_status load_mesh_error(const struct load_source *source, int line, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
satin_status load_mesh_no_memory(const struct load_source *source);

// Allocates the arrays of a mesh of `vertices` vertices; normal and uv only if requested, index
// never.
satin_status load_mesh_allocate(const struct load_source *source, uint32_t vertices, bool normals,
                                bool uvs, struct raw_mesh *out);

// Sets negative values of an attribute to 0, with a warning, as for images.
void load_mesh_attribute_check(const struct load_source *source, const char *name, float *value,
                               size_t count);

// Computes normals that are smooth across edges below an angle (load_mesh_smooth.c).
satin_status load_mesh_smooth(const struct load_source *source, float degrees,
                              struct raw_mesh *raw);

// Checks the indices, transforms to world space, computes normals, orders vertices and flips
// normals.
satin_status load_mesh_finish(const struct load_source *source, const struct mesh_request *request,
                              struct raw_mesh *raw, struct mesh *out);

#endif
