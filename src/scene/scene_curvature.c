// SPDX-License-Identifier: Apache-2.0
// How fast the normal of a surface rotates along it: exact on quadrics and curves, and on meshes by
// the normals at the corners of the triangle. Bump and normal maps are left out.
#include "scene/scene.h"

// The largest rate along an edge of the triangle.
static float mesh_curvature(const struct mesh *mesh, uint32_t triangle) {
    if (!mesh->normal) return 0.0f;
    const uint32_t *index = mesh->index + 3 * (size_t)triangle;
    float most2 = 0.0f;
    for (int k = 0; k < 3; k++) {
        const uint32_t i = index[k], j = index[(k + 1) % 3];
        const float *a = mesh->normal + 3 * (size_t)i, *b = mesh->normal + 3 * (size_t)j;
        const float rotation2 = v3_dist2(v3(a[0], a[1], a[2]), v3(b[0], b[1], b[2]));
        const float edge2 = v3_dist2(scene_mesh_vertex(mesh, i), scene_mesh_vertex(mesh, j));
        if (rotation2 > 0.0f) most2 = fmaxf(most2, rotation2 / edge2);
    }
    return sqrtf(most2);
}

static float shape_curvature(const struct shape *shape, uint32_t prim) {
    switch (shape->kind) {
        case SHAPE_SPHERE:
            return 1.0f / shape->radius;
        case SHAPE_CYLINDER: {
            const struct mat4 *m = &shape->to_world;
            return 1.0f / v3_len(v3(m->m[0][0], m->m[1][0], m->m[2][0]));
        }
        case SHAPE_CURVES:
            return 1.0f / shape->curves.point[4 * (size_t)shape->curves.first[prim] + 3];
        case SHAPE_MESH:
            return mesh_curvature(&shape->mesh, prim);
        case SHAPE_DISK:
        case SHAPE_INSTANCE:
            break;
    }
    return 0.0f;
}

float scene_curvature(const struct satin_scene *scene, const struct interaction *s) {
    const float own = shape_curvature(&scene->shape[s->shape], s->prim);
    if (s->instance == 0) return own;
    const double volume = mat4_det3(&scene->shape[s->instance - 1].to_world);
    return own / cbrtf((float)fabs(volume));
}
