// SPDX-License-Identifier: Apache-2.0
// Colours of other primaries as those of sRGB.
#include "film/film.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const char *const test_rgb_names[] = {"R", "G", "B"};
static const float REC2020[8] = {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
static const float ACES[8] = {0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f};

// Converts a colour of these primaries to those of sRGB.
static bool test_convert(const float chromaticities[8], float colour[3]) {
    struct satin_film *film = film_new(1, 1, test_rgb_names, 3);
    assert_non_null(film);
    memcpy(film->chromaticities, chromaticities, sizeof film->chromaticities);
    for (int c = 0; c < 3; c++) film->channel[c][0] = colour[c];
    const bool done = film_convert_primaries(film, NULL);
    for (int c = 0; c < 3; c++) colour[c] = film->channel[c][0];
    satin_film_free(film);
    return done;
}

// The matrix of ITU-R BT.2407, whose whites are the same, and that of ACES to sRGB by Bradford.
static void colours_are_those_of_published_matrices(void **state) {
    (void)state;
    static const double rec2020[3][3] = {
        {1.6605, -0.1246, -0.0182}, {-0.5876, 1.1329, -0.1006}, {-0.0728, -0.0083, 1.1187}};
    static const double aces[3][3] = {
        {2.5216, -0.2752, -0.0159}, {-1.1369, 1.3697, -0.1478}, {-0.3849, -0.0944, 1.1638}};
    for (int k = 0; k < 3; k++) {
        float a[3] = {0.0f}, b[3] = {0.0f};
        a[k] = b[k] = 1.0f;
        assert_true(test_convert(REC2020, a) && test_convert(ACES, b));
        for (int c = 0; c < 3; c++) {
            assert_true(fabs((double)a[c] - rec2020[k][c]) < 2e-4);
            assert_true(fabs((double)b[c] - aces[k][c]) < 1e-2);
        }
    }
}

static void white_stays_white(void **state) {
    (void)state;
    float colour[3] = {0.5f, 0.5f, 0.5f};
    assert_true(test_convert(ACES, colour));
    for (int c = 0; c < 3; c++) assert_true(fabsf(colour[c] - 0.5f) < 1e-4f);
}

static void primaries_on_a_line_are_refused(void **state) {
    (void)state;
    static const float line[8] = {0.1f, 0.1f, 0.2f, 0.2f, 0.3f, 0.3f, 0.3127f, 0.329f};
    static const float black[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3f, 0.0f};
    float colour[3] = {0.25f, 0.5f, 0.75f};
    assert_false(test_convert(line, colour));
    assert_false(test_convert(black, colour));
    assert_true(colour[0] == 0.25f && colour[1] == 0.5f && colour[2] == 0.75f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_are_those_of_published_matrices),
        cmocka_unit_test(white_stays_white),
        cmocka_unit_test(primaries_on_a_line_are_refused),
    };
    return cmocka_run_group_tests_name("film_primaries", tests, NULL, NULL);
}
