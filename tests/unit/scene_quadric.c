// SPDX-License-Identifier: Apache-2.0
// Spheres, disks and cylinders against their equations, under transforms that rotate, stretch and
// mirror, from far away and from close by.
#include "scene/scene_quadric.h"

#include "base/sampling.h"
#include "mesh_case.h"

static struct quadric quadric_of_kind(enum shape_kind kind, struct mat4 m, bool flip) {
    struct shape shape = {.kind = kind, .flip_normals = flip};
    struct quadric q;
    assert_true(scene_shape_transform(&shape, &m));
    assert_true(scene_quadric_make(&shape, 3, &q));
    assert_int_equal(q.shape, 3);
    return q;
}

// The distance of p from the surface, in object space, by the equation's value in double.
static double off_surface(enum shape_kind kind, const struct mat4 *m, vec3 p) {
    struct mat4 inverse;
    assert_true(mat4_inverse(m, &inverse));
    vec3 l = mat4_point(&inverse, p);
    double r = hypot(l.x, l.y);
    if (kind == SHAPE_SPHERE) return fabs(sqrt(r * r + (double)l.z * l.z) - 1.0);
    if (kind == SHAPE_DISK) return fmax(fabs(l.z), r - 1.0);
    return fmax(fabs(r - 1.0), fmax(-l.z, l.z - 1.0));
}

static void rays_hit_quadrics_exactly(void **state) {
    (void)state;
    static const enum shape_kind kinds[3] = {SHAPE_SPHERE, SHAPE_DISK, SHAPE_CYLINDER};
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < 300; i++) {
        enum shape_kind kind = kinds[i % 3];
        float s = 1.0f + rng_float(&rng), x = kind == SHAPE_SPHERE ? s : s * 0.3f;
        vec3 axis = v3(rng_float(&rng), rng_float(&rng), rng_float(&rng) + 0.1f);
        struct mat4 rotation = mat4_rotate(axis, 360 * rng_float(&rng));
        struct mat4 scale = mat4_scale(v3(i & 1 ? -x : x, s, s));
        struct mat4 move = mat4_translate(v3(3 * rng_float(&rng), 0, 2)), m;
        m = mat4_mul(&rotation, &scale);
        m = mat4_mul(&move, &m);
        struct quadric q = quadric_of_kind(kind, m, i & 2);
        vec3 lo, hi;
        scene_quadric_bounds(&q, &lo, &hi);
        int hits = 0;
        for (int k = 0; k < 200; k++) {
            float far = k & 1 ? 1000.0f : 3.0f;
            vec3 target = mat4_point(&m, v3(0.4f * rng_float(&rng), 0.4f * rng_float(&rng), 0.3f));
            vec3 d = sample_uniform_sphere(rng_float(&rng), rng_float(&rng));
            struct ray ray = {v3_mad(target, -far, d), 0.0f, d, INFINITY};
            float t;
            if (!scene_quadric_intersect(&q, ray.o, ray.d, 0.0f, INFINITY, &t)) continue;
            hits++;
            struct interaction s2;
            scene_quadric_interaction(&q, &ray, t, k & 2, &s2);
            assert_true(off_surface(kind, &m, s2.p) < 4e-6);
            assert_near3(v3_mad(ray.o, t, ray.d), s2.p, 4e-7f * far + 2e-5f);
            assert_float_equal(v3_len(s2.ng), 1.0f, 1e-6f);
            assert_float_equal(v3_dot(s2.frame.u, s2.frame.n), 0.0f, 1e-6f);
            assert_true(s2.uv.x >= 0 && s2.uv.x <= 1 && s2.uv.y >= 0 && s2.uv.y <= 1);
            assert_true(s2.p.x >= lo.x && s2.p.y >= lo.y && s2.p.z >= lo.z);
            assert_true(s2.p.x <= hi.x && s2.p.y <= hi.y && s2.p.z <= hi.z);
            // It is the nearest crossing, and the limits are respected.
            float other;
            assert_false(scene_quadric_intersect(&q, ray.o, ray.d, 0.0f, t * 0.99999f, &other));
            if (scene_quadric_intersect(&q, ray.o, ray.d, t * 1.00001f, INFINITY, &other))
                assert_true(other > t);
        }
        assert_true(hits > 50);
    }
}

// The front of a sphere and a cylinder is outside, of a disk its +z; a reflection puts the sphere's
// only, as in Mitsuba.
static void scene_quadric_faces_as_mitsuba(void **state) {
    (void)state;
    for (int mirror = 0; mirror < 2; mirror++)
        for (int flip = 0; flip < 2; flip++) {
            struct mat4 m = mat4_scale(v3(mirror ? -1 : 1, 1, 1));
            struct ray down = {{0.3f, 0.2f, 5}, 0, {0, 0, -1}, INFINITY};
            struct ray side = {{5, 0.2f, 0.5f}, 0, {-1, 0, 0}, INFINITY};
            struct interaction s;
            struct quadric sphere = quadric_of_kind(SHAPE_SPHERE, m, flip);
            scene_quadric_interaction(&sphere, &down, 4, false, &s);
            assert_true((s.ng.z > 0) == (mirror == flip));
            struct quadric disk = quadric_of_kind(SHAPE_DISK, m, flip);
            scene_quadric_interaction(&disk, &down, 5, false, &s);
            assert_true((s.ng.z > 0) == !flip);
            struct quadric cylinder = quadric_of_kind(SHAPE_CYLINDER, m, flip);
            scene_quadric_interaction(&cylinder, &side, 4, false, &s);
            assert_true((s.ng.x > 0) == !flip);
        }
}

static void flat_transforms_are_refused(void **state) {
    (void)state;
    struct shape shape = {.kind = SHAPE_SPHERE};
    struct mat4 flat = mat4_scale(v3(1, 1, 0));
    struct quadric q;
    assert_false(scene_shape_transform(&shape, &flat));
    shape.to_world = mat4_identity();
    assert_false(scene_quadric_make(&shape, 0, &q));  // no radius
    shape.kind = SHAPE_DISK;
    assert_true(scene_quadric_make(&shape, 0, &q));
    shape.to_world = flat;
    assert_false(scene_quadric_make(&shape, 0, &q));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_hit_quadrics_exactly),
        cmocka_unit_test(scene_quadric_faces_as_mitsuba),
        cmocka_unit_test(flat_transforms_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
