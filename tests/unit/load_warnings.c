// SPDX-License-Identifier: Apache-2.0
// Values that make no sense: each is one error, or one warning with its place; and how warnings are
// counted, or become errors.
#include "load/load_warnings.h"

#include "scene/scene.h"
#include "scene_case.h"

#define SPHERE(parts) "<shape type='sphere'>" parts "</shape>"
#define BSDF(type, parts) "<bsdf type='" type "'>" parts "</bsdf>"
#define FLOAT(name, value) "<float name='" name "' value='" value "'/>"
#define INTEGER(name, value) "<integer name='" name "' value='" value "'/>"
#define TO_WORLD(steps) "<transform name='to_world'>" steps "</transform>"
#define FILM(parts) "<sensor type='perspective'><film type='hdrfilm'>" parts "</film></sensor>"

// A line of a scene, and the message without its `scene.xml:3:COLUMN: `.
struct nonsense {
    const char *line, *message;
};

static const struct nonsense warned[] = {
    {BSDF("blendbsdf", FLOAT("weight", "2") "<bsdf type='diffuse'/><bsdf type='plastic'/>"),
     "weight is 2, which counts as 1"},
    {BSDF("mask", FLOAT("opacity", "-1") "<bsdf type='diffuse'/>"),
     "opacity is -1, which counts as 0"},
    {BSDF("mask", "<rgb name='opacity' value='0 1.5 2'/><bsdf type='diffuse'/>"),
     "opacity is 1.5, which counts as 1"},
    {BSDF("roughconductor", FLOAT("alpha_u", "0") FLOAT("alpha_v", ".1")),
     "a roughness of 0 counts as 0.0001"},
    {BSDF("roughplastic", FLOAT("alpha", "0")), "a roughness of 0 counts as 0.0001"},
    {BSDF("ward", FLOAT("alpha_v", "1e-5")), "a roughness of 1e-05 counts as 0.0001"},
    {"<shape type='cube'>" TO_WORLD(
         "<lookat origin='0 0 0' target='0 0 1' up='0 0 0'/>") "</shape>",
     "<lookat>: up is zero; one at right angles to the view is taken"},
    {"<shape type='cube'>" TO_WORLD(
         "<lookat origin='0 0 0' target='0 0 1' up='0 0 3'/>") "</shape>",
     "<lookat>: up is along the view; one at right angles to the view is taken"},
    {" stray <shape type='cube'/>", "the text 'stray ' has no meaning here"},
    {"<shape type='cube'><![CDATA[ x ]]></shape>", "the text 'x ' has no meaning here"},
    {"<shape type='cube'>" TO_WORLD("<scale value='0'/>") "</shape>",
     "shape 'cube' has no area and is not seen"},
    {"<shape type='rectangle'>" TO_WORLD("<scale x='0'/>") "</shape>",
     "shape 'rectangle' has no area and is not seen"},
    {"<emitter type='spot'><float name='beam_width' value='30'/></emitter>",
     "its beam_width is larger than its cutoff_angle, where its light ends"},
    {"<bsdf type='hair' id='h'/>", "BRDF 'hair' is not supported; it is not used"},
    {"<bsdf type='phng' id='a'/>", "unknown BRDF 'phng' (did you mean 'phong'?); it is not used"},
    {"<bsdf type='diffuse'><rgb name='reflectance' value='2 1 1'/></bsdf>",
     "reflectance is 2, but must be in [0, 1]; it is not used"},
    {"<texture type='bitmap'><string name='filename' value='none.png'/></texture>",
     "cannot read 'none.png': No such file or directory; it is not used"},
    {"<shape type='shapegroup' id='g'><shape type='ply'><string name='filename' value='none.ply'/>"
     "</shape></shape>",
     "cannot read 'none.ply': No such file or directory; it is not used"},
    {"<sensor type='perspective'><film type='hdrfilm'><rfilter type='Mitchell'/></film></sensor>",
     "unknown filter 'Mitchell', which is read as 'mitchell'"},
    {"<shape type='Cube' version='2.0.0'/>", "unknown shape 'Cube', which is read as 'cube'"},
    {"<path value='none'/>", "'none' is not a folder, and nothing is read from it"},
    {"<shape type='cube'>" TO_WORLD(
         "<lookat origin='3 4 5' target='0 0 0' up='3 4 5'/>") "</shape>",
     "<lookat>: up is along the view; one at right angles to the view is taken"},
    {"<film type='hdrfilm'/>", "this film is not used; its place is <sensor>"},
    {"<rfilter type='box' id='a'/>", "this filter is not used; its place is <film>"},
    {"<integrator type='pathh'/>", "unknown integrator 'pathh', which is read as 'path'"},
    {"<integrator type='ao'/>",
     "unknown integrator 'ao' (did you mean 'aov'?), which is read as 'path'"},
    {"<medium type='homogeneous' id='m'><phase type='hg'/>text</medium>",
     "<medium> is not supported; it is not used"},
    {SPHERE("<medium type='homogeneous' name='interior'><float name='scale' value='2'/></medium>"),
     "<medium> is not supported: the image is without it"},
    {SPHERE("<subsurface type='dipole'/>"),
     "<subsurface> is not supported: the image is without it"},
    {"<emitter type='sunsky'>" FLOAT("hour", "23") "</emitter>",
     "emitter 'sunsky': its sun is below the horizon, so it gives no light"},
    {"<emitter type='sky'>" TO_WORLD("<scale y='2'/>") "</emitter>",
     "emitter 'sky': to_world stretches or shears it; only its rotation is used"},
};

