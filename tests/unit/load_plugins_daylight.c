// SPDX-License-Identifier: Apache-2.0
// The sun of <emitter type="sunsky"> stands where that of Mitsuba 3.9 stands, and scenes of version
// 0.6 without lights have one.
#include "light/light.h"
#include "scene_case.h"

// The direction to the sun of an emitter `sunsky` with these parameters.
static vec3 sun_of(const char *parameters) {
    char text[512];
    snprintf(text, sizeof text, SCENE_TEXT("<emitter type='sunsky'>%s</emitter>"), parameters);
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    const vec3 sun = scene->light[scene->environment].sun;
    satin_scene_free(scene);
    return sun;
}

// Mitsuba's directions are found by searching the bright disc of its emitter in steps of half a
// degree.
static void the_sun_stands_as_the_date_says(void **state) {
    (void)state;
    const vec3 afternoon = sun_of(""), morning = sun_of("<float name='hour' value='9'/>");
    assert_true(v3_dist2(afternoon, v3(.0514f, .6918f, .7202f)) < 1e-4f);
    assert_true(v3_dist2(morning, v3(.0957f, -.6149f, .7828f)) < 1e-4f);
}

#define LYING "<transform name='to_world'><rotate x='1' angle='-90'/></transform>"

static void a_given_direction_is_in_world_space(void **state) {
    (void)state;
    const vec3 dated = sun_of(LYING),
               given = sun_of(LYING "<vector name='sun_direction' x='.6' y='.8' z='0'/>");
    assert_true(v3_dist2(dated, v3(.0514f, .7202f, -.6918f)) < 1e-4f);
    assert_true(v3_dist2(given, v3(.6f, .8f, 0.0f)) < 1e-6f);
}

static void a_time_beside_a_direction_has_no_effect(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<emitter type='sunsky'><float name='hour' value='99'/>"
                       "<vector name='sun_direction' x='0' y='1' z='0'/></emitter>"));
    assert_non_null(scene);
    assert_string_equal(c.warning,
                        "scene.xml:3:24: 'hour' has no effect, as sun_direction is given");
    satin_scene_free(scene);
}

static void a_scene_of_version_06_without_emitters_has_daylight(void **state) {
    (void)state;
    static const char *const body = "<shape type='cube'/><sensor type='perspective'/></scene>";
    char text[256];
    struct scene_case c;
    snprintf(text, sizeof text, "<scene version='0.6.0'>%s", body);
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    assert_int_equal(c.warnings, 1);
    assert_string_equal(c.warning,
                        "scene.xml:1:1: the scene has no <emitter>: it has the daylight of "
                        "`sunsky`, as in version 0.6");
    assert_true(scene->environment == 0 && scene->light[0].sun.y > 0.5f);
    satin_scene_free(scene);
    snprintf(text, sizeof text, "<scene version='3.0.0'>%s", body);
    scene = scene_case_load(&c, text);
    assert_non_null(scene);
    assert_int_equal(scene->light_count, 0);
    satin_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sun_stands_as_the_date_says),
        cmocka_unit_test(a_given_direction_is_in_world_space),
        cmocka_unit_test(a_time_beside_a_direction_has_no_effect),
        cmocka_unit_test(a_scene_of_version_06_without_emitters_has_daylight),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
