// SPDX-License-Identifier: Apache-2.0
// Coincident shapes: all except the first are left out of the ray tracing structure, so that a ray
// tests one surface for any number of them.
#include "scene/scene_coincide.h"

#include "scene_case.h"
#include "test_scene.h"

static struct test_scene scene_coincide_table;

static uint32_t find(bool hidden[TEST_SHAPES]) {
    uint32_t found;
    assert_true(scene_coincide_find(&scene_coincide_table.scene, 0,
                                    scene_coincide_table.scene.shape_count, 0, hidden, &found));
    return found;
}

static void every_kind_of_coincidence_is_found(void **state) {
    (void)state;
    test_scene_init(&scene_coincide_table);
    const uint32_t white = test_diffuse(&scene_coincide_table, .5f, .5f, .5f),
                   red = test_diffuse(&scene_coincide_table, .5f, 0, 0);
    const struct mat4 here = test_transform(v3(1, 2, 3), v3(2, 2, 2)),
                      there = test_transform(v3(1, 2, 4), v3(2, 2, 2));
    for (int copy = 0; copy < 2; copy++) {
        const uint32_t material = copy ? red : white;
        test_rectangle(&scene_coincide_table, here, material);
        test_cube(&scene_coincide_table, here, false, material);
        test_quadric(&scene_coincide_table, SHAPE_SPHERE, here, copy, material);
        test_quadric(&scene_coincide_table, SHAPE_DISK, here, copy, material);
        test_quadric(&scene_coincide_table, SHAPE_CYLINDER, here, copy, material);
    }
    test_rectangle(&scene_coincide_table, there, white);
    test_cube(&scene_coincide_table, there, false, white);
    test_quadric(&scene_coincide_table, SHAPE_SPHERE, there, false, white);
    test_quadric(&scene_coincide_table, SHAPE_DISK, there, false, white);
    test_quadric(&scene_coincide_table, SHAPE_CYLINDER, there, false, white);
    bool hidden[TEST_SHAPES];
    assert_int_equal(find(hidden), 5);
    for (uint32_t i = 0; i < 15; i++) assert_int_equal(hidden[i], i >= 5 && i < 10);

    // Rays hit the first shape: the sphere, from outside.
    test_scene_finish(&scene_coincide_table);
    struct interaction s;
    const struct ray ray = {v3(9, 2, 1.5f), 0.0f, v3(-1, 0, 0), INFINITY};
    assert_true(scene_intersect(&scene_coincide_table.scene, &ray, &s));
    assert_int_equal(s.shape, 1);
    test_scene_free(&scene_coincide_table);
}

static void holes_do_not_coincide(void **state) {
    (void)state;
    test_scene_init(&scene_coincide_table);
    const struct mat4 here = test_transform(v3(0, 0, 0), v3(1, 1, 1));
    const uint32_t open = test_material(&scene_coincide_table, "null", rgb_grey(0), rgb_grey(0));
    const uint32_t solid = test_diffuse(&scene_coincide_table, .5f, .5f, .5f);
    const uint32_t order[] = {open, open, solid, open, solid};
    for (int i = 0; i < 5; i++)
        test_quadric(&scene_coincide_table, SHAPE_SPHERE, here, false, order[i]);
    bool hidden[TEST_SHAPES];
    assert_int_equal(find(hidden), 1);
    assert_true(hidden[4]);
    test_scene_free(&scene_coincide_table);
}

static void a_hidden_lamp_gives_no_light(void **state) {
    (void)state;
    test_scene_init(&scene_coincide_table);
    const uint32_t white = test_diffuse(&scene_coincide_table, .5f, .5f, .5f);
    for (int i = 0; i < 2; i++) {
        const uint32_t lamp =
            test_quadric(&scene_coincide_table, SHAPE_SPHERE, mat4_identity(), false, white);
        test_area_light(&scene_coincide_table, lamp, rgb_grey(1.0f));
    }
    test_scene_finish(&scene_coincide_table);
    const struct light *light = scene_coincide_table.scene.light;
    assert_true(light[0].value.g == 1.0f && light[1].value.g == 0.0f);
    assert_true(light[1].power < 1e-6f * light[0].power);
    test_scene_free(&scene_coincide_table);
}

static void an_emitter_hides_what_coincides_with_it(void **state) {
    (void)state;
    test_scene_init(&scene_coincide_table);
    const uint32_t white = test_diffuse(&scene_coincide_table, .5f, .5f, .5f);
    uint32_t sphere[3];
    for (int i = 0; i < 3; i++)
        sphere[i] =
            test_quadric(&scene_coincide_table, SHAPE_SPHERE, mat4_identity(), false, white);
    test_area_light(&scene_coincide_table, sphere[1], rgb_grey(1.0f));
    bool hidden[TEST_SHAPES];
    assert_int_equal(find(hidden), 2);
    assert_true(hidden[sphere[0]] && !hidden[sphere[1]] && hidden[sphere[2]]);
    test_scene_free(&scene_coincide_table);
}

static void shapes_of_other_sizes_do_not_coincide(void **state) {
    (void)state;
    test_scene_init(&scene_coincide_table);
    const uint32_t white = test_diffuse(&scene_coincide_table, .5f, .5f, .5f);
    for (int i = 0; i < TEST_SHAPES; i++) {
        const float size = 1.0f + 0x1p-22f * (float)i;
        test_quadric(&scene_coincide_table, SHAPE_SPHERE,
                     test_transform(v3(0, 0, 0), v3(size, size, size)), false, white);
    }
    bool hidden[TEST_SHAPES];
    assert_int_equal(find(hidden), 0);
    scene_coincide_table.scene.shape_count = 1;
    assert_int_equal(find(hidden), 0);
    test_scene_free(&scene_coincide_table);
}

// A thousand spheres, and a group of two with two instances at one position.
static void coincidence_is_reported_once(void **state) {
    (void)state;
    enum { SPHERES = 1000 };
    static char text[SPHERES * 32 + 1024];
    size_t n = (size_t)snprintf(text, sizeof text, "<scene version=\"3.0.0\">\n%s",
                                "<sensor type=\"perspective\"/>"
                                "<shape type=\"shapegroup\" id=\"g\">"
                                "<shape type=\"disk\"/><shape type=\"disk\" id=\"twin\"/></shape>"
                                "<shape type=\"instance\"><ref id=\"g\"/></shape>"
                                "<shape type=\"instance\"><ref id=\"g\"/></shape>");
    for (int i = 0; i < SPHERES; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "<shape type=\"sphere\"/>");
    snprintf(text + n, sizeof text - n, "</scene>");
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    assert_int_equal(c.warnings, 1);
    assert_string_equal(c.warning,
                        "1001 of 1004 shapes lie exactly where earlier ones do, which hide them; "
                        "the first is shape 2, 'twin'");
    const struct ray ray = {v3(0, 0, 9), 0.0f, v3(0, 0, -1), INFINITY};
    struct interaction s;
    assert_true(scene_intersect(scene, &ray, &s));
    assert_int_equal(s.shape, 4);
    satin_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_of_coincidence_is_found),
        cmocka_unit_test(holes_do_not_coincide),
        cmocka_unit_test(a_hidden_lamp_gives_no_light),
        cmocka_unit_test(an_emitter_hides_what_coincides_with_it),
        cmocka_unit_test(shapes_of_other_sizes_do_not_coincide),
        cmocka_unit_test(coincidence_is_reported_once),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
