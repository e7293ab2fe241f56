// SPDX-License-Identifier: Apache-2.0
// Shapes of Mitsuba 0.6: where a height field gets its heights from, and what is refused.
#include "mesh_case.h"

#define FIELD(body) SCENE_TEXT("<shape type='heightfield'>" body "</shape>")
#define FILE_NAMED(name) "<string name='filename' value='" name "'/>"
#define SIZE(w, h) "<integer name='width' value='" #w "'/><integer name='height' value='" #h "'/>"

// The first row of a PFM file is the last one of the image.
static void write_heights(const char *name, const char *header, const float *value, size_t count) {
    char file[256];
    const size_t size = (size_t)snprintf(file, sizeof file, "%s", header);
    memcpy(file + size, value, count * sizeof *value);
    scene_case_bytes(name, file, size + count * sizeof *value);
}

static float height_at(const satin_scene *scene, uint32_t vertex) {
    return scene->shape[0].mesh.position[3 * vertex + 2];
}

static void check_heights(const char *text, const float *expected, uint32_t count) {
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, text);
    if (!scene) fail_msg("%s", c.error);
    assert_int_equal(scene->shape[0].mesh.vertex_count, count);
    for (uint32_t i = 0; i < count; i++)
        assert_float_equal(height_at(scene, i), expected[i], 1e-6f);
    satin_scene_free(scene);
}

static void heights_are_those_of_the_image(void **state) {
    (void)state;
    static const float value[6] = {4, 5, -6, 1, -2, 3};
    write_heights("a.pfm", "Pf\n3 2\n-1\n", value, 6);
    static const float upright[6] = {1, -2, 3, 4, 5, -6}, half[6] = {.5f, -1, 1.5f, 2, 2.5f, -3};
    check_heights(FIELD(FILE_NAMED("a.pfm")), upright, 6);
    check_heights(FIELD(FILE_NAMED("a.pfm") "<float name='scale' value='.5'/>"), half, 6);
    // A texture's coordinates and interpolation do not count, nor does the size beside an image.
    check_heights(
        FIELD("<texture type='bitmap'>" FILE_NAMED(
            "a.pfm") "<string name='filter_type' value='nearest'/>"
                     "<transform name='to_uv'><scale value='3'/></transform></texture>" SIZE(7, 7)),
        upright, 6);
    check_heights(
        FIELD("<texture type='scale' name='any'><float name='scale' value='.25'/>"
              "<texture type='scale'><float name='scale' value='2'/>"
              "<texture type='bitmap'>" FILE_NAMED("a.pfm") "</texture></texture></texture>"),
        half, 6);
}

// As in Mitsuba 0.6, bytes are decoded from sRGB, unless a texture's gamma is 1.
static void bytes_of_heights_are_decoded(void **state) {
    (void)state;
    static const char pgm[] = "P5\n2 2\n255\n\x00\x33\x80\xff";
    scene_case_bytes("a.pgm", pgm, sizeof pgm - 1);
    static const float decoded[4] = {0, 0.0331048f, 0.2158605f, 1};
    static const float plain[4] = {0, 51.0f / 255, 128.0f / 255, 1};
    check_heights(FIELD(FILE_NAMED("a.pgm")), decoded, 4);
    check_heights(
        "<scene version='0.6.0'><sensor type='perspective'/><emitter type='constant'/><shape "
        "type='heightfield'>"
        "<texture type='bitmap'><float name='gamma' value='1'/>" FILE_NAMED(
            "a.pgm") "</texture></shape></scene>",
        plain, 4);
}

static void other_textures_are_sampled(void **state) {
    (void)state;
    // The checkerboard's squares are half a unit wide: samples at 0, 1/4, 1/2, 3/4 and 1.
    static const float checks[10] = {.4f, .4f, .4f, .2f, .4f, .4f, .4f, .4f, .2f, .4f};
    check_heights(FIELD("<texture type='checkerboard'/>" SIZE(5, 2)), checks, 10);
    static const float constant[4] = {6, 6, 6, 6};
    float many[64];
    for (int i = 0; i < 64; i++) many[i] = 3.0f;
    check_heights(FIELD("<texture type='rawconstant'><float name='value' value='3'/></texture>"
                        "<integer name='height' value='1'/>"),
                  many, 64);  // of one row, two are made
    check_heights(FIELD("<texture type='scale'><float name='scale' value='2'/>"
                        "<texture type='rawconstant'><float name='value' value='3'/></texture>"
                        "</texture>" SIZE(1, 1)),
                  constant, 4);
}

