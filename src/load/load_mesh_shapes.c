// SPDX-License-Identifier: Apache-2.0
// Meshes without a file: the rectangle and the cube, with vertices, triangles and texture
// coordinates as in Mitsuba 3.
#include <string.h>

#include "load/load_mesh.h"

static satin_status make(struct arena *arena, const struct mesh_request *request, uint32_t vertices,
                         const float (*position)[3], const float (*normal)[3], const float (*uv)[2],
                         struct mesh *out) {
    struct load_source source = {.arena = arena, .path = "shape"};
    struct raw_mesh raw;
    satin_status status = load_mesh_allocate(&source, vertices, true, true, &raw);
    if (status != SATIN_OK) return status;
    memcpy(raw.position, position, vertices * sizeof *position);
    memcpy(raw.uv, uv, vertices * sizeof *uv);
    // Every four vertices are a face with one normal, split along its diagonal.
    raw.triangle_count = vertices / 2;
    raw.index = arena_array(arena, (size_t)raw.triangle_count * 3, sizeof(uint32_t));
    if (!raw.index) return SATIN_ERROR_MEMORY;
    static const uint32_t corner[6] = {0, 1, 2, 3, 0, 2};
    for (uint32_t i = 0; i < raw.triangle_count * 3; i++) raw.index[i] = i / 6 * 4 + corner[i % 6];
    for (uint32_t i = 0; i < vertices; i++)
        memcpy(raw.normal + (size_t)i * 3, normal[i / 4], sizeof *normal);
    return load_mesh_finish(&source, request, &raw, out);
}

satin_status load_mesh_rectangle(struct arena *arena, const struct mesh_request *request,
                                 struct mesh *out) {
    static const float position[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    static const float normal[1][3] = {{0, 0, 1}};
    static const float uv[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    return make(arena, request, 4, position, normal, uv, out);
}

satin_status load_mesh_cube(struct arena *arena, const struct mesh_request *request,
                            struct mesh *out) {
    static const float position[24][3] = {
        {1, -1, -1}, {1, -1, 1},  {-1, -1, 1},  {-1, -1, -1},  // -y
        {1, 1, -1},  {-1, 1, -1}, {-1, 1, 1},   {1, 1, 1},     // +y
        {1, -1, -1}, {1, 1, -1},  {1, 1, 1},    {1, -1, 1},    // +x
        {1, -1, 1},  {1, 1, 1},   {-1, 1, 1},   {-1, -1, 1},   // +z
        {-1, -1, 1}, {-1, 1, 1},  {-1, 1, -1},  {-1, -1, -1},  // -x
        {1, 1, -1},  {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1},   // -z
    };
    static const float normal[6][3] = {{0, -1, 0}, {0, 1, 0},  {1, 0, 0},
                                       {0, 0, 1},  {-1, 0, 0}, {0, 0, -1}};
    float uv[24][2];
    static const float corner[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    for (int i = 0; i < 24; i++) memcpy(uv[i], corner[i % 4], sizeof uv[i]);
    return make(arena, request, 24, position, normal, uv, out);
}
