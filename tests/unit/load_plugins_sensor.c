// SPDX-License-Identifier: Apache-2.0
// The camera of a scene without a <sensor>.
#include "scene/scene.h"
#include "scene_case.h"

#define BOX                                                                    \
    "<shape type='cube'><transform name='to_world'><scale x='1' y='2' z='8'/>" \
    "<translate x='3' y='1' z='10'/></transform></shape>"

// A box of 2 x 4 x 16 around (3, 1, 10): 45 degrees hold its front, 4 wide, from 2 / tan(22.5
// degrees) before it.
static void a_scene_without_a_sensor_gets_a_camera(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, "<scene version='3.0.0'>" BOX "</scene>");
    assert_non_null(scene);
    assert_int_equal(c.warnings, 1);
    assert_string_equal(c.warning,
                        "scene.xml:1:1: the scene has no <sensor>: a camera in front of it looks "
                        "along +z");
    const struct camera *camera = &scene->camera;
    assert_float_equal(camera->to_world.m[0][3], 3.0f, 1e-6f);
    assert_float_equal(camera->to_world.m[1][3], 1.0f, 1e-6f);
    assert_float_equal(camera->to_world.m[2][3], 2.0f - 4.828427f, 1e-5f);
    assert_float_equal(camera->tan_x, .41421356f, 1e-6f);
    assert_float_equal(camera->tan_y, .31066017f, 1e-6f);
    assert_true(camera->near_clip < 4.8f && camera->far_clip > 4.83f + 16.0f);
    assert_true(scene->film.width == 768 && scene->film.height == 576);
    assert_int_equal(satin_scene_sensor_count(scene), 1);
    satin_scene_free(scene);
}

static void a_wanted_sensor_is_not_made_up(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = NULL;
    const struct log log = scene_case_begin(&c);
    const satin_scene_request request = {.sensor = "left"};
    scene_case_file("scene.xml", "<scene version='3.0.0'>" BOX "</scene>");
    assert_int_equal(satin_scene_load_request("scene.xml", &request, log.fn, log.user, &scene),
                     SATIN_ERROR_INPUT);
    assert_string_equal(c.error, "scene.xml:1:1: the scene has no sensor 'left': it has none");
}

static void an_empty_scene_without_a_sensor_is_refused(void **state) {
    (void)state;
    struct scene_case c;
    assert_null(scene_case_load(&c, "<scene version='3.0.0'/>"));
    assert_string_equal(c.error, "scene.xml:1:1: the scene has no <sensor>");
    assert_int_equal(c.errors, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_without_a_sensor_gets_a_camera),
        cmocka_unit_test(a_wanted_sensor_is_not_made_up),
        cmocka_unit_test(an_empty_scene_without_a_sensor_is_refused),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
