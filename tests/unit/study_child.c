// SPDX-License-Identifier: Apache-2.0
// Processes: how they ended, what they took, and that they are stopped.
#include "study/study_work.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "folder_case.h"

static struct study_result test_child(const char *script, bool (*interrupted)(void)) {
    const char *const argument[] = {"-c", script, NULL};
    const struct study_child child = {"/bin/sh", argument, "errors.txt", interrupted};
    struct study_result result = {0};
    assert_true(study_child_run(&child, &result));
    return result;
}

static void the_end_is_reported(void **state) {
    (void)state;
    struct study_result r = test_child("exit 7", NULL);
    assert_true(r.status == 7 && r.signal == 0);
    r = test_child("kill -9 $$", NULL);
    assert_true(r.signal == 9);
    r = test_child("echo wrong >&2; echo lost; read x && exit 5; exit 0", NULL);
    assert_true(r.status == 0);
    char text[32] = "";
    FILE *file = fopen("errors.txt", "r");
    assert_non_null(file);
    assert_non_null(fgets(text, sizeof text, file));
    assert_string_equal(text, "wrong\n");
    fclose(file);
}

static void time_and_memory_are_those_of_the_process(void **state) {
    (void)state;
    const struct study_result slept = test_child("sleep .3", NULL);
    assert_true(slept.wall_s >= 0.3 && slept.cpu_s < slept.wall_s);
    const struct study_result worked =
        test_child("i=0; while [ $i -lt 100000 ]; do i=$((i+1)); done", NULL);
    assert_true(worked.cpu_s > 0.01);
    assert_true(worked.peak_bytes > 1e5 && worked.peak_bytes < 1e8);
}

static bool always(void) { return true; }

static void an_interruption_ends_the_process(void **state) {
    (void)state;
    const struct study_result r = test_child("exec sleep 60", always);
    assert_int_equal(r.signal, 15);
    assert_true(r.wall_s < 30.0);
}

static void a_program_that_is_not_there(void **state) {
    (void)state;
    const char *const argument[] = {NULL};
    const struct study_child child = {"/nonexistent", argument, "errors.txt", NULL};
    struct study_result result = {0};
    assert_true(study_child_run(&child, &result));
    assert_int_equal(result.status, 127);
    const struct study_child nowhere = {"/bin/true", argument, "none/errors.txt", NULL};
    assert_false(study_child_run(&nowhere, &result));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_end_is_reported),
        cmocka_unit_test(time_and_memory_are_those_of_the_process),
        cmocka_unit_test(an_interruption_ends_the_process),
        cmocka_unit_test(a_program_that_is_not_there),
    };
    return cmocka_run_group_tests_name("study_child", tests, folder_case_setup,
                                       folder_case_teardown);
}
