// SPDX-License-Identifier: Apache-2.0
// Files of spectra are read, or refused with their place.
#include "load/load_spectrum.h"

#include "base/fileio.h"
#include "scene_case.h"

static void spectrum_files_are_read(void **state) {
    (void)state;
    struct scene_case c;
    struct spectrum spectrum;
    uint64_t hash = FILEIO_HASH;
    scene_case_file("a.spd", "# measured\n400 0.2\r\n500\t0.5 # here\n\n550 .7\n700 0.9");
    struct log log = scene_case_begin(&c);
    assert_int_equal(load_spectrum_read(log, (struct log_place){0}, "a.spd", &hash, &spectrum),
                     SATIN_OK);
    assert_int_equal(spectrum.count, 4);
    assert_true(spectrum.wavelength[2] == 550 && spectrum.value[3] == 0.9 && hash != FILEIO_HASH);
    scene_spectrum_free(&spectrum);
}

static void bad_spectrum_files_are_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"", "a.spd: there is no sample in it"},
        {"400 1\n500", "a.spd:2: a spectrum is a list of pairs of wavelength and value, not '500'"},
        {"400 1\n500 x",
         "a.spd:2: a spectrum is a list of pairs of wavelength and value, not '500 x'"},
        {"400 1\n300 1", "a.spd:2: wavelengths do not ascend at sample 1"},
        {"400 nan",
         "a.spd:1: a spectrum is a list of pairs of wavelength and value, not '400 nan'"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        struct spectrum spectrum = {0};
        scene_case_file("a.spd", cases[i][0]);
        struct log log = scene_case_begin(&c);
        assert_int_equal(load_spectrum_read(log, (struct log_place){0}, "a.spd", NULL, &spectrum),
                         SATIN_ERROR_INPUT);
        assert_string_equal(c.error, cases[i][1]);
        assert_true(c.errors == 1 && !spectrum.count);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(spectrum_files_are_read),
                                       cmocka_unit_test(bad_spectrum_files_are_refused)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
