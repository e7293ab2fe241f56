// SPDX-License-Identifier: Apache-2.0
// Area lights: uniform radiance, or a texture over uv, leaves the front side of a shape. Meshes of
// few flat faces are sampled face by face (light_face.c, light_texels.c), other meshes by slabs
// from near (light_slabs.c) and by what faces the point from far (light_facing.c), spheres by their
// cone, cylinders by the angles that they subtend (light_cylinder.c), disks by area. Conventions
// are Mitsuba 3's with one deviation: the geometric normal decides which side is the front, so that
// the emitted power is pi L A.
#include "base/sampling.h"
#include "light/light_kinds.h"

enum { FACES_MAX = 16 };  // a choice among faces costs about 5 ns for each

static float normal_sign(const struct shape *shape) { return shape->flip_normals ? -1.0f : 1.0f; }

static rgb area_radiance(const struct light *light, struct texture_lookup at) {
    return light->texture ? scene_texture_eval(light->texture, &at) : light->value;
}

// ---- Shapes -----------------------------------------------------------------------------------

struct triangle {
    vec3 a, ab, ac, n;  // n is not normalised: its length is twice the area; front side
};

static struct triangle triangle_get(const struct shape *shape, uint32_t i) {
    const uint32_t *index = shape->mesh.index + 3 * (size_t)i;
    vec3 a = scene_mesh_vertex(&shape->mesh, index[0]);
    vec3 ab = v3_sub(scene_mesh_vertex(&shape->mesh, index[1]), a);
    vec3 ac = v3_sub(scene_mesh_vertex(&shape->mesh, index[2]), a);
    vec3 n = v3_cross(ab, ac);
    return (struct triangle){a, ab, ac, v3_mul(n, light_mesh_side(shape, index, n))};
}

static struct light_point sphere_point(const struct light *light, const struct shape *shape,
                                       vec3 outward) {
    struct light_point out = {.p = v3_mad(shape->centre, shape->radius, outward),
                              .n = v3_mul(outward, normal_sign(shape)),
                              .pdf_a = 1.0f / shape->area};
    vec3 o = v3_unit(mat4_vector(&shape->to_object, outward));
    vec2 uv = {azimuth_fraction(o.y, o.x), acosf(clampf(o.z, -1, 1)) * (1 / PI_F)};
    out.L = area_radiance(light, scene_texture_at(uv));
    return out;
}

static struct light_point disk_point(const struct light *light, const struct shape *shape, float u,
                                     float v) {
    vec2 d = sample_disk(u, v);
    vec3 n = v3_unit(mat4_normal(&shape->to_object, v3(0.0f, 0.0f, 1.0f)));
    return (struct light_point){
        mat4_point(&shape->to_world, v3(d.x, d.y, 0.0f)), v3_mul(n, normal_sign(shape)),
        area_radiance(light, scene_texture_at(
                                 (vec2){sqrtf(d.x * d.x + d.y * d.y), azimuth_fraction(d.y, d.x)})),
        1.0f / shape->area};
}

static struct light_point cylinder_point(const struct light *light, const struct shape *shape,
                                         float u, float v) {
    vec3 o = v3(cosf(2.0f * PI_F * u), sinf(2.0f * PI_F * u), 0.0f);
    vec3 n = v3_unit(mat4_normal(&shape->to_object, o));
    return (struct light_point){
        mat4_point(&shape->to_world, v3(o.x, o.y, v)), v3_mul(n, normal_sign(shape)),
        area_radiance(light, scene_texture_at((vec2){u, v})), 1.0f / shape->area};
}

vec3 light_triangle_normal(const struct shape *shape, uint32_t i) {
    return triangle_get(shape, i).n;
}

static float triangle_pdf(const float *cdf, uint32_t i, float normal_length) {
    return 2.0f * (cdf[i + 1] - cdf[i]) / normal_length;
}

static rgb triangle_radiance(const struct light *light, const struct mesh *mesh, uint32_t i,
                             vec2 b) {
    struct texture_lookup at = {b, mesh, i, b, 0.0f};
    if (light->texture) at.uv = scene_mesh_uv(mesh, i, b);
    return area_radiance(light, at);
}

// The weights of the second and third corner at a point of a triangle.
static vec2 triangle_coordinates(const struct triangle *t, vec3 p) {
    const vec3 d = v3_sub(p, t->a), n = v3_cross(t->ab, t->ac);
    const float scale = 1.0f / v3_len2(n);
    return (vec2){v3_dot(v3_cross(d, t->ac), n) * scale, v3_dot(v3_cross(t->ab, d), n) * scale};
}

