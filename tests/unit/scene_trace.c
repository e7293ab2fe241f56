// SPDX-License-Identifier: Apache-2.0
// Ray queries: they agree with each other and with exact values, accept every ray, and report
// invalid shapes.
#include "mesh_case.h"
#include "test_scene.h"

static struct test_scene scene_trace_table;

static struct ray ray_between(vec3 from, vec3 to) {
    return (struct ray){from, 0.0f, v3_unit(v3_sub(to, from)), INFINITY};
}

// A room with one shape of each kind in it.
static int make_room(void **state) {
    (void)state;
    test_scene_init(&scene_trace_table);
    uint32_t plain = test_diffuse(&scene_trace_table, .5f, .5f, .5f),
             brushed = test_diffuse(&scene_trace_table, .5f, .5f, .5f);
    scene_trace_table.material[brushed].tangent = scene_trace_table.material[brushed].filtered =
        true;
    test_cube(&scene_trace_table, test_transform(v3(0, 0, 0), v3(10, 10, 10)), true, plain);
    test_quadric(&scene_trace_table, SHAPE_SPHERE, test_transform(v3(5, 0, 0), v3(2, 2, 2)), false,
                 brushed);
    test_quadric(&scene_trace_table, SHAPE_DISK, test_transform(v3(-5, 0, 0), v3(2, 2, 2)), true,
                 plain);
    test_quadric(&scene_trace_table, SHAPE_CYLINDER, test_transform(v3(0, 5, 0), v3(1, 1, 3)),
                 false, plain);
    test_rectangle(&scene_trace_table, test_transform(v3(0, -5, 0), v3(1, 2, 1)), brushed);
    test_scene_finish(&scene_trace_table);
    return 0;
}

static int free_room(void **state) {
    (void)state;
    test_scene_free(&scene_trace_table);
    return 0;
}

static void bounds_of_the_scene_are_right(void **state) {
    (void)state;
    assert_near3(scene_trace_table.scene.bounds_lo, v3(-10, -10, -10), 1e-5f);
    assert_near3(scene_trace_table.scene.bounds_hi, v3(10, 10, 10), 1e-5f);
    assert_float_equal(scene_trace_table.scene.radius, sqrtf(300.0f), 1e-4f);
    assert_int_equal(scene_trace_table.scene.triangle_count, 14);
}

// Values computed by hand for rays perpendicular to each shape.
static void interactions_are_complete(void **state) {
    (void)state;
    const struct {
        vec3 from, to, p, ng, u;
        vec2 uv;
        uint32_t shape, material;
    } known[] = {
        {{5, -9, 1},
         {5, 0, 1},
         {5, -1.7320508f, 1},
         {0, -.8660254f, .5f},
         {1, 0, 0},
         {.75f, 1 / 3.f},
         1,
         1},
        {{-4, 1, 8}, {-4, 1, 0}, {-4, 1, 0}, {0, 0, -1}, {1, 0, 0}, {.70710678f, .125f}, 2, 0},
        {{0, 0, 1}, {0, 5, 1}, {0, 4, 1}, {0, -1, 0}, {1, 0, 0}, {.75f, 1 / 3.f}, 3, 0},
        {{.5f, -6, 9}, {.5f, -6, 0}, {.5f, -6, 0}, {0, 0, 1}, {1, 0, 0}, {.75f, .25f}, 4, 1},
        {{1, -2, 4}, {1, -2, 9}, {1, -2, 10}, {0, 0, -1}, {1, 0, 0}, {.4f, .55f}, 0, 0},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct ray ray = ray_between(known[i].from, known[i].to);
        struct interaction s;
        assert_true(scene_intersect(&scene_trace_table.scene, &ray, &s));
        assert_int_equal(s.shape, known[i].shape);
        assert_int_equal(s.material, known[i].material);
        assert_int_equal(s.light, -1);
        assert_near3(s.p, known[i].p, 2e-6f);
        assert_near3(s.ng, known[i].ng, 1e-6f);
        assert_near3(s.frame.n, known[i].ng, 1e-6f);
        if (known[i].material == 1) assert_near3(s.frame.u, known[i].u, 1e-6f);
        assert_float_equal(s.uv.x, known[i].uv.x, 1e-6f);
        assert_float_equal(s.uv.y, known[i].uv.y, 1e-6f);
        assert_near3(v3_mad(ray.o, s.t, ray.d), s.p, 1e-5f);
    }
}

