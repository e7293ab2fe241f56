// SPDX-License-Identifier: Apache-2.0
// How the normal of a surface rotates along it: exact on spheres, and on meshes by the normals at
// the corners of the triangle. Bump and normal maps are left out.
#include "scene/scene.h"

static vec3 mesh_normal(const struct mesh *mesh, uint32_t i) {
    return v3(mesh->normal[3 * (size_t)i], mesh->normal[3 * (size_t)i + 1],
              mesh->normal[3 * (size_t)i + 2]);
}

// The derivative of the interpolated normal, which is n after it was made a unit vector: that of
// the blend of the corners' normals, across n.
static vec3 mesh_rotation(const struct mesh *mesh, const struct interaction *s, vec3 n, vec3 dp) {
    if (!mesh->normal) return v3(0, 0, 0);
    const uint32_t *index = mesh->index + 3 * (size_t)s->prim;
    const vec3 a = scene_mesh_vertex(mesh, index[0]);
    const vec3 ab = v3_sub(scene_mesh_vertex(mesh, index[1]), a),
               ac = v3_sub(scene_mesh_vertex(mesh, index[2]), a), across = v3_cross(ab, ac);
    const float area2 = v3_len2(across);
    const vec3 na = mesh_normal(mesh, index[0]), to_b = v3_sub(mesh_normal(mesh, index[1]), na),
               to_c = v3_sub(mesh_normal(mesh, index[2]), na);
    const vec3 blend = v3_mad(v3_mad(na, s->bary.x, to_b), s->bary.y, to_c);
    const float length = v3_dot(blend, n);
    if (!(area2 > 0.0f) || !(length > 0.0f)) return v3(0, 0, 0);
    const float db = v3_dot(v3_cross(dp, ac), across) / area2,
                dc = v3_dot(v3_cross(ab, dp), across) / area2;
    const vec3 change = v3_mad(v3_mul(to_b, db), dc, to_c);
    return v3_mul(v3_mad(change, -v3_dot(change, n), n), 1.0f / length);
}

vec3 scene_normal_change(const struct satin_scene *scene, const struct interaction *s, vec3 dp) {
    const struct shape *shape = &scene->shape[s->shape];
    if (s->instance) return v3(0, 0, 0);
    if (shape->kind == SHAPE_MESH) return mesh_rotation(&shape->mesh, s, s->frame.n, dp);
    if (shape->kind != SHAPE_SPHERE) return v3(0, 0, 0);
    const float outward = v3_dot(v3_sub(s->p, shape->centre), s->frame.n);
    return v3_mul(dp, copysignf(1.0f / shape->radius, outward));
}