static struct light_point triangle_point(const struct light *light, const struct shape *shape,
                                         const float *cdf, float u, float v) {
    const struct mesh *mesh = &shape->mesh;
    uint32_t i = (uint32_t)sample_cdf(cdf, mesh->triangle_count, u, &u);
    struct triangle t = triangle_get(shape, i);
    vec2 b = sample_triangle(u, v);
    float length = v3_len_wide(t.n);
    return (struct light_point){v3_mad(v3_mad(t.a, b.x, t.ab), b.y, t.ac),
                                v3_mul(t.n, 1.0f / length), triangle_radiance(light, mesh, i, b),
                                triangle_pdf(cdf, i, length)};
}

static rgb face_radiance(const struct light *light, const struct mesh *mesh,
                         const struct light_face *face, vec3 q) {
    if (!light->texture) return light->value;
    const vec2 st = light_face_coordinates(face, q);
    return area_radiance(light, scene_texture_at(light_face_uv(face, mesh, st.x, st.y)));
}

struct light_point light_area_point(const struct satin_scene *scene, const struct light *light,
                                    float u, float v) {
    const struct shape *shape = &scene->shape[light->shape];
    if (shape->kind == SHAPE_SPHERE) return sphere_point(light, shape, sample_uniform_sphere(u, v));
    if (shape->kind == SHAPE_DISK) return disk_point(light, shape, u, v);
    if (shape->kind == SHAPE_CYLINDER) return cylinder_point(light, shape, u, v);
    if (!light->face) return triangle_point(light, shape, shape->area_cdf, u, v);
    float x = u * shape->area;
    uint32_t i = 0;
    while (i + 1 < light->face_count && x >= light->face[i].area) x -= light->face[i++].area;
    const struct light_face *face = &light->face[i];
    vec2 st = {clampf(x / face->area, 0.0f, 1.0f), v};
    float density = 1.0f;
    if (face->grid > 0.0f) {
        if (st.x < face->grid)
            st = light_texels_sample(face, st.x / face->grid, v);
        else
            st.x = (st.x - face->grid) / (1.0f - face->grid);
        density = lerpf(1.0f, light_texels_density(face, st), face->grid);
    }
    vec3 q = v3_mad(v3_mad(face->corner, st.x, face->edge_u), st.y, face->edge_v);
    return (struct light_point){q, face->n, face_radiance(light, &shape->mesh, face, q),
                                density / shape->area};
}

// ---- Preparation ------------------------------------------------------------------------------

static satin_status prepare_mesh(struct satin_scene *scene, struct light *light) {
    struct shape *shape = &scene->shape[light->shape];
    uint32_t n = shape->mesh.triangle_count, pairs = n / 2;
    // Without texture coordinates, or with an attribute, a texture is defined per triangle.
    bool plain = !scene_attribute_used(light->texture) && (!light->texture || shape->mesh.uv);
    if (n == 2 * pairs && pairs > 0 && pairs <= FACES_MAX && plain) {
        struct light_face *face = arena_array(&scene->arena, pairs, sizeof *face);
        if (!face) return SATIN_ERROR_MEMORY;
        if (light_faces_build(shape, face, pairs)) {
            light->face = face;
            light->face_count = pairs;
            shape->area = 0.0f;
            satin_status status = SATIN_OK;
            for (uint32_t i = 0; i < pairs; i++) {
                shape->area += face[i].area;
                if (light->texture && status == SATIN_OK)
                    status = light_texels_build(scene, light, &face[i]);
            }
            return status;
        }
    }
    float *area = arena_array(&scene->arena, (size_t)n + 1, sizeof *area);
    float *cdf = arena_array(&scene->arena, (size_t)n + 1, sizeof *cdf);
    if (!area || !cdf) return SATIN_ERROR_MEMORY;
    for (uint32_t i = 0; i < n; i++) area[i] = 0.5f * v3_len_wide(triangle_get(shape, i).n);
    if (n > 0) shape->area = (float)sample_cdf_build(area, n, cdf);
    shape->area_cdf = cdf;
    return SATIN_OK;
}

static void bound_mesh(const struct shape *shape, struct light *light) {
    vec3 lo, hi;
    scene_shape_bounds(shape, &lo, &hi);
    light->centre = v3_mul(v3_add(lo, hi), 0.5f);
    light->radius = 0.5f * v3_len(v3_sub(hi, lo));
}

