// SPDX-License-Identifier: Apache-2.0
// Transform, area and bounds of every kind of shape.
#include "scene/scene_quadric.h"

// ---- Spheres, disks, cylinders ------------------------------------------------------------------

bool scene_shape_transform(struct shape *shape, const struct mat4 *to_world) {
    struct mat4 to_object;
    if (!mat4_inverse(to_world, &to_object)) return false;
    shape->to_world = *to_world;
    shape->to_object = to_object;
    if (shape->kind != SHAPE_SPHERE) return true;
    shape->centre = mat4_point(to_world, v3(0, 0, 0));
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
            // Exact if the scales across the axis are equal; Mitsuba allows no others.
            return (float)(2.0 * M_PI * column_length(&shape->to_world, 0) *
                           column_length(&shape->to_world, 2));
    }
    return 0.0f;
}

// ---- Bounds -------------------------------------------------------------------------------------

static void add_corner(vec3 p, vec3 *lo, vec3 *hi) {
    *lo = v3_min(*lo, p);
    *hi = v3_max(*hi, p);
}

void scene_shape_bounds(const struct shape *shape, vec3 *lo, vec3 *hi) {
    struct quadric quadric;
    *lo = v3(INFINITY, INFINITY, INFINITY);
    *hi = v3_neg(*lo);
    switch (shape->kind) {
        case SHAPE_CURVES:
        case SHAPE_INSTANCE:
            *lo = shape->lo;
            *hi = shape->hi;
            return;
        case SHAPE_MESH:
            for (size_t i = 0; i < shape->mesh.vertex_count; i++) {
                const float *p = shape->mesh.position + 3 * i;
                add_corner(v3(p[0], p[1], p[2]), lo, hi);
            }
            return;
        case SHAPE_SPHERE:
        case SHAPE_DISK:
        case SHAPE_CYLINDER:
            if (scene_quadric_make(shape, 0, &quadric)) scene_quadric_bounds(&quadric, lo, hi);
            return;
    }
}
