// SPDX-License-Identifier: Apache-2.0
// Faces of area lights: rectangles and parallelograms, sampled as a whole so that the
// stratification of the random numbers is kept. A right-angled face is sampled by solid angle
// [Urena et al. 2013, "An area-preserving parametrization for spherical rectangles"], which avoids
// the 1 / d^2 peaks at points near an emitting wall. Deviation: the corner angles are complex
// numbers, whose error in float stays near 1e-7, while the paper's arccosines lose half the digits.
// Sums of angles are products, and only one arctangent is left. Strips, as of LEDs, are sampled
// by the angle that their length subtends, where their solid angle is small.
#include "base/sampling.h"
#include "light/light_kinds.h"
#include "light/light_line.h"

// Below this solid angle area sampling is as good, and faster.
#define SOLID_ANGLE_MIN 0.15f
// A face longer than this many times its width is a strip.
#define STRIP_LENGTH 4.0f

// An angle as the argument of the complex number c + i s, of any length.
struct angle {
    float c, s;
};

static struct angle angle_sum(struct angle a, struct angle b) {
    return (struct angle){a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};
}
static struct angle angle_difference(struct angle a, struct angle b) {
    return (struct angle){a.c * b.c + a.s * b.s, a.s * b.c - a.c * b.s};
}

// A right-angled face relative to a point, in a frame along the face's x, y and n.
struct spherical_rectangle {
    float x0, x1, y0, y1, z0;  // z0 < 0
    float b0, b1, solid_angle;
    struct angle k;  // the paper's k = 2 pi - g2 - g3
};

float light_mesh_side(const struct shape *shape, const uint32_t index[3], vec3 n) {
    const float *normal = shape->mesh.normal;
    if (!normal) return shape->flip_normals ? -1.0f : 1.0f;
    vec3 sum = v3(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < 3; i++) {
        const float *v = normal + 3 * (size_t)index[i];
        sum = v3_add(sum, v3(v[0], v[1], v[2]));
    }
    return v3_dot(sum, n) < 0.0f ? -1.0f : 1.0f;
}

static bool same_point(vec3 a, vec3 b, float scale2) { return v3_dist2(a, b) <= 1e-12f * scale2; }

// Finds the edge (a[1], a[2]) that triangle b has in common, with the vertices in cyclic order, and
// the opposite corner.
static bool face_pair(const struct mesh *mesh, uint32_t first, struct light_face *face) {
    const uint32_t *a = mesh->index + 3 * (size_t)first, *b = a + 3;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            uint32_t corner = a[i], u = a[(i + 1) % 3], v = a[(i + 2) % 3];
            vec3 p = scene_mesh_vertex(mesh, corner), pu = scene_mesh_vertex(mesh, u),
                 pv = scene_mesh_vertex(mesh, v);
            vec3 eu = v3_sub(pu, p), ev = v3_sub(pv, p);
            float scale2 = v3_len2(eu) + v3_len2(ev);
            uint32_t far = b[j], fv = b[(j + 1) % 3], fu = b[(j + 2) % 3];
            if (!same_point(scene_mesh_vertex(mesh, fv), pv, scale2) ||
                !same_point(scene_mesh_vertex(mesh, fu), pu, scale2) ||
                !same_point(scene_mesh_vertex(mesh, far), v3_add(pu, ev), 16.0f * scale2))
                continue;
            *face = (struct light_face){.corner = p,
                                        .edge_u = eu,
                                        .edge_v = ev,
                                        .n = v3_cross(eu, ev),
                                        .vertex = {corner, u, v, far, fv, fu}};
            face->area = v3_len_wide(face->n);
            face->length_u = v3_len(eu);
            face->length_v = v3_len(ev);
            face->x = v3_mul(eu, 1.0f / face->length_u);
            face->y = v3_mul(ev, 1.0f / face->length_v);
            float skew = fabsf(v3_dot(eu, ev));
            face->right_angled = skew <= 1e-5f * sqrtf(v3_len2(eu) * v3_len2(ev));
            return face->area > 0.0f;
        }
    return false;
}

bool light_faces_build(const struct shape *shape, struct light_face *face, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        if (!face_pair(&shape->mesh, 2 * i, &face[i])) return false;
        float side = light_mesh_side(shape, shape->mesh.index + 6 * (size_t)i, face[i].n);
        face[i].n = v3_mul(face[i].n, side / face[i].area);
    }
    return true;
}

static bool longer_by_u(const struct light_face *face) { return face->length_u > face->length_v; }

// The middle line of a strip relative to a point in front of it, which is at least as far away as a
// part of the width; without the angle. False if the face is not a strip.
static bool strip_make(const struct light_face *face, vec3 p, struct light_line *line) {
    const bool by_u = longer_by_u(face);
    const float length = by_u ? face->length_u : face->length_v, width = face->area / length;
    if (!(length > STRIP_LENGTH * width)) return false;
    const vec3 axis = by_u ? face->x : face->y, across = by_u ? face->edge_v : face->edge_u;
    const vec3 d = v3_mad(v3_sub(p, face->corner), -0.5f, across);
    const float foot = v3_dot(d, axis);
    const float away2 = v3_len2(v3_mad(d, -foot, axis)) + sqrf(width) * (0.5f / PI_F);
    *line = (struct light_line){length, foot, sqrtf(away2), 0.0f};
    return true;
}