satin_status light_area_prepare(struct satin_scene *scene, struct light *light) {
    struct shape *shape = &scene->shape[light->shape];
    if (shape->kind == SHAPE_MESH) {
        satin_status status = prepare_mesh(scene, light);
        bound_mesh(shape, light);
        if (status == SATIN_OK && !light->face) status = light_facing_build(scene, light);
        if (status == SATIN_OK && !light->face) status = light_slabs_build(scene, light);
        if (status != SATIN_OK) return status;
    } else {
        shape->area = scene_shape_area(shape);
        float middle = shape->kind == SHAPE_CYLINDER ? 0.5f : 0.0f;
        light->centre = mat4_point(&shape->to_world, v3(0.0f, 0.0f, middle));
        if (shape->kind == SHAPE_SPHERE) light->centre = shape->centre;
        if (shape->kind == SHAPE_CYLINDER && light_tube_build(scene, light) != SATIN_OK)
            return SATIN_ERROR_MEMORY;
    }
    const struct texture *texture = light->texture;
    rgb mean = texture ? scene_attribute_mean(&shape->mesh, texture) : light->value;
    light->strength = rgb_luminance(mean) * shape->area;
    light->power = PI_F * light->strength;
    return SATIN_OK;
}

// ---- Direct lighting --------------------------------------------------------------------------

float light_area_estimate(const struct satin_scene *scene, const struct light *light, vec3 p) {
    const struct shape *shape = &scene->shape[light->shape];
    if (light->face) {
        float sum = 0.0f;
        for (uint32_t i = 0; i < light->face_count; i++)
            sum += light_face_estimate(&light->face[i], p);
        return sum * light->strength / shape->area;
    }
    if (light->slabs && !light_mesh_is_far(light, p))
        return light->strength * light_slabs_estimate(light->slabs, p) / shape->area;
    if (light->tube) return light->strength * light_tube_closeness(light->tube, p);
    return light->strength / (v3_dist2(p, light->centre) + (0.5f / PI_F) * shape->area);
}

// Chooses a face by its estimate. *probability is that of the face `wanted`, or of the chosen one
// if `wanted` is negative.
static uint32_t choose_face(const struct light *light, vec3 p, float *u, int64_t wanted,
                            float *probability) {
    *probability = 1.0f;
    if (light->face_count == 1) return 0;
    float weight[FACES_MAX], cdf[FACES_MAX + 1];
    for (uint32_t i = 0; i < light->face_count; i++)
        weight[i] = light_face_estimate(&light->face[i], p);
    sample_cdf_build(weight, light->face_count, cdf);
    size_t i = wanted < 0 ? sample_cdf(cdf, light->face_count, *u, u) : (size_t)wanted;
    *probability = cdf[i + 1] - cdf[i];
    return (uint32_t)i;
}

static bool finish_area_sample(const struct light_point *at, vec3 p, float pdf_w,
                               struct light_sample *out) {
    vec3 d = v3_sub(at->p, p);
    float d2 = v3_len2(d), dist = sqrtf(d2);
    if (!(dist > 0.0f)) return false;
    vec3 wi = v3_mul(d, 1.0f / dist);
    float cosine = -v3_dot(wi, at->n);
    if (!(cosine > 0.0f)) return false;
    if (pdf_w == 0.0f) pdf_w = at->pdf_a * d2 / cosine;
    if (!(pdf_w > 0.0f) || !isfinite(pdf_w)) return false;
    *out = (struct light_sample){
        .wi = wi, .p = at->p, .n = at->n, .dist = dist, .L = at->L, .pdf_w = pdf_w};
    return true;
}

// 1 - cos of the half angle of the cone that the sphere subtends.
static float sphere_cone(const struct shape *shape, float d2) {
    float sin2 = fminf(shape->radius * shape->radius / d2, 1.0f);
    return sin2 / (1.0f + safe_sqrtf(1.0f - sin2));
}

static bool sphere_sample(const struct light *light, const struct shape *shape, vec3 p, float u,
                          float v, struct light_sample *out) {
    vec3 to_centre = v3_sub(shape->centre, p);
    float d2 = v3_len2(to_centre), r = shape->radius;
    bool inside = d2 < r * r;
    if (inside != shape->flip_normals) return false;
    vec3 w;
    float t, pdf_w;
    if (inside) {  // every direction hits the sphere once
        w = sample_uniform_sphere(u, v);
        float b = v3_dot(to_centre, w);
        t = b + safe_sqrtf(b * b + (r * r - d2));
        pdf_w = 0.25f / PI_F;
    } else {
        float span = sphere_cone(shape, d2), versine = u * span;
        float sin2 = versine * (2.0f - versine), phi = 2.0f * PI_F * v;
        float s = safe_sqrtf(sin2), dist = sqrtf(d2);
        struct frame f = frame_from_normal(v3_mul(to_centre, 1.0f / dist));
        w = frame_to_world(&f, v3(s * cosf(phi), s * sinf(phi), 1.0f - versine));
        t = dist * (1.0f - versine) - safe_sqrtf(r * r - d2 * sin2);
        pdf_w = 0.5f / (PI_F * span);
    }
    vec3 outward = v3_unit(v3_sub(v3_mad(p, t, w), shape->centre));
    struct light_point at = sphere_point(light, shape, outward);
    return finish_area_sample(&at, p, pdf_w, out);
}

