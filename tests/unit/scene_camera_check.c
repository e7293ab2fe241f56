// SPDX-License-Identifier: Apache-2.0
// A table of cameras that see nothing, each with the reason.
#include "scene/scene.h"
#include "scene_case.h"

#define EYE                                                                                      \
    "<transform name='to_world'><lookat origin='0 0 20' target='0 0 0' up='0 1 0'/></transform>" \
    "<film type='hdrfilm'><integer name='width' value='64'/>"                                    \
    "<integer name='height' value='64'/>"
#define EYE_END "</film></sensor>"
#define PERSPECTIVE "<sensor type='perspective'>" EYE
#define ORTHOGRAPHIC "<sensor type='orthographic'>" EYE
#define FAR(far) "<float name='far_clip' value='" far "'/>"
#define NEAR(near) "<float name='near_clip' value='" near "'/>"
#define BALL "<shape type='sphere'><float name='radius' value='.5'/></shape>"
#define LAMP "<emitter type='point'/>"
#define SKY "<emitter type='constant'/>"

static const struct {
    const char *scene, *warning;  // NULL: none
} scene_camera_check_cases[] = {
    {PERSPECTIVE EYE_END LAMP BALL, NULL},
    {PERSPECTIVE EYE_END SKY, NULL},
    {PERSPECTIVE EYE_END LAMP, "the scene has no shapes: nothing is seen"},
    {PERSPECTIVE EYE_END BALL, "the scene emits no light: the image is black"},
    {"<sensor type='perspective'>" FAR("19") EYE EYE_END LAMP BALL,
     "far_clip 19 lies before the scene, which begins at 19.5*: no shape is seen"},
    {"<sensor type='perspective'>" FAR("19") EYE EYE_END SKY BALL,
     "far_clip 19 lies before the scene, which begins at 19.5*: no shape is seen"},
    {"<sensor type='perspective'>" FAR("19.6") EYE EYE_END LAMP BALL, NULL},
    {"<sensor type='perspective'>" NEAR("21") EYE EYE_END LAMP BALL,
     "near_clip 21 lies behind the scene, which ends at 19.*: no shape is seen"},
    {"<sensor type='orthographic'>" FAR("19") EYE EYE_END LAMP BALL,
     "far_clip 19 lies before the scene, which begins at 19.5*: no shape is seen"},
    {ORTHOGRAPHIC EYE_END LAMP BALL, NULL},
    {"<sensor type='telecentric'><float name='aperture_radius' value='.1'/>" FAR("19")
         EYE EYE_END LAMP BALL,
     "far_clip 19 lies before the scene, which begins at 19.5*: no shape is seen"},
    {"<sensor type='telecentric'><float name='aperture_radius' value='.1'/>" EYE EYE_END LAMP BALL,
     NULL},
    {"<sensor type='perspective'>" FAR("40") NEAR("30") EYE EYE_END LAMP BALL
     "<shape type='disk'><transform name='to_world'><translate x='4' z='-25'/></transform></shape>",
     "no shape is seen between near_clip 30 and far_clip 40: the first begins at 19.5*"},
    {PERSPECTIVE EYE_END LAMP "<shape type='sphere'><point name='center' value='0 0 30'/></shape>",
     "none of 1024 camera rays hits a shape: the scene is behind it"},
    {PERSPECTIVE EYE_END SKY "<shape type='sphere'><point name='center' value='0 0 30'/></shape>",
     NULL},
    {PERSPECTIVE EYE_END LAMP "<shape type='sphere'><point name='center' value='90 0 0'/></shape>",
     "none of 1024 camera rays hits a shape"},
    {"<sensor type='spherical'>" EYE EYE_END LAMP
     "<shape type='sphere'><point name='center' value='0 0 30'/></shape>",
     NULL},
    // The crop window alone counts.
    {PERSPECTIVE
     "<integer name='crop_width' value='8'/><integer name='crop_height' value='8'/>" EYE_END LAMP
         BALL,
     "none of 1024 camera rays hits a shape"},
};

// Whether two texts are equal, or equal around a `*` of `pattern`.
static bool scene_camera_check_matches(const char *pattern, const char *text) {
    const char *star = strchr(pattern, '*');
    if (!star) return strcmp(pattern, text) == 0;
    const size_t before = (size_t)(star - pattern), after = strlen(star + 1), n = strlen(text);
    return n >= before + after && memcmp(pattern, text, before) == 0 &&
           strcmp(text + n - after, star + 1) == 0;
}

static void each_wrong_camera_has_its_reason(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof scene_camera_check_cases / sizeof *scene_camera_check_cases;
         i++) {
        char text[2048];
        struct scene_case c;
        snprintf(text, sizeof text, "<scene version='3.0.0'>%s</scene>",
                 scene_camera_check_cases[i].scene);
        satin_scene *scene = scene_case_load(&c, text);
        assert_non_null(scene);
        const bool warned = scene_camera_check(scene, &scene->camera, scene_case_begin(&c));
        assert_int_equal(warned, scene_camera_check_cases[i].warning != NULL);
        if (!scene_camera_check_cases[i].warning) {
            assert_int_equal(c.warnings, 0);
        } else if (c.warnings != 1 ||
                   !scene_camera_check_matches(scene_camera_check_cases[i].warning, c.warning)) {
            fail_msg("expected: %s\n  got %d: %s", scene_camera_check_cases[i].warning, c.warnings,
                     c.warning);
        }
        assert_int_equal(c.errors, 0);
        satin_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_wrong_camera_has_its_reason)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
