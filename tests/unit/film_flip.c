// SPDX-License-Identifier: Apache-2.0
// FLIP against values of the authors' program: flip-evaluator 1.7, "LDR", inputs in linear RGB.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "film/film.h"

enum { FLIP_WIDTH = 56, FLIP_HEIGHT = 40, FLIP_COUNT = FLIP_WIDTH * FLIP_HEIGHT };

static float clamped(float x) { return fminf(fmaxf(x, 0.0f), 1.0f); }

// A picture of waves and steps, and one with noise and a brighter square.
static void make_pictures(float reference[3][FLIP_COUNT], float image[3][FLIP_COUNT]) {
    for (int y = 0; y < FLIP_HEIGHT; y++)
        for (int x = 0; x < FLIP_WIDTH; x++) {
            const int i = y * FLIP_WIDTH + x;
            const float noise[3] = {(float)((7 * x + 13 * y) % 11) / 11.0f - 0.5f,
                                    (float)((5 * x + 3 * y) % 7) / 7.0f - 0.5f,
                                    (float)(x * y % 5) / 5.0f - 0.5f};
            const bool square = x > 20 && x < 30 && y > 10 && y < 20;
            reference[0][i] = 0.5f + 0.5f * sinf(0.3f * (float)x);
            reference[1][i] = 0.5f + 0.5f * sinf(0.2f * (float)y + 1.0f);
            reference[2][i] = (float)((3 * x + 5 * y) % 17) / 16.0f;
            for (int c = 0; c < 3; c++)
                image[c][i] = clamped(reference[c][i] + 0.2f * noise[c] + (square ? 0.3f : 0.0f));
        }
}

static float flip(float image[3][FLIP_COUNT], float reference[3][FLIP_COUNT],
                  float map[FLIP_COUNT]) {
    const float *const x[3] = {image[0], image[1], image[2]};
    const float *const r[3] = {reference[0], reference[1], reference[2]};
    double sum = 0.0;
    assert_int_equal(film_flip(x, r, FLIP_WIDTH, FLIP_HEIGHT, (struct log){0}, map), SATIN_OK);
    for (int i = 0; i < FLIP_COUNT; i++) sum += (double)map[i];
    return (float)(sum / FLIP_COUNT);
}

// Both programs have single precision and constants of some seven digits, whose differences the
// exponents enlarge. The values above differ by 7e-5 of the value at most.
static bool is_close(float x, float wanted) { return fabsf(x - wanted) < 1e-4f * wanted; }

static void flip_is_that_of_its_authors(void **state) {
    (void)state;
    static float image[3][FLIP_COUNT], reference[3][FLIP_COUNT], map[FLIP_COUNT];
    make_pictures(reference, image);
    assert_true(is_close(flip(image, reference, map), 0.160679f));
    assert_true(is_close(map[5 * FLIP_WIDTH + 7], 0.123785f));
    assert_true(is_close(map[15 * FLIP_WIDTH + 25], 0.669800f));
    assert_true(is_close(map[FLIP_COUNT - 1], 0.260004f));
    assert_true(flip(reference, reference, map) == 0.0f);
}

static void grey_has_a_known_difference(void **state) {
    (void)state;
    static float image[3][FLIP_COUNT], reference[3][FLIP_COUNT], map[FLIP_COUNT];
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < FLIP_COUNT; i++) {
            reference[c][i] = 0.2f;
            image[c][i] = 0.3f;
        }
    assert_true(is_close(flip(image, reference, map), 0.284729f));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flip_is_that_of_its_authors),
        cmocka_unit_test(grey_has_a_known_difference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
