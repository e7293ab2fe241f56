// SPDX-License-Identifier: Apache-2.0
// What a study's file means: points, seeds, scenes, and errors with line and key.
#include "study/study_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "folder_case.h"

static char test_message[512];

static void keep_message(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    (void)severity;
    snprintf(test_message, sizeof test_message, "%s", message);
}

// Reads a file of that text.
static satin_status test_read(const char *text, struct study *out) {
    FILE *file = fopen("s.toml", "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0 && fclose(file) == 0);
    test_message[0] = 0;
    return study_file_read((struct log){keep_message, NULL}, "s.toml", out);
}

#define TEST_HEAD "scenes = [\"a.xml\", \"b/scene.xml\"]\nreference.spp = 100\n"

static void points_are_the_product(void **state) {
    (void)state;
    struct study s;
    assert_int_equal(test_read(TEST_HEAD "seeds = 2\n[vary]\nphotons = [1e3, 20_000]\n"
                                         "first-pass = [\"none\", \"path\", \"photons\"]\n",
                               &s),
                     SATIN_OK);
    assert_int_equal(s.points, 6);
    assert_int_equal(s.columns, 2);
    // The order of the file, not that of the alphabet.
    assert_string_equal(s.column[0].name, "photons");
    assert_string_equal(s.point[0].cell[0], "1000");
    assert_string_equal(s.point[1].cell[1], "path");
    assert_string_equal(s.point[5].cell[0], "20000");
    assert_string_equal(s.point[5].set.setting[1].value, "photons");
    assert_string_equal(s.scene[0].name, "a");
    assert_string_equal(s.scene[1].name, "b");
    assert_int_equal(s.seeds, 2);
    assert_int_equal(s.seed[1], 2);
    assert_int_equal(s.reference_pieces, 8);
    study_file_free(&s);
}

static void lists_and_options_together(void **state) {
    (void)state;
    struct study s;
    assert_int_equal(
        test_read(TEST_HEAD "seeds = [7, 3]\n[[vary]]\nleak-test = [true, false]\n[[vary]]\n"
                            "accuracy = [{irradiance-a = 0.1, radiance-a = 0.2},\n"
                            "  {label = \"x\", irradiance-a = 0.5}]\n"
                            "[[point]]\nname = \"last\"\nphotons = 5\n",
                  &s),
        SATIN_OK);
    assert_int_equal(s.points, 5);
    assert_string_equal(s.point[1].cell[0], "off");
    assert_string_equal(s.point[2].cell[1], "irradiance-a=0.1 radiance-a=0.2");
    assert_int_equal(s.point[2].set.count, 2);
    assert_string_equal(s.point[3].cell[1], "x");
    assert_false(s.column[1].is_option);
    assert_string_equal(s.point[4].name, "last");
    assert_int_equal(s.seed[0], 7);
    study_file_free(&s);
}

static void equal_time_is_an_axis(void **state) {
    (void)state;
    struct study s;
    assert_int_equal(test_read(TEST_HEAD "equal-time = [1, 2.5]\n[vary]\nphotons = [5, 6]\n", &s),
                     SATIN_OK);
    assert_int_equal(s.points, 4);
    assert_string_equal(s.column[1].name, "time");
    assert_string_equal(s.point[1].cell[1], "2.5");
    study_file_free(&s);
    assert_int_equal(test_read(TEST_HEAD "equal-samples = 9\n", &s), SATIN_OK);
    assert_int_equal(s.points, 1);
    assert_string_equal(s.point[0].set.setting[0].name, "spp");
    study_file_free(&s);
}

// As each piece of integrator sppm has a bias of its own.
static void a_reference_by_sppm_has_two_pieces(void **state) {
    (void)state;
    struct study s;
    const char *const sppm = TEST_HEAD "reference.set = {integrator = \"sppm\"}\n";
    assert_int_equal(test_read(sppm, &s), SATIN_OK);
    assert_int_equal(s.reference_pieces, 2);
    study_file_free(&s);
    const char *const more = TEST_HEAD
        "reference.set = {integrator = \"sppm\"}\n"
        "reference.pieces = 4\n";
    assert_int_equal(test_read(more, &s), SATIN_OK);
    assert_int_equal(s.reference_pieces, 4);
    study_file_free(&s);
}

static void no_option_is_called_as_a_statistic(void **state) {
    (void)state;
    satin_option_info info;
    int count = 0;
    for (; satin_options_describe(&satin_options_default, count, &info); count++)
        // Seeds do not vary, so no other column has this name.
        if (strcmp(info.name, "seed") != 0 && study_columns_have(info.name))
            fail_msg("the option %s has the name of a column", info.name);
    assert_true(count > 50);
    assert_true(study_columns_have("seed") && study_columns_have("memory_mb"));
}

static void errors_name_line_and_key(void **state) {
    (void)state;
    static const char *const wrong[][2] = {
        {"scenes = [\"a.xml\"\n", "s.toml:1:19: Error while parsing array"},
        {TEST_HEAD "[vary]\nphotns = [1]\n",
         "s.toml:4:1: photns: unknown option 'photns' (did you mean 'photons'?)"},
        {TEST_HEAD "[vary]\nphotons = [1, \"x\"]\n", "s.toml:4:15: photons: option photons: "},
        {TEST_HEAD "[vary]\nphotons = 5\n", "s.toml:4:1: photons: it must be a list of values"},
        {TEST_HEAD "[vary]\nphotons = []\n", "s.toml:4:1: photons: it has no values"},
        {TEST_HEAD "[vary]\nspp = [1]\nrelmse = [{spp = 2}]\n",
         "s.toml:5:1: relmse: study.csv has another column of this name"},
        {TEST_HEAD "[vary]\nload_s = [{spp = 2}]\n", "s.toml:4:1: load_s: study.csv has another"},
        {TEST_HEAD "[[vary]]\nThreads-Used = [{spp = 2}]\n", "s.toml:4:1: Threads-Used: study.csv"},
        {TEST_HEAD "[vary]\nwidth = [5]\n", "s.toml:4:10: width: it cannot vary"},
        {TEST_HEAD "[set]\nseed = 5\n", "s.toml:4:1: seed: the key 'seeds'"},
        {TEST_HEAD "sceens = 5\n", "s.toml:3:1: sceens: unknown key (did you mean 'scenes'?)"},
        {TEST_HEAD "photons = 5\n", "s.toml:3:1: photons: unknown key; options of renders stand"},
        {TEST_HEAD "seeds = 0\n", "s.toml:3:1: seeds: 0 is not a whole number in 1..1000"},
        {TEST_HEAD "seeds = [1, 1]\n", "s.toml:3:1: seeds: the seed 1 is there twice"},
        {TEST_HEAD "title = 5\n", "s.toml:3:1: title: it must be a text"},
        {TEST_HEAD "title = 1979-05-27\n", "s.toml:3:1: title: it must be a text"},
        {TEST_HEAD "equal-time = 1\nequal-samples = 2\n", "s.toml:3:1: equal-time: "},
        {TEST_HEAD "equal-time = 1\n[set]\nspp = 2\n", "s.toml:3:1: equal-time: with it, "},
        {TEST_HEAD "seeds = 3\nseeds = 4\n", "s.toml:4:"},
        {"scenes = [\"a.xml\"]\n", "s.toml:1:1: the study needs a reference"},
        {"reference.spp = 4\n", "s.toml:1:1: the study needs scenes"},
        {"scenes = [\"a.xml\", \"c/a.xml\"]\nreference.spp = 4\n", "s.toml:1:20: two scenes are"},
        {"scenes = [\"a.xml\"]\nreference.spp = 1\n", "s.toml:2:11: spp: 1 is not a whole"},
        {"scenes = [\"a.xml\"]\nreference = 16\n", "s.toml:2:1: reference: it must be a table"},
        {"scenes = [5]\n", "s.toml:1:11: it must be the name of a scene's file"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct study s;
        assert_int_equal(test_read(wrong[i][0], &s), SATIN_ERROR_INPUT);
        if (strncmp(test_message, wrong[i][1], strlen(wrong[i][1])) != 0)
            fail_msg("%s\n  is not: %s", test_message, wrong[i][1]);
        study_file_free(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_the_product),
        cmocka_unit_test(lists_and_options_together),
        cmocka_unit_test(equal_time_is_an_axis),
        cmocka_unit_test(a_reference_by_sppm_has_two_pieces),
        cmocka_unit_test(no_option_is_called_as_a_statistic),
        cmocka_unit_test(errors_name_line_and_key),
    };
    return cmocka_run_group_tests_name("study_file", tests, folder_case_setup,
                                       folder_case_teardown);
}