// Sets *at and the density over solid angle. False if it must be sampled by area.
static bool sample_tube(const struct light *light, vec3 p, float u, float v, struct light_point *at,
                        float *pdf_w) {
    struct light_tube_point point;
    if (!light->tube || !light_tube_sample(light->tube, p, u, v, &point)) return false;
    *at = (struct light_point){point.p, point.n, area_radiance(light, scene_texture_at(point.uv)),
                               0.0f};
    *pdf_w = point.pdf_w;
    return true;
}

// A point of a mesh of many triangles for p: from near by slabs, else by what faces p.
static struct light_point mesh_point(const struct light *light, const struct shape *shape, vec3 p,
                                     float u, float v) {
    if (!light->slabs || light_mesh_is_far(light, p))
        return triangle_point(light, shape, light_facing_cdf(light, shape, p), u, v);
    const struct light_slab_point at = light_slabs_sample(light->slabs, p, u, v);
    const struct triangle t = triangle_get(shape, at.triangle);
    const vec2 b = triangle_coordinates(&t, at.p);
    return (struct light_point){at.p, v3_unit_wide(t.n),
                                triangle_radiance(light, &shape->mesh, at.triangle, b), at.pdf_a};
}

bool light_area_sample(const struct satin_scene *scene, const struct light *light, vec3 p, float u,
                       float v, struct light_sample *out) {
    const struct shape *shape = &scene->shape[light->shape];
    if (shape->kind == SHAPE_SPHERE) return sphere_sample(light, shape, p, u, v, out);
    if (!light->face) {
        struct light_point at;
        float pdf_w = 0.0f;
        if (shape->kind == SHAPE_MESH)
            at = mesh_point(light, shape, p, u, v);
        else if (!sample_tube(light, p, u, v, &at, &pdf_w))
            at = light_area_point(scene, light, u, v);
        return finish_area_sample(&at, p, pdf_w, out);
    }
    float probability, pdf_w;
    vec3 q;
    const struct light_face *face = &light->face[choose_face(light, p, &u, -1, &probability)];
    if (!light_face_sample(face, p, u, v, &q, &pdf_w)) return false;
    struct light_point at = {q, face->n, face_radiance(light, &shape->mesh, face, q), 0.0f};
    return finish_area_sample(&at, p, pdf_w * probability, out);
}

float light_area_pdf(const struct satin_scene *scene, const struct light *light, vec3 p, vec3 wi,
                     const struct interaction *s) {
    const struct shape *shape = &scene->shape[light->shape];
    float cosine = -v3_dot(wi, s->ng);
    if (!(cosine > 0.0f)) return 0.0f;
    float d2 = v3_dist2(p, s->p);
    if (shape->kind == SHAPE_SPHERE) {
        float c2 = v3_dist2(p, shape->centre);
        bool inside = c2 < shape->radius * shape->radius;
        if (inside != shape->flip_normals) return 0.0f;
        return inside ? 0.25f / PI_F : 0.5f / (PI_F * sphere_cone(shape, c2));
    }
    if (light->face) {
        uint32_t i = s->prim / 2;
        float probability, unused = 0.0f;
        choose_face(light, p, &unused, i, &probability);
        return probability * light_face_pdf(&light->face[i], p, s->p);
    }
    float pdf_w, pdf_a = 1.0f / shape->area;
    if (light->tube && light_tube_pdf(light->tube, p, s->p, &pdf_w)) return pdf_w;
    if (light->slabs && !light_mesh_is_far(light, p))
        pdf_a = light_slabs_pdf(light->slabs, p, s->p);
    else if (shape->kind == SHAPE_MESH)
        pdf_a = triangle_pdf(light_facing_cdf(light, shape, p), s->prim,
                             v3_len_wide(triangle_get(shape, s->prim).n));
    return pdf_a * d2 / cosine;
}
