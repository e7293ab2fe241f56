// SPDX-License-Identifier: Apache-2.0
// Shapes that need no file: the rectangle and the cube as meshes, with vertices, triangles and
// texture coordinates as Mitsuba 3 has them; and the area of every kind of shape.
#include <string.h>

#include "scene/scene_mesh.h"

// ---- Rectangle and cube -------------------------------------------------------------------------

static satin_status make(struct arena *arena, const struct mesh_request *request, uint32_t vertices,
                         const float (*position)[3], const float (*normal)[3], const float (*uv)[2],
                         struct mesh *out) {
    struct scene_source source = {.arena = arena, .path = "shape"};
    struct mesh_parts parts;
    satin_status status = mesh_allocate(&source, vertices, true, true, &parts);
    if (status != SATIN_OK) return status;
    memcpy(parts.position, position, vertices * sizeof *position);
    memcpy(parts.uv, uv, vertices * sizeof *uv);
    // Every four vertices are a face with one normal, cut along its diagonal.
    parts.triangle_count = vertices / 2;
    parts.index = arena_array(arena, (size_t)parts.triangle_count * 3, sizeof(uint32_t));
    if (!parts.index) return SATIN_ERROR_MEMORY;
    static const uint32_t corner[6] = {0, 1, 2, 3, 0, 2};
    for (uint32_t i = 0; i < parts.triangle_count * 3; i++)
        parts.index[i] = i / 6 * 4 + corner[i % 6];
    for (uint32_t i = 0; i < vertices; i++)
        memcpy(parts.normal + (size_t)i * 3, normal[i / 4], sizeof *normal);
    return mesh_finish(&source, request, &parts, out);
}

satin_status scene_mesh_rectangle(struct arena *arena, const struct mesh_request *request,
                                  struct mesh *out) {
    static const float position[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    static const float normal[1][3] = {{0, 0, 1}};
    static const float uv[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    return make(arena, request, 4, position, normal, uv, out);
}

satin_status scene_mesh_cube(struct arena *arena, const struct mesh_request *request,
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

// ---- Spheres, disks, cylinders ------------------------------------------------------------------

bool scene_shape_place(struct shape *shape, const struct mat4 *to_world) {
    struct mat4 to_object;
    if (!mat4_inverse(to_world, &to_object)) return false;
    shape->to_world = *to_world;
    shape->to_object = to_object;
    if (shape->kind != SHAPE_SPHERE) return true;
    shape->center = mat4_point(to_world, v3(0, 0, 0));
    shape->radius = v3_len(mat4_vector(to_world, v3(1, 0, 0)));
    if (mat4_det3(to_world) < 0.0) shape->flip_normals = !shape->flip_normals;
    return true;
}

// ---- Area ---------------------------------------------------------------------------------------

static double mesh_area(const struct mesh *mesh) {
    double area = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const float *p[3];
        for (int k = 0; k < 3; k++)
            p[k] = mesh->position + (size_t)mesh->index[t * 3 + (size_t)k] * 3;
        double n2 = 0.0;
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            double c = ((double)p[1][j] - p[0][j]) * ((double)p[2][k] - p[0][k]) -
                       ((double)p[1][k] - p[0][k]) * ((double)p[2][j] - p[0][j]);
            n2 += c * c;
        }
        area += 0.5 * sqrt(n2);
    }
    return area;
}

// Length of column `i` of the transform, and the area of the parallelogram of columns i and j.
static double column_length(const struct mat4 *m, int i) {
    double l2 = 0.0;
    for (int r = 0; r < 3; r++) l2 += (double)m->m[r][i] * m->m[r][i];
    return sqrt(l2);
}

static double column_area(const struct mat4 *m, int i, int j) {
    double a = column_length(m, i), b = column_length(m, j), d = 0.0;
    for (int r = 0; r < 3; r++) d += (double)m->m[r][i] * m->m[r][j];
    return sqrt(fmax(a * a * b * b - d * d, 0.0));
}

float scene_shape_area(const struct shape *shape) {
    switch (shape->kind) {
        case SHAPE_CURVES:
        case SHAPE_INSTANCE:
            return 0.0f;
        case SHAPE_MESH:
            return (float)mesh_area(&shape->mesh);
        case SHAPE_SPHERE:
            return (float)(4.0 * M_PI * shape->radius * shape->radius);
        case SHAPE_DISK:
            return (float)(M_PI * column_area(&shape->to_world, 0, 1));
        case SHAPE_CYLINDER:
            // Exact for equal scales across the axis; Mitsuba allows no others.
            return (float)(2.0 * M_PI * column_length(&shape->to_world, 0) *
                           column_length(&shape->to_world, 2));
    }
    return 0.0f;
}
