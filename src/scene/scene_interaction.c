// SPDX-License-Identifier: Apache-2.0
// The surface at a triangle hit, and the spawning of rays from surfaces.
//
// Three measures prevent self-intersection without a tolerance in world units:
// - A hit point is interpolated in double and rounded once, so it is within half an ulp of the
//   plane.
// - scene_spawn moves the origin off the surface by a few ulp of the position, which is more than
//   that half ulp.
// - The filter of scene_accel.c tests a hit by scene_interaction_crosses, in double, if it is
// nearer than
//   the float intersector can resolve on a large or thin triangle. It does the same for a hit near
//   the end of a ray that ends on a surface.
// Light leaks at edges are prevented by moving hits a few ulp into their triangle: next to an edge,
// a rounded position could be beyond the neighbouring face.
#include "scene/scene_interaction.h"

#include "scene/scene_instance.h"

struct surface_triangle {
    double p[3][3];
    double e1[3], e2[3];  // p1 - p0, p2 - p0
    double n[3];          // e1 x e2
};

static void surface_triangle_get(const struct mesh *mesh, uint32_t prim,
                                 struct surface_triangle *t) {
    const uint32_t *index = mesh->index + (size_t)prim * 3;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) t->p[k][i] = mesh->position[(size_t)index[k] * 3 + i];
    for (int i = 0; i < 3; i++) {
        t->e1[i] = t->p[1][i] - t->p[0][i];
        t->e2[i] = t->p[2][i] - t->p[0][i];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        t->n[i] = t->e1[j] * t->e2[k] - t->e1[k] * t->e2[j];
    }
}

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool scene_interaction_crosses(const struct mesh *mesh, uint32_t prim, vec3 o, vec3 d, float tnear,
                               float tfar) {
    struct surface_triangle t;
    surface_triangle_get(mesh, prim, &t);
    const double to[3] = {t.p[0][0] - o.x, t.p[0][1] - o.y, t.p[0][2] - o.z};
    const double direction[3] = {d.x, d.y, d.z};
    double at = dot3(to, t.n) / dot3(direction, t.n);
    return at > tnear && at < tfar;
}

struct interaction_error scene_interaction_error(const struct mesh *mesh) {
    const double ulps = 64.0 * 0x1p-24;
    double edge2 = 0.0, aspect = 0.0;  // largest edge^2; largest edge^2 / |n|
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        struct surface_triangle t;
        surface_triangle_get(mesh, i, &t);
        const double e3[3] = {t.e2[0] - t.e1[0], t.e2[1] - t.e1[1], t.e2[2] - t.e1[2]};
        double longest2 = fmax(dot3(e3, e3), fmax(dot3(t.e1, t.e1), dot3(t.e2, t.e2)));
        double n2 = dot3(t.n, t.n);
        edge2 = fmax(edge2, longest2);
        if (n2 > 0.0) aspect = fmax(aspect, longest2 / sqrt(n2));
    }
    return (struct interaction_error){ulps * edge2 * sqrt(edge2), ulps * aspect * sqrt(aspect)};
}

// Moves the barycentric coordinates b to a distance of at least `margin` (world units) from the
// edges, or to the centre of a triangle that is too small for that. False if they already have that
// distance.
static bool pull_inside(const struct surface_triangle *t, double margin, double b[3]) {
    const double e3[3] = {t->e2[0] - t->e1[0], t->e2[1] - t->e1[1], t->e2[2] - t->e1[2]};
    const double *edge[3] = {e3, t->e2, t->e1};  // opposite to each vertex
    double n2 = dot3(t->n, t->n), least2[3], sum = 0.0;
    bool near_edge = false;
    for (int k = 0; k < 3; k++) {
        least2[k] = margin * margin * dot3(edge[k], edge[k]);  // (margin |n| / height)^2
        near_edge = near_edge || !(b[k] > 0.0 && b[k] * b[k] * n2 >= least2[k]);
    }
    if (!near_edge) return false;
    for (int k = 0; k < 3; k++) {
        b[k] = fmax(b[k], fmin(sqrt(least2[k] / n2), 1.0 / 3.0));
        sum += b[k];
    }
    for (int k = 0; k < 3; k++) b[k] /= sum;
    return true;
}