float light_face_estimate(const struct light_face *face, vec3 p) {
    vec3 d = v3_sub(p, face->corner);
    float h = v3_dot(d, face->n);
    if (!(h > 0.0f)) return 0.0f;
    // The mean squared inverse distance, a squared distance where the light is, and its size.
    float closeness, nearest2, size;
    struct light_line strip;
    if (strip_make(face, p, &strip)) {
        closeness = light_line_closeness(strip.length, strip.foot, strip.away);
        nearest2 = sqrf(strip.away) + sqrf(strip.foot - clampf(strip.foot, 0.0f, strip.length));
        size = face->area / strip.length;
    } else {
        d = v3_mad(v3_mad(d, -0.5f, face->edge_u), -0.5f, face->edge_v);
        nearest2 = v3_len2(d) + face->area * (0.5f / PI_F);
        closeness = 1.0f / nearest2;
        size = sqrtf(face->area);
    }
    // Beside the light's plane the cosine to its centre is a poor estimate for its near part, hence
    // a quarter of its size is added. Points on the face itself (h = 0 up to rounding) get almost
    // nothing.
    const float height = (h + 0.25f * size) * h / (h + 1e-4f * size);
    return face->area * height * closeness / sqrtf(nearest2);
}

// The angle whose tangent is x y / (-z r), which is the solid angle between the axes and a corner.
// It is divided by r^2, as products of four lengths leave the range of float.
static struct angle corner_angle(float x, float y, float z) {
    float r2 = x * x + y * y + z * z, r = sqrtf(r2);
    return (struct angle){-z / r, x * y / r2};
}

// False if the face must be sampled by area from p.
static bool spherical_rectangle_make(const struct light_face *face, vec3 p,
                                     struct spherical_rectangle *rectangle) {
    if (!face->right_angled || light_face_estimate(face, p) < 0.5f * SOLID_ANGLE_MIN) return false;
    vec3 d = v3_sub(face->corner, p);
    rectangle->x0 = v3_dot(d, face->x);
    rectangle->y0 = v3_dot(d, face->y);
    rectangle->z0 = v3_dot(d, face->n);
    rectangle->x1 = rectangle->x0 + face->length_u;
    rectangle->y1 = rectangle->y0 + face->length_v;
    float x0 = rectangle->x0, x1 = rectangle->x1, y0 = rectangle->y0, y1 = rectangle->y1,
          z0 = rectangle->z0;
    struct angle left = angle_difference(corner_angle(x0, y1, z0), corner_angle(x0, y0, z0));
    struct angle right = angle_difference(corner_angle(x1, y1, z0), corner_angle(x1, y0, z0));
    float scale = -1.0f / sqrtf(left.c * left.c + left.s * left.s);  // rotated by pi
    rectangle->k = (struct angle){left.c * scale, left.s * scale};
    struct angle all = angle_difference(right, left);
    rectangle->solid_angle = atan2f(all.s, all.c);
    if (rectangle->solid_angle < 0.0f) rectangle->solid_angle += 2.0f * PI_F;
    rectangle->b0 = -y0 / sqrtf(z0 * z0 + y0 * y0);
    rectangle->b1 = y1 / sqrtf(z0 * z0 + y1 * y1);
    return rectangle->solid_angle > SOLID_ANGLE_MIN;
}

// The density over solid angle at p of drawing q uniformly by area.
static float area_pdf(const struct light_face *face, vec3 p, vec3 q) {
    vec3 d = v3_sub(p, q);
    float d2 = v3_len2(d), cosine = v3_dot(d, face->n) / sqrtf(d2);
    return cosine > 0.0f ? d2 / (face->area * cosine) : 0.0f;
}

// Draws q by area, along a strip by the angle that its length subtends. False if p has no light of
// it.
static bool area_sample(const struct light_face *face, vec3 p, float u, float v, vec3 *q,
                        float *pdf_w) {
    struct light_line strip;
    float density = 1.0f;  // over area, times the area
    if (strip_make(face, p, &strip)) {
        if (!light_line_make(strip.length, strip.foot, strip.away, &strip)) return false;
        float *along = longer_by_u(face) ? &u : &v;
        const float at = light_line_sample(&strip, *along);
        density = strip.length * light_line_density(&strip, at);
        *along = at / strip.length;
    }
    *q = v3_mad(v3_mad(face->corner, u, face->edge_u), v, face->edge_v);
    *pdf_w = density * area_pdf(face, p, *q);
    return *pdf_w > 0.0f && isfinite(*pdf_w);
}

// The density over solid angle at p of drawing q by area_sample.
static float area_sample_pdf(const struct light_face *face, vec3 p, vec3 q) {
    const float uniform = area_pdf(face, p, q);
    struct light_line strip;
    if (!strip_make(face, p, &strip)) return uniform;
    if (!light_line_make(strip.length, strip.foot, strip.away, &strip)) return 0.0f;
    const vec2 st = light_face_coordinates(face, q);
    const float at = strip.length * (longer_by_u(face) ? st.x : st.y);
    return uniform * strip.length * light_line_density(&strip, at);
}