static const struct nonsense imprecise[] = {
    {"<shape type='cube'>" TO_WORLD("<translate x='1e4'/>") "</shape>",
     "the scene is 3.46 units large and lies 1e+04 units from the origin, where single precision "
     "loses details below 0.0048 units: move it to the origin"},
    {"<shape type='cube'>" TO_WORLD("<scale value='1e-9'/>") "</shape>",
     "the scene is 3.46e-09 units large, but light is only accurate in single precision between "
     "3.3e-08 and 7e+12: scale it"},
    {"<shape type='cube'>" TO_WORLD("<scale value='1e13'/>") "</shape>",
     "the scene is 3.46e+13 units large, but light is only accurate in single precision between "
     "3.3e-08 and 7e+12: scale it"},
    {"<shape type='cube'>" TO_WORLD("<translate x='5000'/>") "</shape>", ""},
    {"<shape type='cube'>" TO_WORLD("<scale value='1e12'/>") "</shape>", ""},
    {"<shape type='cube'>" TO_WORLD("<scale value='1e-7'/>") "</shape>", ""},
};

static const struct nonsense refused[] = {
    {SPHERE(TO_WORLD("<scale value='0'/>")), "shape 'sphere': to_world is singular"},
    {SPHERE(FLOAT("radius", "0")), "shape 'sphere': its radius is 0"},
    {"<shape type='cylinder'>" FLOAT("radius", "0") "</shape>",
     "shape 'cylinder': its radius is 0"},
    {SPHERE(FLOAT("radius", "nan")), "'nan' is not a number"},
    {SPHERE(FLOAT("radius", "inf")), "'inf' is not a number"},
    {SPHERE(FLOAT("radius", "1e39")), "'1e39' is not a number"},
    {SPHERE(FLOAT("radius", "")), "expected 1 number, found ''"},
    {SPHERE(FLOAT("radius", "1 2")), "expected 1 number, found '1 2'"},
    {SPHERE("<bsdf type='diffuse'><float name='reflectance' value='1.0000001'/></bsdf>"),
     "reflectance is 1.00000012, but must be in [0, 1]"},
    {"<shape type='disk'>" TO_WORLD("<scale value='0'/>") "</shape>",
     "shape 'disk': to_world is singular"},
    {FILM(INTEGER("width", "0")), "width is 0, but must be positive"},
    {FILM(INTEGER("width", "99999999999")), "width: '99999999999' is not an integer, or too large"},
    {FILM(INTEGER("crop_offset_x", "-1")), "crop_offset_x is -1, but must be 0 or more"},
    {FILM(INTEGER("width", "8") INTEGER("crop_offset_x", "5") INTEGER("crop_width", "6")),
     "film 'hdrfilm': its crop window is not inside of it"},
    {"<sensor type='perspective'>" FLOAT("fov", "1e-30") "</sensor>",
     "fov is 1e-30, but must be in [1e-05, 180)"},
    {"<sensor type='perspective'>" FLOAT("fov", "180") "</sensor>",
     "fov is 180, but must be in [1e-05, 180)"},
    {"<emitter type='point'><rgb name='intensity' value='-1'/></emitter>",
     "intensity is -1, but must be 0 or more"},
    {"<integrator type='path'>" INTEGER("max_depth", "-7") "</integrator>",
     "max_depth is -7, but must be -1 or more"},
};

// The message behind `scene.xml:3:COLUMN: `, or NULL if it does not begin so.
static const char *after_place(const char *message) {
    int column, n = 0;
    return sscanf(message, "scene.xml:3:%d: %n", &column, &n) == 1 && n ? message + n : NULL;
}

static void load_warnings_expect(const struct nonsense *nonsense, const char *message) {
    const char *got = after_place(message);
    if (!got || strcmp(got, nonsense->message) != 0)
        fail_msg("%s\n  expected: %s\n  got:      %s", nonsense->line, nonsense->message, message);
}

static satin_scene *load_line(struct scene_case *c, const char *line) {
    char text[1024];
    const char *sensor = strstr(line, "<sensor") ? "" : "<sensor type='perspective'/>";
    snprintf(text, sizeof text, "<scene version='3.0.0'>\n%s\n%s\n</scene>", sensor, line);
    return scene_case_load(c, text);
}