// dp/du and dp/dv of the texture coordinates or, if there are none, of the barycentric coordinates,
// which grow along the first two edges. If the texture coordinates are degenerate, they are the
// axes of the frame of ng.
static void triangle_tangents(const struct mesh *mesh, const uint32_t *index,
                              const struct surface_triangle *t, vec3 ng, vec3 *dp_du, vec3 *dp_dv) {
    double du[3] = {t->e1[0], t->e1[1], t->e1[2]}, dv[3] = {t->e2[0], t->e2[1], t->e2[2]};
    if (mesh->uv) {
        const float *a = mesh->uv + (size_t)index[0] * 2, *b = mesh->uv + (size_t)index[1] * 2,
                    *c = mesh->uv + (size_t)index[2] * 2;
        double v1 = (double)b[1] - a[1], v2 = (double)c[1] - a[1];
        double u1 = (double)b[0] - a[0], u2 = (double)c[0] - a[0], det = u1 * v2 - v1 * u2;
        if (det == 0.0) {
            struct frame f = frame_from_normal(ng);
            *dp_du = f.u, *dp_dv = f.v;
            return;
        }
        for (int i = 0; i < 3; i++) {
            du[i] = (v2 * t->e1[i] - v1 * t->e2[i]) / det;
            dv[i] = (u1 * t->e2[i] - u2 * t->e1[i]) / det;
        }
    }
    *dp_du = v3((float)du[0], (float)du[1], (float)du[2]);
    *dp_dv = v3((float)dv[0], (float)dv[1], (float)dv[2]);
}

static vec3 blend_corners(const struct surface_triangle *t, const double b[3]) {
    return v3((float)(b[0] * t->p[0][0] + b[1] * t->p[1][0] + b[2] * t->p[2][0]),
              (float)(b[0] * t->p[0][1] + b[1] * t->p[1][1] + b[2] * t->p[2][1]),
              (float)(b[0] * t->p[0][2] + b[1] * t->p[1][2] + b[2] * t->p[2][2]));
}

// In float, which is accurate enough for a shading normal.
static vec3 blend_normals(const float *normal, const uint32_t *index, const double b[3]) {
    const float *p = normal + (size_t)index[0] * 3, *q = normal + (size_t)index[1] * 3,
                *r = normal + (size_t)index[2] * 3;
    float b0 = (float)b[0], b1 = (float)b[1], b2 = (float)b[2];
    return v3(b0 * p[0] + b1 * q[0] + b2 * r[0], b0 * p[1] + b1 * q[1] + b2 * r[1],
              b0 * p[2] + b1 * q[2] + b2 * r[2]);
}