// Does what light_face_sample does, without the texture.
static bool plain_sample(const struct light_face *face, vec3 p, float u, float v, vec3 *q,
                         float *pdf_w) {
    struct spherical_rectangle w;
    if (!spherical_rectangle_make(face, p, &w)) return area_sample(face, p, u, v, q, pdf_w);
    // The plane x = xu through the point's y axis below which lies the fraction u of the solid
    // angle.
    float cut = u * w.solid_angle;
    struct angle phi = angle_sum((struct angle){cosf(cut), sinf(cut)}, w.k);
    float f = (phi.c * w.b0 - w.b1) / phi.s;
    float c = clampf(copysignf(1.0f, f) / sqrtf(f * f + w.b0 * w.b0), -1.0f, 1.0f);
    float xu = clampf(-c * w.z0 / safe_sqrtf(1.0f - c * c), w.x0, w.x1);
    // The height in that plane, uniform in its sine.
    float d2 = xu * xu + w.z0 * w.z0;
    float h0 = w.y0 / sqrtf(d2 + w.y0 * w.y0), h1 = w.y1 / sqrtf(d2 + w.y1 * w.y1);
    float h = h0 + v * (h1 - h0), rest = 1.0f - h * h;
    float yv = rest > 1e-6f ? clampf(h * sqrtf(d2 / rest), w.y0, w.y1) : (h > 0.0f ? w.y1 : w.y0);
    *q = v3_mad(v3_mad(face->corner, xu - w.x0, face->x), yv - w.y0, face->y);
    *pdf_w = 1.0f / w.solid_angle;
    return true;
}

static float plain_pdf(const struct light_face *face, vec3 p, vec3 q) {
    struct spherical_rectangle rectangle;
    return spherical_rectangle_make(face, p, &rectangle) ? 1.0f / rectangle.solid_angle
                                                         : area_sample_pdf(face, p, q);
}

// The density of the mixture of plain samples and of those by the texture's grid.
static float face_mixed_pdf(const struct light_face *face, vec3 p, vec3 q, vec2 st, float plain) {
    const float by_grid = area_pdf(face, p, q) * light_texels_density(face, st);
    return lerpf(plain, by_grid, face->grid);
}

bool light_face_sample(const struct light_face *face, vec3 p, float u, float v, vec3 *q,
                       float *pdf_w) {
    if (!(v3_dot(v3_sub(p, face->corner), face->n) > 0.0f)) return false;
    if (!(face->grid > 0.0f)) return plain_sample(face, p, u, v, q, pdf_w);
    if (u < face->grid) {
        const vec2 st = light_texels_sample(face, u / face->grid, v);
        *q = v3_mad(v3_mad(face->corner, st.x, face->edge_u), st.y, face->edge_v);
        *pdf_w = face_mixed_pdf(face, p, *q, st, plain_pdf(face, p, *q));
    } else {
        if (!plain_sample(face, p, (u - face->grid) / (1.0f - face->grid), v, q, pdf_w))
            return false;
        *pdf_w = face_mixed_pdf(face, p, *q, light_face_coordinates(face, *q), *pdf_w);
    }
    return *pdf_w > 0.0f && isfinite(*pdf_w);
}

float light_face_pdf(const struct light_face *face, vec3 p, vec3 q) {
    if (!(v3_dot(v3_sub(p, face->corner), face->n) > 0.0f)) return 0.0f;
    const float plain = plain_pdf(face, p, q);
    if (!(face->grid > 0.0f)) return plain;
    return face_mixed_pdf(face, p, q, light_face_coordinates(face, q), plain);
}

vec2 light_face_coordinates(const struct light_face *face, vec3 q) {
    // By the dual basis of the edges.
    vec3 d = v3_sub(q, face->corner), normal = v3_cross(face->edge_u, face->edge_v);
    float scale = 1.0f / v3_len2(normal);
    return (vec2){v3_dot(v3_cross(d, face->edge_v), normal) * scale,
                  v3_dot(v3_cross(face->edge_u, d), normal) * scale};
}

vec2 light_face_uv(const struct light_face *face, const struct mesh *mesh, float s, float t) {
    bool far = s + t > 1.0f;
    const uint32_t *vertex = face->vertex + (far ? 3 : 0);
    float b1 = far ? 1.0f - s : s, b2 = far ? 1.0f - t : t;
    // The far triangle has +v before +u: 1 - s is the weight of +v, and 1 - t that of +u.
    float b0 = 1.0f - b1 - b2;
    const float *uv = mesh->uv;
    const float *p = uv + 2 * (size_t)vertex[0], *q = uv + 2 * (size_t)vertex[1],
                *r = uv + 2 * (size_t)vertex[2];
    return (vec2){b0 * p[0] + b1 * q[0] + b2 * r[0], b0 * p[1] + b1 * q[1] + b2 * r[1]};
}