static void doubtful_values_are_reported(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof warned / sizeof *warned; i++) {
        struct scene_case c;
        satin_scene *scene = load_line(&c, warned[i].line);
        if (!scene || c.warnings != 1)
            fail_msg("%s: %d warnings, %s", warned[i].line, c.warnings, c.error);
        load_warnings_expect(&warned[i], c.warning);
        satin_scene_free(scene);
    }
}

// Scenes where single precision is too coarse are reported, and those a little inside are not.
static void imprecise_scenes_are_reported(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof imprecise / sizeof *imprecise; i++) {
        struct scene_case c;
        satin_scene *scene = load_line(&c, imprecise[i].line);
        assert_non_null(scene);
        assert_string_equal(c.warning, imprecise[i].message);
        assert_int_equal(c.warnings, imprecise[i].message[0] != 0);
        satin_scene_free(scene);
    }
}

// A reference to a medium is a warning, also if the medium stands behind it.
static void references_to_media_are_left_out(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = load_line(
        &c, SPHERE("<ref id='fog' name='interior'/>") "<medium type='homogeneous' id='fog'/>");
    assert_non_null(scene);
    assert_int_equal(c.warnings, 2);
    assert_string_equal(after_place(c.warning),
                        "'fog' is a <medium>, which is not supported: the image is without it");
    satin_scene_free(scene);
    assert_null(load_line(&c, "<medium type='homogeneous' id='fog'/>" SPHERE("<ref id='fo'/>")));
    assert_string_equal(after_place(c.error), "reference to unknown id 'fo' (did you mean 'fog'?)");
}

static void impossible_values_are_refused(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        struct scene_case c;
        assert_null(load_line(&c, refused[i].line));
        load_warnings_expect(&refused[i], c.error);
        assert_int_equal(c.warnings, 0);
    }
}

static void warnings_of_a_kind_are_counted(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = load_line(&c, "one <shape type='cube'/> two <shape type='disk'/> 3");
    assert_non_null(scene);
    assert_int_equal(c.warnings, 1);
    assert_string_equal(after_place(c.warning),
                        "the text 'one ' has no meaning here (and 2 more like it)");
    satin_scene_free(scene);
}

// Warnings come before an error, in the order of their places.
static void warnings_come_before_an_error(void **state) {
    (void)state;
    struct scene_case c;
    struct load_warnings warnings = {.to = scene_case_begin(&c)};
    struct log log = load_warnings_log(&warnings);
    log_message(log, SATIN_LOG_WARNING, "a: 'b' is %d", 1);
    log_message(log, SATIN_LOG_WARNING, "c: 'd' is %d", 2);
    log_message(log, SATIN_LOG_WARNING, "e: something else");
    assert_int_equal(c.warnings, 0);
    log_message(log, SATIN_LOG_ERROR, "f: wrong");
    assert_int_equal(c.warnings, 2);
    assert_string_equal(c.warning, "e: something else");
    assert_string_equal(c.error, "f: wrong");
    load_warnings_report(&warnings);
    assert_int_equal(c.warnings, 2);
    assert_false(warnings.failed);
}

static void strict_loading_refuses_what_it_reports(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = NULL;
    struct log log = scene_case_begin(&c);
    scene_case_file("scene.xml", SCENE_TEXT("text<shape type='cube'/>"));
    assert_int_equal(
        satin_scene_load_with("scene.xml", NULL, 0, SATIN_SCENE_STRICT, log.fn, log.user, &scene),
        SATIN_ERROR_INPUT);
    assert_null(scene);
    assert_int_equal(c.errors, 1);
    assert_int_equal(c.warnings, 0);
    assert_string_equal(after_place(c.error), "the text 'text' has no meaning here");
    scene_case_file("scene.xml", SCENE_TEXT("<shape type='cube'/>"));
    assert_int_equal(
        satin_scene_load_with("scene.xml", NULL, 0, SATIN_SCENE_STRICT, log.fn, log.user, &scene),
        SATIN_OK);
    satin_scene_free(scene);
}

// A film beside the sensor that refers to it, and a version that is not known yet.
static void parts_of_a_sensor_may_be_anywhere(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c,
        "<scene version='4.0.0'><film type='hdrfilm' id='f'><integer name='width' value='40'/>"
        "</film><sensor type='perspective'><ref id='f'/></sensor></scene>");
    assert_non_null(scene);
    assert_int_equal(scene->film.width, 40);
    assert_int_equal(c.warnings, 1);
    assert_string_equal(c.warning, "scene.xml:1:1: version '4.0.0' is read as 3.x");
    satin_scene_free(scene);
    assert_null(scene_case_load(&c, "<scene version='1.0'><sensor type='perspective'/></scene>"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(doubtful_values_are_reported),
        cmocka_unit_test(imprecise_scenes_are_reported),
        cmocka_unit_test(references_to_media_are_left_out),
        cmocka_unit_test(impossible_values_are_refused),
        cmocka_unit_test(warnings_of_a_kind_are_counted),
        cmocka_unit_test(warnings_come_before_an_error),
        cmocka_unit_test(parts_of_a_sensor_may_be_anywhere),
        cmocka_unit_test(strict_loading_refuses_what_it_reports),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