static void queries_agree_with_each_other(void **state) {
    (void)state;
    struct rng rng = rng_make(1, RNG_TEST, 0);
    int hits[5] = {0};
    for (int i = 0; i < 20000; i++) {
        vec3 a = v3(18 * rng_float(&rng) - 9, 18 * rng_float(&rng) - 9, 18 * rng_float(&rng) - 9);
        vec3 b = v3(18 * rng_float(&rng) - 9, 18 * rng_float(&rng) - 9, 18 * rng_float(&rng) - 9);
        struct ray ray = ray_between(a, b);
        struct interaction s;
        assert_true(scene_intersect(&scene_trace_table.scene, &ray, &s));
        hits[s.shape]++;
        assert_true(scene_distance(&scene_trace_table.scene, &ray) == s.t);
        assert_true(scene_occluded(&scene_trace_table.scene, &ray));
        assert_near3(v3_mad(ray.o, s.t, ray.d), s.p, 1e-4f);
        assert_true(v3_dot(s.ng, s.frame.n) > 0.999f);
        ray.tfar = s.t * 0.999f;
        assert_false(scene_occluded(&scene_trace_table.scene, &ray));
        assert_true(isinf(scene_distance(&scene_trace_table.scene, &ray)));
        ray.tfar = s.t * 1.001f;
        assert_true(scene_occluded(&scene_trace_table.scene, &ray));
        ray.tnear = s.t * 1.0005f;
        assert_true(isinf(scene_distance(&scene_trace_table.scene, &ray)) ||
                    scene_distance(&scene_trace_table.scene, &ray) > s.t);
    }
    for (int i = 0; i < 5; i++) assert_true(hits[i] > 50);
}

static void every_ray_is_harmless(void **state) {
    (void)state;
    struct rng rng = rng_make(2, RNG_TEST, 0);
    for (int i = 0; i < 50000; i++) {
        union {
            uint32_t bits[8];
            struct ray ray;
        } any;
        for (int k = 0; k < 8; k++) any.bits[k] = rng_u32(&rng);
        struct interaction s;
        bool hit = scene_intersect(&scene_trace_table.scene, &any.ray, &s);
        assert_true(hit == isfinite(scene_distance(&scene_trace_table.scene, &any.ray)));
        if (hit) assert_true(v3_finite(s.p) && v3_finite(s.ng) && v3_finite(s.frame.u));
    }
    const struct ray none[] = {
        {{0, 0, 0}, 0, {0, 0, 0}, INFINITY},   {{0, 0, 0}, 0, {NAN, 0, 0}, INFINITY},
        {{0, 0, 0}, 0, {0, INFINITY, 0}, 10},  {{NAN, 0, 0}, 0, {0, 0, 1}, INFINITY},
        {{0, 2e18f, 0}, 0, {0, -1, 0}, 4e18f}, {{0, 0, 0}, -1, {0, 0, 1}, INFINITY},
        {{0, 0, 0}, NAN, {0, 0, 1}, INFINITY}, {{0, 0, 0}, 0, {0, 0, 1}, NAN},
        {{0, 0, 0}, 5, {0, 0, 1}, 5},          {{0, 0, 0}, 0, {0, 0, 1}, -INFINITY},
    };
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        struct interaction s;
        assert_false(scene_intersect(&scene_trace_table.scene, &none[i], &s));
        assert_false(scene_occluded(&scene_trace_table.scene, &none[i]));
        assert_true(isinf(scene_distance(&scene_trace_table.scene, &none[i])));
    }
}

static void an_empty_scene_is_built(void **state) {
    (void)state;
    struct satin_scene empty = {0};
    assert_int_equal(scene_trace_build(&empty, (struct log){0}), SATIN_OK);
    struct ray ray = ray_between(v3(0, 0, 0), v3(1, 0, 0));
    assert_false(scene_occluded(&empty, &ray));
    assert_true(empty.radius > 0.0f);
    scene_trace_free(empty.trace);
    scene_trace_free(NULL);
}

static void degenerate_shapes_are_refused(void **state) {
    (void)state;
    struct shape flat = {.kind = SHAPE_DISK, .name = "plate"};
    struct satin_scene scene = {.shape = &flat, .shape_count = 1};
    struct scene_case c;
    assert_int_equal(scene_trace_build(&scene, scene_case_begin(&c)), SATIN_ERROR_INPUT);
    assert_string_equal(c.error, "shape 'plate' has a degenerate transform");
    assert_null(scene.trace);
}

// Texture coordinates per length: the root of the ratio of areas, where it is requested.
static void the_rate_of_coordinates_is_measured(void **state) {
    (void)state;
    const struct {
        vec3 to;
        float rate;
    } known[] = {{{0.1f, -5, 0}, 0.353553f},  // 2 x 4 for 1 x 1
                 {{5, 0, 0.01f}, 0.112540f},  // 1 / sqrt(2 pi r pi r), r = 2, at its equator
                 {{-5, 0.1f, 0.1f}, 0.0f}};   // not requested
    for (int i = 0; i < 3; i++) {
        struct interaction s;
        struct ray ray =
            ray_between(v3(known[i].to.x, known[i].to.y, known[i].to.z + 4), known[i].to);
        if (i == 1) ray = ray_between(v3(0, 0, 0), known[i].to);
        assert_true(scene_intersect(&scene_trace_table.scene, &ray, &s));
        assert_float_equal(s.uv_rate, known[i].rate, 1e-4f);
        assert_true(s.footprint == 0.0f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_of_the_scene_are_right),
        cmocka_unit_test(interactions_are_complete),
        cmocka_unit_test(queries_agree_with_each_other),
        cmocka_unit_test(every_ray_is_harmless),
        cmocka_unit_test(the_rate_of_coordinates_is_measured),
        cmocka_unit_test(an_empty_scene_is_built),
        cmocka_unit_test(degenerate_shapes_are_refused),
    };
    return cmocka_run_group_tests(tests, make_room, free_room);
}
