// SPDX-License-Identifier: Apache-2.0
// Instances: groups of shapes that rays hit through a transform, for scene_trace.c.
#include "scene/scene_instance.h"

#include "scene/scene_interaction.h"

// About the largest and the least length of a transformed unit vector. They are lengths of columns,
// which is accurate enough for bounds.
static float longest_column(const struct mat4 *m) {
    float l2 = 0.0f;
    for (int j = 0; j < 3; j++) l2 = fmaxf(l2, v3_len2(v3(m->m[0][j], m->m[1][j], m->m[2][j])));
    return sqrtf(l2);
}

void scene_instance_bound(struct shape *shape, vec3 lo, vec3 hi) {
    shape->lo = v3(INFINITY, INFINITY, INFINITY);
    shape->hi = v3_neg(shape->lo);
    for (int i = 0; i < 8; i++) {
        vec3 corner = v3(i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z);
        vec3 p = mat4_point(&shape->to_world, corner);
        shape->lo = v3_min(shape->lo, p);
        shape->hi = v3_max(shape->hi, p);
    }
    // The rounding of a ray in the group's space is relative to the terms of its origin there.
    vec3 back = v3(shape->to_object.m[0][3], shape->to_object.m[1][3], shape->to_object.m[2][3]);
    float extent = fmaxf(v3_max_abs(lo), v3_max_abs(hi)) + v3_max_abs(back);
    shape->radius = longest_column(&shape->to_world) * extent;
}

struct ray scene_instance_ray(const struct shape *shape, const struct ray *ray) {
    return (struct ray){mat4_point(&shape->to_object, ray->o), ray->tnear,
                        mat4_vector(&shape->to_object, ray->d), ray->tfar};
}

float scene_instance_length(const struct shape *shape, float length) {
    return length * longest_column(&shape->to_object);
}

float scene_instance_margin(const struct satin_scene *scene, const struct shape *shape, vec3 p) {
    return scene_instance_length(shape, 4.0f * scene_interaction_offset(scene, p));
}

void scene_instance_to_world(const struct shape *shape, bool tangent, bool partials,
                             struct interaction *s) {
    vec3 u = mat4_vector(&shape->to_world, s->frame.u);
    if (partials) {
        s->dp_du = mat4_vector(&shape->to_world, s->dp_du);
        s->dp_dv = mat4_vector(&shape->to_world, s->dp_dv);
    }
    if (s->uv_rate > 0.0f) {
        vec3 v = mat4_vector(&shape->to_world, s->frame.v);
        s->uv_rate /= sqrtf(fmaxf(v3_len(v3_cross(u, v)), 1e-20f));
    }
    vec3 n = v3_unit(mat4_normal(&shape->to_object, s->frame.n));
    s->p = mat4_point(&shape->to_world, s->p);
    s->ng = v3_unit(mat4_normal(&shape->to_object, s->ng));
    s->frame = tangent ? frame_from_tangent(n, u) : frame_from_normal(n);
}
