// SPDX-License-Identifier: Apache-2.0
// <transform>: order of steps and each step against products written out; numbers agree with
// Mitsuba 3.9.
#include "base/fileio.h"
#include "scene_case.h"

static satin_status read_steps(struct scene_case *c, const char *steps, struct mat4 *out) {
    char text[1024];
    snprintf(text, sizeof text,
             "<scene version='3.0.0'><shape type='cube'><transform name='to_world'>%s</transform>"
             "</shape></scene>",
             steps);
    scene_case_file("scene.xml", text);
    uint64_t hash = FILEIO_HASH;
    struct load_xml xml;
    struct log log = scene_case_begin(c);
    assert_int_equal(load_xml_read(log, log, "scene.xml", &(satin_scene_request){0}, &hash, &xml),
                     SATIN_OK);
    satin_status status = load_transform(log, xml.root->child->child, out);
    load_xml_free(&xml);
    return status;
}

static void load_transform_expect(const char *steps, const float m[12]) {
    struct scene_case c;
    struct mat4 out;
    assert_int_equal(read_steps(&c, steps, &out), SATIN_OK);
    for (int i = 0; i < 12; i++) assert_true(fabsf(out.m[i / 4][i % 4] - m[i]) < 2e-6f);
    for (int i = 0; i < 4; i++) assert_true(out.m[3][i] == (i == 3 ? 1.0f : 0.0f));
}

static void every_step_gives_its_matrix(void **state) {
    (void)state;
    load_transform_expect("", (float[]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
    load_transform_expect("<translate x='1' z='3'/>",
                          (float[]){1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 3});
    load_transform_expect("<translate value='1, 2 3'/>",
                          (float[]){1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3});
    load_transform_expect("<scale value='2'/>", (float[]){2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0});
    load_transform_expect("<scale y='3'/>", (float[]){1, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1, 0});
    load_transform_expect("<rotate z='2' angle='90'/>",
                          (float[]){0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0});
    load_transform_expect("<matrix value='1 2 3 4 5 6 7 8 9'/>",
                          (float[]){1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0});
    load_transform_expect("<matrix value='1 2 3 4 5 6 7 8 9 10 11 12 0 0 0 1'/>",
                          (float[]){1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
    load_transform_expect("<lookat origin='1 2 3' target='1 2 9' up='0 5 1'/>",
                          (float[]){1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3});
    // Vectors whose squares are 0 or infinite have directions, too.
    load_transform_expect("<lookat origin='0 0 0' target='0 0 1e-30' up='0 5e-30 1e-30'/>",
                          (float[]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
    load_transform_expect("<lookat origin='0 0 0' target='0 0 1e30' up='0 5e30 1e30'/>",
                          (float[]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
}

// The first step in the file is applied first.
static void steps_apply_in_their_order(void **state) {
    (void)state;
    load_transform_expect("<translate x='1'/><scale value='2'/>",
                          (float[]){2, 0, 0, 2, 0, 2, 0, 0, 0, 0, 2, 0});
    load_transform_expect("<scale value='2'/><translate x='1'/>",
                          (float[]){2, 0, 0, 1, 0, 2, 0, 0, 0, 0, 2, 0});
}

// Mitsuba 3.9 completes a missing up vector so.
static void lookat_needs_no_up(void **state) {
    (void)state;
    load_transform_expect("<lookat origin='3 -4 5' target='.2 .7 1'/>",
                          (float[]){0.18017852f, 0.8926596f, -0.41315195f, 3,   //
                                    0.69755745f, 0.18017852f, 0.69350505f, -4,  //
                                    0.69350505f, -0.41315195f, -0.59021705f, 5});
    // It completes one along the view in the same way, which Mitsuba cannot take.
    load_transform_expect("<lookat origin='0 0 0' target='0 2 0' up='0 1 0'/>",
                          (float[]){0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0});
}

static void bad_transforms_are_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"<scale value='2' x='1'/>", "<scale> has both a value and x, y or z"},
        {"<scale value='1 2'/>", "expected 3 numbers, found '1 2'"},
        {"<rotate angle='3'/>", "<rotate>: the axis is zero"},
        {"<rotate x='1' angle='3x'/>", "'3x' is not a number"},
        {"<translate x='nan'/>", "'nan' is not a number"},
        {"<translate x='1e39'/>", "'1e39' is not a number"},
        {"<matrix value='1 2 3'/>",
         "<matrix>: expected 16 numbers by rows, or 9 of the upper 3 x 3, found 3"},
        {"<lookat origin='0 0 0' target='0 0 0' up='0 1 0'/>",
         "<lookat>: origin and target coincide"},
        {"<scale value='1e30'/><scale value='1e30'/>", "<transform>: the product overflows"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        struct mat4 out;
        assert_int_equal(read_steps(&c, cases[i][0], &out), SATIN_ERROR_INPUT);
        assert_int_equal(strncmp(c.error, "scene.xml:1:", 12), 0);
        assert_string_equal(strstr(c.error, ": ") + 2, cases[i][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_step_gives_its_matrix),
        cmocka_unit_test(steps_apply_in_their_order),
        cmocka_unit_test(lookat_needs_no_up),
        cmocka_unit_test(bad_transforms_are_refused),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
