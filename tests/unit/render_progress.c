// SPDX-License-Identifier: Apache-2.0
// The course that options give a render, and that its steps and the integrator of the second pass
// follow a change of it.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/render_state.h"

static void options_decide_the_first_course(void **state) {
    (void)state;
    const struct {
        satin_integrator integrator;
        int max_depth;
        enum render_course course;
    } cases[] = {
        {SATIN_TWO_PASS, -1, COURSE_TWO_PASS},   {SATIN_TWO_PASS, 3, COURSE_TWO_PASS},
        {SATIN_TWO_PASS, 2, COURSE_SHORT_PATHS}, {SATIN_PATH, -1, COURSE_PATHS},
        {SATIN_PHOTONS, 2, COURSE_PHOTONS},      {SATIN_DIRECT, -1, COURSE_DIRECT},
        {SATIN_SPPM, -1, COURSE_SPPM},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const satin_options o = {.integrator = cases[i].integrator,
                                 .max_depth = cases[i].max_depth,
                                 .final_gather = true};
        assert_int_equal(render_first_course(&o), cases[i].course);
        struct render r = {0};
        render_take_course(&r, cases[i].course);
        assert_int_equal(r.options.integrator, cases[i].integrator);
        assert_false(render_steps(&r)->coarse);
    }
}

static void without_final_gathering_the_first_pass_decides(void **state) {
    (void)state;
    const struct {
        satin_first_pass first_pass;
        enum render_course course;
    } cases[] = {
        {SATIN_FIRST_PRECOMPUTED, COURSE_FIRST_PASS},
        {SATIN_FIRST_PHOTONS, COURSE_FIRST_PASS},
        {SATIN_FIRST_REVERSE, COURSE_FIRST_PASS},
        {SATIN_FIRST_RECURSIVE, COURSE_FIRST_PASS},
        {SATIN_FIRST_PATH, COURSE_PATHS},
        {SATIN_FIRST_NONE, COURSE_DIRECT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        satin_options o = {.integrator = SATIN_TWO_PASS, .max_depth = -1};
        o.first_pass = cases[i].first_pass;
        assert_int_equal(render_first_course(&o), cases[i].course);
    }
}

static void steps_follow_the_course(void **state) {
    (void)state;
    struct render r = {0};
    render_take_course(&r, COURSE_TWO_PASS);
    assert_true(render_has_stage(&r, STAGE_PHOTONS) && render_has_stage(&r, STAGE_RECORDS));
    assert_int_equal(r.options.integrator, SATIN_TWO_PASS);
    render_take_course(&r, COURSE_PATHS);
    assert_true(!render_has_stage(&r, STAGE_PHOTONS) && !render_has_stage(&r, STAGE_TABLES));
    render_take_course(&r, COURSE_COARSE_DIRECT);
    assert_int_equal(r.options.integrator, SATIN_DIRECT);
    assert_true(render_steps(&r)->coarse);
}

// Without a limit the end is known when the image has a speed, and estimated when the records have
// one; a limit is known in all stages.
static void the_time_that_is_left_is_that_of_the_whole_render(void **state) {
    (void)state;
    struct render r = {.progress = {.stage = STAGE_RECORDS, .start = 100.0, .stage_start = 104.0},
                       .options = {.quality = SATIN_PREVIEW, .spp = 25}};
    assert_true(render_progress_left(&r, 0.0, 8.0) < 0.0);
    // Four seconds of records, and an image of 1.2 times the 12 seconds until then; or of twice as
    // many samples.
    assert_float_equal(render_progress_left(&r, 0.5, 8.0), 4.0 + 1.2 * 12.0, 1e-9);
    r.options.spp = 50;
    assert_float_equal(render_progress_left(&r, 0.5, 8.0), 4.0 + 2.4 * 12.0, 1e-9);
    r.progress.stage = STAGE_PHOTONS;
    assert_true(render_progress_left(&r, 0.5, 8.0) < 0.0);
    r.progress.stage = STAGE_IMAGE;
    assert_true(render_progress_left(&r, 0.0, 8.0) < 0.0);
    assert_true(render_progress_left(&r, 0.9, 4.1) < 0.0);
    assert_float_equal(render_progress_left(&r, 0.25, 8.0), 12.0, 1e-9);
    r.options.time = 10.0;
    assert_float_equal(render_progress_left(&r, 0.25, 8.0), 2.0, 1e-9);
    assert_float_equal(render_progress_left(&r, 0.8, 8.0), 1.0, 1e-9);
    assert_float_equal(render_progress_left(&r, 0.0, 11.0), 0.0, 0.0);
    r.progress.stage = STAGE_PHOTONS;
    assert_float_equal(render_progress_left(&r, 0.9, 8.0), 2.0, 1e-9);
    // What an earlier process has done shows no speed.
    r.options.time = 0.0;
    r.progress.stage = STAGE_IMAGE;
    render_stage_skip(&r, 0.5);
    assert_true(render_progress_left(&r, 0.5, 8.0) < 0.0);
    assert_float_equal(render_progress_left(&r, 0.75, 8.0), 4.0, 1e-9);
}

// Frames that are too short for a speed of their own take as long as those before.
static void short_frames_take_as_long_as_others(void **state) {
    (void)state;
    struct camera view;
    struct render r = {.progress = {.stage = STAGE_IMAGE, .start = 100.0, .stage_start = 109.9},
                       .frames = {.view = &view, .wanted = 10, .begun = 5}};
    r.frames.images_start = 2.0;
    r.frames.start = 10.0;  // four frames took two seconds each
    assert_float_equal(render_progress_left(&r, 0.0, 10.5), 1.5 + 5.0 * 2.0, 1e-9);
    r.frames.begun = 1;
    assert_true(render_progress_left(&r, 0.0, 10.0) < 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_decide_the_first_course),
        cmocka_unit_test(without_final_gathering_the_first_pass_decides),
        cmocka_unit_test(steps_follow_the_course),
        cmocka_unit_test(the_time_that_is_left_is_that_of_the_whole_render),
        cmocka_unit_test(short_frames_take_as_long_as_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
