// SPDX-License-Identifier: Apache-2.0
// Rays that leave surfaces: none hits the surface that it leaves, none gets out of a closed body,
// at any scale and position. Then the shading data in the surface interaction of a triangle.
#include "base/sampling.h"
#include "mesh_case.h"
#include "test_scene.h"

// A closed bumpy ball of radius about 1, transformed, without vertex normals.
enum { ROWS = 40, COLUMNS = 80 };

static uint32_t add_ball(struct test_scene *t, struct mat4 m) {
    uint32_t vertices = (ROWS - 1) * COLUMNS + 2, count = 0;
    float *position = arena_array(&t->scene.arena, (size_t)vertices * 3 + 1, sizeof *position);
    uint32_t *index = arena_array(&t->scene.arena, ROWS * COLUMNS * 6, sizeof *index);
    assert_true(position && index);
    for (uint32_t i = 0; i < vertices; i++) {
        bool pole = i >= vertices - 2;
        uint32_t row = pole ? (i == vertices - 2 ? 0 : ROWS) : i / COLUMNS + 1;
        float theta = PI_F * (float)row / ROWS, phi = 2 * PI_F * (float)(i % COLUMNS) / COLUMNS;
        float r = pole ? 1.0f : 1.0f + 0.1f * sinf(6 * theta) * cosf(5 * phi) * sinf(theta);
        vec3 p = v3(r * sinf(theta) * cosf(phi), r * sinf(theta) * sinf(phi), r * cosf(theta));
        p = mat4_point(&m, p);
        memcpy(position + (size_t)i * 3, &p, sizeof p);
    }
    for (uint32_t j = 0; j < ROWS; j++)
        for (uint32_t i = 0; i < COLUMNS; i++) {
            uint32_t a = j ? (j - 1) * COLUMNS + i : vertices - 2;
            uint32_t b = j ? (j - 1) * COLUMNS + (i + 1) % COLUMNS : vertices - 2;
            uint32_t c = j + 1 < ROWS ? j * COLUMNS + i : vertices - 1;
            uint32_t d = j + 1 < ROWS ? j * COLUMNS + (i + 1) % COLUMNS : vertices - 1;
            const uint32_t upper[3] = {a, c, b}, lower[3] = {b, c, d};
            // At the poles one of the two has no area.
            if (j) memcpy(index + count, upper, sizeof upper), count += 3;
            if (j + 1 < ROWS) memcpy(index + count, lower, sizeof lower), count += 3;
        }
    struct shape s = {.kind = SHAPE_MESH,
                      .mesh = {.vertex_count = vertices,
                               .triangle_count = count / 3,
                               .position = position,
                               .index = index}};
    return test_add_shape(t, s);
}

static vec3 direction_around(vec3 n, struct rng *rng) {
    struct frame frame = frame_from_normal(n);
    float z = 1e-5f + 0.99998f * rng_float(rng), phi = 2 * PI_F * rng_float(rng);
    float q = safe_sqrtf(1.0f - z * z);
    return frame_to_world(&frame, v3(q * cosf(phi), q * sinf(phi), z));
}

// Shoots at the body from outside; from every hit rays go back out (none may hit the same convex
// surface, or for the ball the same triangle) and in (all must hit, from the inside, and go on).
static void check_body(struct test_scene *t, bool convex, int starts) {
    const struct satin_scene *scene = &t->scene;
    vec3 centre = v3_mul(v3_add(scene->bounds_lo, scene->bounds_hi), 0.5f);
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < starts; i++) {
        vec3 from = v3_mad(centre, 3.0f * scene->radius,
                           sample_uniform_sphere(rng_float(&rng), rng_float(&rng)));
        vec3 to = v3_mad(centre, 0.3f * scene->radius,
                         sample_uniform_sphere(rng_float(&rng), rng_float(&rng)));
        struct ray ray = {from, 0.0f, v3_unit(v3_sub(to, from)), INFINITY};
        struct interaction s, next;
        assert_true(scene_intersect(scene, &ray, &s));
        ray = scene_spawn(scene, s.p, s.ng, direction_around(s.ng, &rng));
        bool again = scene_intersect(scene, &ray, &next);
        assert_false(again && (convex || next.prim == s.prim));
        assert_true(again == scene_occluded(scene, &ray));
        for (int bounce = 0; bounce < 16; bounce++) {
            ray = scene_spawn(scene, s.p, s.ng, direction_around(v3_neg(s.ng), &rng));
            assert_true(scene_intersect(scene, &ray, &next));
            assert_true(v3_dot(next.ng, ray.d) > 0.0f);
            s = next;
        }
    }
}

