// SPDX-License-Identifier: Apache-2.0
// AgX against a polynomial that others fitted to its table, and what it is made for.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "film/film.h"

// The value that AgX displays for grey at t of the way from black to white: Wrensch's polynomial of
// degree 6 (2024), whose mean square error he states as 3.7e-6.
static double fitted(double t) {
    static const double factor[7] = {-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5};
    double sum = 0.0;
    for (int i = 6; i >= 0; i--) sum = sum * t + factor[i];
    return sum;
}

static void grey_has_the_published_tones(void **state) {
    (void)state;
    enum { STEPS = 64 };
    double squares = 0.0, before = -1.0;
    for (int i = 0; i <= STEPS; i++) {
        const double t = (double)i / STEPS, light = 0.18 * exp2(-10.0 + 16.5 * t);
        const rgb shown = film_tone(SATIN_TONE_AGX, rgb_grey((float)light));
        assert_float_equal(shown.r, shown.g, 1e-5);
        assert_float_equal(shown.r, shown.b, 1e-5);
        const double value = pow((double)shown.g, 1.0 / 2.2), error = value - fitted(t);
        squares += error * error / (STEPS + 1);
        assert_true(fabs(error) < 0.008);
        assert_true(value > before);
        before = value;
    }
    print_message("mean square difference from the fit: %.2g\n", squares);
    assert_true(squares < 8e-6);
    assert_float_equal(film_tone(SATIN_TONE_AGX, rgb_grey(0.18f)).g, powf(0.5f, 2.2f), 1e-5);
}

// A blue lamp is as blue as a display shows; if it is brighter, it becomes pale.
static void bright_colours_become_pale(void **state) {
    (void)state;
    float before = INFINITY;
    for (float light = 0.5f; light < 300.0f; light *= 2.0f) {
        const rgb shown = film_tone(SATIN_TONE_AGX, rgb_make(0.05f * light, 0.1f * light, light));
        assert_true(shown.b >= shown.g && shown.g >= shown.r);
        const float colour = (shown.b - shown.r) / shown.b;
        assert_true(colour <= before);
        before = colour;
    }
    assert_true(before < 0.1f);
}

static void no_light_is_out_of_range(void **state) {
    (void)state;
    const float value[] = {0.0f, -1.0f, NAN, 1e-38f, 1e38f, INFINITY, 0.3f};
    enum { COUNT = sizeof value / sizeof *value };
    for (int i = 0; i < COUNT * COUNT * COUNT; i++) {
        const rgb light = {value[i % COUNT], value[i / COUNT % COUNT], value[i / COUNT / COUNT]};
        const rgb shown = film_tone(SATIN_TONE_AGX, light);
        assert_true(shown.r >= 0.0f && shown.r <= 1.0f && shown.g >= 0.0f && shown.g <= 1.0f);
        assert_true(shown.b >= 0.0f && shown.b <= 1.0f);
    }
    assert_float_equal(film_tone(SATIN_TONE_AGX, rgb_grey(NAN)).g, 0.0f, 1e-6);
    assert_float_equal(film_tone(SATIN_TONE_AGX, rgb_grey(INFINITY)).g, 1.0f, 1e-5);
    assert_float_equal(film_tone(SATIN_TONE_CLIP, rgb_grey(2.0f)).g, 2.0f, 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grey_has_the_published_tones),
        cmocka_unit_test(bright_colours_become_pale),
        cmocka_unit_test(no_light_is_out_of_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
