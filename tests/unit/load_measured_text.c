// SPDX-License-Identifier: Apache-2.0
// Files of measured BRDFs: valid values are read, others are refused with their place.
#include "load/load_measured.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char error[512];

static void load_measured_text_keep(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    if (severity == SATIN_LOG_ERROR) snprintf(error, sizeof error, "%s", message);
}

typedef satin_status (*reader)(const struct load_source *source, struct brdf_grid *out);

// Writes `size` bytes to a file and reads it.
static satin_status read_bytes(reader read, const void *bytes, size_t size, struct arena *arena,
                               struct brdf_grid *grid) {
    char path[] = "/tmp/brdf-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, bytes, size), (ssize_t)size);
    close(fd);
    struct load_source source = {
        {load_measured_text_keep, NULL}, {"scene.xml", 3, 5}, arena, path, NULL};
    satin_status status = read(&source, grid);
    unlink(path);
    char *name = strstr(error, path);  // which differs from run to run
    if (name) {
        memcpy(name, "FILE", 4);
        memmove(name + 4, name + strlen(path), strlen(name + strlen(path)) + 1);
    }
    return status;
}

#define HEAD "# a comment\nbrdf 1\ntheta_o 2 0 90\nphi_o 1 0\n"
#define BODY "theta_i 1 45 phi 2 0 180\nchannels 1\n"

static void grids_are_read(void **state) {
    (void)state;
    struct arena arena = {0};
    struct brdf_grid g;
    const char *text = HEAD BODY "values 1 2 # two\n3.5 4e-1\n";
    assert_int_equal(read_bytes(load_measured_text, text, strlen(text), &arena, &g), SATIN_OK);
    assert_true(g.kind == BRDF_GRID_DIRECTIONS && g.channels == 1);
    assert_true(g.size[0] == 2 && g.size[1] == 1 && g.size[2] == 1 && g.size[3] == 2);
    assert_true(fabsf(g.at[0][1] - 0.5f * PI_F) < 1e-6f && fabsf(g.at[3][1] - PI_F) < 1e-6f);
    assert_true(g.value[0] == 1.0f && g.value[2] == 3.5f && fabsf(g.value[3] - .4f) < 1e-7f);
    arena_free(&arena);
}

static void bad_text_is_refused(void **state) {
    (void)state;
    static const char *const known[][2] = {
        {"", "FILE:1:1: expected 'brdf 1'"},
        {"brdf 2", "FILE:1:1: expected 'brdf 1'"},
        {HEAD "theta_i 2 45 40", "FILE:5:1: angles must ascend"},
        {HEAD "theta_i 1 100", "FILE:5:1: expected 'theta_i', how many, and angles from 0 to 90"},
        {HEAD BODY "values 1 2 3", "FILE:7:1: expected a value"},
        {HEAD BODY "values 1 2 3 4 5", "FILE:7:1: there are more values than angles ask for"},
        {HEAD BODY "values 1 2 3 -4", "FILE:7:1: values must be from 0 to 1e9"},
        {HEAD "theta_i 1 0 phi 1 0 channels 2", "FILE:5:1: expected 'channels 1' or 'channels 3'"},
        {HEAD "theta_i 99999 0", "FILE:5:1: expected 'theta_i', how many, and angles from 0 to 90"},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct arena arena = {0};
        struct brdf_grid g;
        assert_int_equal(
            read_bytes(load_measured_text, known[i][0], strlen(known[i][0]), &arena, &g),
            SATIN_ERROR_INPUT);
        assert_string_equal(error, known[i][1]);
        arena_free(&arena);
    }
}

static void merl_files_are_read(void **state) {
    (void)state;
    enum { CELLS = 90 * 90 * 180, BYTES = 12 + 24 * CELLS };
    char *bytes = calloc(1, BYTES);
    assert_non_null(bytes);
    const int32_t sizes[3] = {90, 90, 180};
    const double red = 1500.0, blue = -1.0;
    memcpy(bytes, sizes, sizeof sizes);
    memcpy(bytes + 12 + 8 * 7, &red, sizeof red);
    memcpy(bytes + 12 + 8 * (2 * CELLS + 7), &blue, sizeof blue);
    struct arena arena = {0};
    struct brdf_grid g;
    assert_int_equal(read_bytes(load_measured_merl, bytes, BYTES, &arena, &g), SATIN_OK);
    assert_true(fabsf(g.value[21] - 1.0f) < 1e-6f && g.value[22] == 0.0f && g.value[23] == 0.0f);
    assert_int_equal(read_bytes(load_measured_merl, bytes, 1000, &arena, &g), SATIN_ERROR_INPUT);
    assert_string_equal(error,
                        "scene.xml:3:5: 'FILE' is not a MERL file: it needs the sizes 90 90 180 "
                        "and 34992012 bytes, but has 1000");
    arena_free(&arena);
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grids_are_read),
        cmocka_unit_test(bad_text_is_refused),
        cmocka_unit_test(merl_files_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