void scene_interaction_triangle(const struct satin_scene *scene, const struct shape *shape,
                                const struct interaction_hit *hit, struct interaction *out) {
    const struct mesh *mesh = &shape->mesh;
    const uint32_t *index = mesh->index + (size_t)hit->prim * 3;
    struct surface_triangle t;
    surface_triangle_get(mesh, hit->prim, &t);
    double b[3] = {1.0 - (double)hit->u - (double)hit->v, hit->u, hit->v};
    out->p = blend_corners(&t, b);
    double margin =
        hit->margin > 0.0f ? hit->margin : 4.0 * scene_interaction_offset(scene, out->p);
    if (pull_inside(&t, margin, b)) out->p = blend_corners(&t, b);

    double s = (shape->flip_normals ? -1.0 : 1.0) / sqrt(dot3(t.n, t.n));
    vec3 ng = v3((float)(s * t.n[0]), (float)(s * t.n[1]), (float)(s * t.n[2])), n = ng;
    if (mesh->normal) {
        n = blend_normals(mesh->normal, index, b);
        float l2 = v3_len2(n);
        n = l2 > 0.0f ? v3_mul(n, 1.0f / sqrtf(l2)) : ng;
        // The front side is that of the shading normal, as in Mitsuba.
        if (v3_dot(n, ng) < 0.0f) ng = v3_neg(ng);
    }
    out->ng = ng;
    out->uv = out->bary = (vec2){(float)b[1], (float)b[2]};
    double spanned = 1.0;  // twice the triangle's area in uv
    if (mesh->uv) {
        const float *a = mesh->uv + (size_t)index[0] * 2, *c = mesh->uv + (size_t)index[1] * 2,
                    *d = mesh->uv + (size_t)index[2] * 2;
        out->uv = (vec2){(float)(b[0] * a[0] + b[1] * c[0] + b[2] * d[0]),
                         (float)(b[0] * a[1] + b[1] * c[1] + b[2] * d[1])};
        spanned = fabs(((double)c[0] - a[0]) * ((double)d[1] - a[1]) -
                       ((double)d[0] - a[0]) * ((double)c[1] - a[1]));
    }
    if (hit->rate) out->uv_rate = (float)sqrt(spanned / sqrt(dot3(t.n, t.n)));
    if (hit->partials) triangle_tangents(mesh, index, &t, ng, &out->dp_du, &out->dp_dv);
    out->frame = hit->tangent ? frame_from_tangent(n, out->dp_du) : frame_from_normal(n);
}

vec3 scene_origin_shift(const struct satin_scene *scene, const struct interaction *s,
                        float margin) {
    const struct shape *shape = &scene->shape[s->shape],
                       *instance = s->instance ? &scene->shape[s->instance - 1] : NULL;
    if (shape->kind != SHAPE_MESH || !(margin > 0.0f)) return s->p;
    struct surface_triangle t;
    surface_triangle_get(&shape->mesh, s->prim, &t);
    double b[3] = {1.0 - (double)s->bary.x - (double)s->bary.y, s->bary.x, s->bary.y};
    const vec3 before = instance ? blend_corners(&t, b) : s->p;
    if (!pull_inside(&t, instance ? scene_instance_length(instance, margin) : margin, b))
        return s->p;
    vec3 offset = v3_sub(blend_corners(&t, b), before);
    if (instance) offset = mat4_vector(&instance->to_world, offset);
    float length = v3_len(offset);
    return length > margin ? v3_mad(s->p, margin / length, offset) : v3_add(s->p, offset);
}

float scene_rounding(const struct satin_scene *scene, vec3 p) {
    return scene_interaction_offset(scene, p);
}

static vec3 leave_surface(vec3 p, vec3 ng, vec3 d, float offset) {
    double side = (double)ng.x * d.x + (double)ng.y * d.y + (double)ng.z * d.z;
    return v3_mad(p, side < 0.0 ? -offset : offset, ng);
}

struct ray scene_spawn(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d) {
    return (struct ray){leave_surface(p, ng, d, scene_interaction_offset(scene, p)), 0.0f, d,
                        INFINITY};
}

struct ray scene_spawn_to(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 q, vec3 nq) {
    vec3 d = v3_sub(q, p);
    // At the far end the rounding of the direction counts too, in proportion to the distance.
    float end_offset = fmaxf(scene_interaction_offset(scene, q), 8.0f * 0x1p-24f * v3_max_abs(d));
    vec3 o = leave_surface(p, ng, d, scene_interaction_offset(scene, p));
    vec3 end = leave_surface(q, nq, v3_neg(d), end_offset);
    d = v3_sub(end, o);
    float distance = v3_len(d);
    if (!(distance > 0.0f)) return (struct ray){o, 0.0f, v3(0, 0, 0), 0.0f};
    // Ends just before q: the length and the unit direction have errors of about an ulp each.
    return (struct ray){o, 0.0f, v3_mul(d, 1.0f / distance), distance * (1.0f - 0x1p-21f)};
}