static void names_of_fields_in_version_06(void **state) {
    (void)state;
    static const float value[4] = {0, 0, 0, 0};
    write_heights("a.pfm", "Pf\n2 2\n-1\n", value, 4);
    struct scene_case c;
    satin_scene *scene =
        scene_case_load(&c,
                        "<scene version='0.6.0'><sensor type='perspective'/><emitter "
                        "type='constant'/><shape type='heightfield'>"
                        "<boolean name='shadingNormals' value='false'/><rfilter type='gaussian'/>"
                        "<boolean name='flipNormals' value='true'/><transform name='toWorld'>"
                        "<translate z='2'/></transform>" FILE_NAMED("a.pfm") "</shape></scene>");
    if (!scene) fail_msg("%s", c.error);
    const struct shape *shape = &scene->shape[0];
    assert_true(shape->face_normals && shape->flip_normals && !shape->mesh.normal);
    assert_float_equal(height_at(scene, 0), 2.0f, 0.0f);
    struct ray ray = {{0.2f, 0.1f, 5}, 0, {0, 0, -1}, INFINITY};
    struct interaction s;
    assert_true(scene_intersect(scene, &ray, &s));
    assert_near3(s.ng, v3(0, 0, -1), 1e-6f);
    assert_true(fabsf(s.uv.x - 0.6f) < 1e-6f && fabsf(s.uv.y - 0.55f) < 1e-6f);
    assert_string_equal(c.warning,
                        "scene.xml:1:150: the filter has no effect: heights are used "
                        "as they are");
    satin_scene_free(scene);
}

static void fields_are_shapes_like_others(void **state) {
    (void)state;
    static const float value[4] = {0, 1, 0, 1};
    write_heights("a.pfm", "Pf\n2 2\n-1\n", value, 4);
#define PLAIN "<shape type='heightfield'>" FILE_NAMED("a.pfm")
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<shape type='shapegroup' id='g'>" PLAIN "</shape></shape>"
                       "<shape type='instance'><ref id='g'/></shape>"
                       "<shape type='merge'>" PLAIN "</shape></shape>" PLAIN
                       "<emitter type='area'/><bsdf type='bumpmap'><bsdf type='diffuse'/>"
                       "<texture type='bitmap'>" FILE_NAMED("a.pfm") "</texture></bsdf></shape>"));
    if (!scene) fail_msg("%s", c.error);
    assert_true(scene->shape_count == 4 && scene->light_count == 1);
    // The slope is 1/2 along x.
    assert_float_equal(scene->shape[3].area, 4.0f * sqrtf(1.25f), 1e-5f);
    satin_scene_free(scene);
}

static void wrong_fields_are_refused(void **state) {
    (void)state;
    static const float wrong[6] = {0, 0, NAN, 0, 0, 0}, vast[4] = {0, 0, 1e30f, 0};
    write_heights("nan.pfm", "Pf\n3 2\n-1\n", wrong, 6);
    write_heights("vast.pfm", "Pf\n2 2\n-1\n", vast, 4);
    static const char *const cases[][2] = {
        {FIELD(""),
         "scene.xml:3:1: shape 'heightfield': it takes either a filename or a <texture>"},
        {FIELD(FILE_NAMED("nan.pfm") "<texture type='checkerboard'/>"),
         "scene.xml:3:1: shape 'heightfield': it takes either a filename or a <texture>"},
        {FIELD("<texture type='checkerboard'/><texture type='checkerboard'/>"),
         "scene.xml:3:1: shape 'heightfield': it takes one <texture>"},
        {FIELD("<texture type='checkerboard'/>" SIZE(100000, 100000)),
         "scene.xml:3:1: shape 'heightfield': it has more than 2^26 heights"},
        {FIELD("<texture type='checkerboard'/>" SIZE(0, 3)),
         "scene.xml:3:57: width is 0, but must be positive"},
        {FIELD(
             "<texture type='mesh_attribute'><string name='name' value='vertex_a'/></texture>" SIZE(
                 2, 2)),
         "scene.xml:3:1: shape 'heightfield': its heights cannot be an attribute of a mesh"},
        {FIELD("<texture type='scale'/>"), "scene.xml:3:27: texture 'scale' takes one <texture>"},
        {FIELD("<texture type='scale' id='a'><ref id='a'/></texture>"),
         "scene.xml:3:27: textures are nested too deep, or contain themselves"},
        {FIELD(FILE_NAMED("nan.pfm")),
         "scene.xml:3:27: image 'nan.pfm': the height in column 3 of row 2 is not finite"},
        {FIELD(FILE_NAMED("vast.pfm")),
         "scene.xml:3:1: shape 'heightfield': its heights, scale or "
         "to_world make it too large"},
        {FIELD(FILE_NAMED("none.pfm")),
         "scene.xml:3:27: cannot read 'none.pfm': No such file or directory"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        assert_null(scene_case_load(&c, cases[i][0]));
        assert_string_equal(c.error, cases[i][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(heights_are_those_of_the_image),
                                       cmocka_unit_test(bytes_of_heights_are_decoded),
                                       cmocka_unit_test(other_textures_are_sampled),
                                       cmocka_unit_test(names_of_fields_in_version_06),
                                       cmocka_unit_test(fields_are_shapes_like_others),
                                       cmocka_unit_test(wrong_fields_are_refused)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