static void rays_leave_surfaces_at_any_scale(void **state) {
    (void)state;
    static const float size[5] = {1.0f, 2.5e5f, 2.5e-3f, 1e-9f, 1e9f};
    static const vec3 position[3] = {{0, 0, 0}, {1, 1, 1}, {40, -70, 5}};
    for (int i = 0; i < 15; i++)
        for (int kind = 0; kind < 3; kind++) {
            float s = size[i / 3];
            struct mat4 rotation = mat4_rotate(v3(1, 2, 3), 33);
            struct mat4 m = test_transform(v3_mul(position[i % 3], s), v3(s, s, s));
            m = mat4_mul(&m, &rotation);
            static struct test_scene t;
            test_scene_init(&t);
            test_diffuse(&t, .5f, .5f, .5f);
            if (kind == 0) add_ball(&t, m);
            if (kind == 1) test_cube(&t, m, false, 0);
            if (kind == 2) test_quadric(&t, SHAPE_SPHERE, m, false, 0);
            test_scene_finish(&t);
            check_body(&t, kind != 0, 1000);
            test_scene_free(&t);
        }
}

// A cylinder is open: only rays that leave it outwards cannot hit it.
static void rays_leave_cylinders(void **state) {
    (void)state;
    static struct test_scene t;
    test_scene_init(&t);
    test_diffuse(&t, .5f, .5f, .5f);
    struct mat4 rotation = mat4_rotate(v3(1, 2, 3), 70),
                m = test_transform(v3(3, 2, 1), v3(4, 4, 90));
    m = mat4_mul(&rotation, &m);
    test_quadric(&t, SHAPE_CYLINDER, m, false, 0);
    test_scene_finish(&t);
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < 50000; i++) {
        vec3 d = sample_uniform_sphere(rng_float(&rng), rng_float(&rng));
        struct ray ray = {mat4_point(&m, v3(0.3f, 0.2f, 0.5f)), 0.0f, d, INFINITY};
        struct interaction s;
        if (!scene_intersect(&t.scene, &ray, &s)) continue;
        ray = scene_spawn(&t.scene, s.p, s.ng, direction_around(s.ng, &rng));
        assert_false(scene_occluded(&t.scene, &ray));
    }
    test_scene_free(&t);
}

// Next to the origin a floor of any size has huge triangles and tiny coordinates: an offset that
// grows with the triangles would leak through objects there, and one that does not would hit the
// floor again without the check in double.
static void rays_leave_huge_floors(void **state) {
    (void)state;
    for (float size = 1.0f; size < 1e8f; size *= 10.0f) {
        static struct test_scene t;
        test_scene_init(&t);
        test_diffuse(&t, .5f, .5f, .5f);
        struct mat4 rotation = mat4_rotate(v3(1, 2, 3), 33),
                    scale = mat4_scale(v3(size, size, size));
        test_rectangle(&t, mat4_mul(&rotation, &scale), 0);
        test_scene_finish(&t);
        vec3 n = mat4_vector(&rotation, v3(0, 0, 1));
        struct frame frame = frame_from_normal(n);
        struct rng rng = rng_make(1, RNG_TEST, 0);
        for (int i = 0; i < 20000; i++) {
            vec3 local = v3(2 * rng_float(&rng) - 1, 2 * rng_float(&rng) - 1, 1);
            struct ray ray = {frame_to_world(&frame, local), 0.0f, v3_neg(n), INFINITY};
            struct interaction s;
            if (!scene_intersect(&t.scene, &ray, &s)) continue;  // the two shrink by rounding
            ray = scene_spawn(&t.scene, s.p, s.ng, direction_around(s.ng, &rng));
            assert_false(scene_occluded(&t.scene, &ray));
            assert_true(v3_dist2(ray.o, s.p) < 1e-10f);
        }
        test_scene_free(&t);
    }
}

// Returns a point of a sheet of the scene, straight along n from a random point between the sheets.
static struct interaction point_of_sheet(const struct satin_scene *scene,
                                         const struct mat4 *rotation, vec3 n, float z,
                                         struct rng *rng) {
    vec3 local = v3(17.9f * rng_float(rng) - 8.95f, 17.9f * rng_float(rng) - 8.95f, z);
    struct ray ray = {mat4_point(rotation, local), 0.0f, n, INFINITY};
    struct interaction s;
    assert_true(scene_intersect(scene, &ray, &s));
    return s;
}

// Two sheets of any size face each other: every point of one is visible from every point of the
// other, and the ray ends before the other sheet; a sheet between them hides all.
static void points_are_connected(void **state) {
    (void)state;
    for (int run = 0; run < 6; run++) {
        const int blocked = run & 1;
        const float size = run < 2 ? 9.0f : run < 4 ? 900.0f : 9e4f;
        static struct test_scene t;
        test_scene_init(&t);
        test_diffuse(&t, .5f, .5f, .5f);
        struct mat4 rotation = mat4_rotate(v3(3, 1, 2), 77);
        for (int i = 0; i < 2 + blocked; i++) {
            struct mat4 m = test_transform(v3(0, 0,
                                              i == 0   ? 0
                                              : i == 1 ? 1
                                                       : .5f),
                                           v3(size, size, 1));
            test_rectangle(&t, mat4_mul(&rotation, &m), 0);
        }
        test_scene_finish(&t);
        vec3 n = mat4_vector(&rotation, v3(0, 0, 1));
        struct rng rng = rng_make(1, RNG_TEST, 0);
        for (int i = 0; i < 30000; i++) {
            struct interaction p = point_of_sheet(&t.scene, &rotation, v3_neg(n), 0.25f, &rng);
            struct interaction q = point_of_sheet(&t.scene, &rotation, n, 0.75f, &rng);
            struct ray ray = scene_spawn_to(&t.scene, p.p, p.ng, q.p, q.ng);
            assert_true(scene_occluded(&t.scene, &ray) == blocked);
            assert_float_equal(v3_len(v3_sub(v3_mad(ray.o, ray.tfar, ray.d), q.p)), 0.0f, 2e-5f);
            assert_true(scene_occluded(&t.scene, &(struct ray){ray.o, 0, ray.d, 2 * ray.tfar}));
        }
        test_scene_free(&t);
    }
}

static void shading_is_by_vertex_normals(void **state) {
    (void)state;
    // A triangle whose vertex normals are tilted, and point below the face at one corner.
    const float position[10] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const float normal[9] = {0, 0, 1, 0.6f, 0, 0.8f, 0.8f, 0, -0.6f};
    const float uv[6] = {0, 0, 0, 1, -1, 0};
    const uint32_t index[3] = {0, 1, 2};
    for (int flip = 0; flip < 2; flip++) {
        static struct test_scene t;
        test_scene_init(&t);
        test_diffuse(&t, .5f, .5f, .5f);
        t.material[0].tangent = true;
        float rotated[9];
        for (int i = 0; i < 9; i++) rotated[i] = flip ? -normal[i] : normal[i];
        test_add_shape(&t, (struct shape){.kind = SHAPE_MESH,
                                          .flip_normals = flip,
                                          .mesh = {.vertex_count = 3,
                                                   .triangle_count = 1,
                                                   .position = position,
                                                   .normal = rotated,
                                                   .uv = uv,
                                                   .index = index}});
        test_scene_finish(&t);
        float side = flip ? -1.0f : 1.0f;
        struct interaction s;
        struct ray ray = {{0.25f, 0.25f, 1}, 0, {0, 0, -1}, INFINITY};
        assert_true(scene_intersect(&t.scene, &ray, &s));
        vec3 n = v3_unit(v3(.25f * .6f + .25f * .8f, 0, .5f + .25f * .8f - .25f * .6f));
        assert_near3(s.frame.n, v3_mul(n, side), 1e-6f);
        assert_near3(s.ng, v3(0, 0, side), 0.0f);
        assert_float_equal(s.uv.x, -0.25f, 1e-6f);
        assert_float_equal(s.uv.y, 0.25f, 1e-6f);
        assert_near3(s.frame.u, v3(0, -1, 0), 1e-6f);  // u falls along y
        // Where the shading normal points below the face, it decides which side is the front.
        ray.o = v3(0.02f, 0.96f, 1);
        assert_true(scene_intersect(&t.scene, &ray, &s));
        assert_near3(s.ng, v3(0, 0, -side), 0.0f);
        assert_true(v3_dot(s.ng, s.frame.n) > 0.0f);
        test_scene_free(&t);
    }
}

// A point beside an edge goes off it by the margin; at a corner too, as far as the margin allows;
// one in the middle stays.
static void origins_are_shifted_off_edges(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, mat4_identity(), test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&t);
    const float margin = 0.01f;
    const vec3 position[] = {{0.3f, -0.999f, 1}, {-0.9995f, -0.9995f, 1}, {0.2f, -0.6f, 1}};
    for (int i = 0; i < 3; i++) {
        struct ray ray = {position[i], 0.0f, v3(0, 0, -1), INFINITY};
        struct interaction s;
        assert_true(scene_intersect(&t.scene, &ray, &s));
        vec3 p = scene_origin_shift(&t.scene, &s, margin);
        float moved = v3_len(v3_sub(p, s.p));
        assert_true(moved <= margin * 1.001f && fabsf(p.z) < 1e-6f);
        if (i == 0) assert_true(fabsf(p.y + 1.0f - margin) < 0.02f * margin && moved > 0.008f);
        if (i == 1) assert_true(p.x > s.p.x && p.y > s.p.y && moved > 0.005f);
        if (i == 2) assert_true(moved == 0.0f);
    }
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_leave_surfaces_at_any_scale),
        cmocka_unit_test(rays_leave_cylinders),
        cmocka_unit_test(origins_are_shifted_off_edges),
        cmocka_unit_test(rays_leave_huge_floors),
        cmocka_unit_test(points_are_connected),
        cmocka_unit_test(shading_is_by_vertex_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
