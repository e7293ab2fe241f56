// SPDX-License-Identifier: Apache-2.0
// Comparison: figures of small images computed by hand, the subtraction of a reference's own
// variance, masks, values that are not finite.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"
#include "film/film.h"

static const char *const film_compare_names[] = {"R",          "G",          "B",
                                                 "variance.R", "variance.G", "variance.B",
                                                 "emission.R", "emission.G", "emission.B"};

static struct satin_film *grey(int width, int height, float value, int channels) {
    struct satin_film *film = film_new(width, height, film_compare_names, channels);
    for (int c = 0; c < 3 && c < channels; c++)
        for (int i = 0; i < width * height; i++) film->channel[c][i] = value;
    return film;
}

static bool film_compare_near(double a, double b) { return fabs(a - b) <= 1e-6 * fabs(b) + 1e-12; }

static void figures_agree_with_those_by_hand(void **state) {
    (void)state;
    struct satin_film *x = grey(2, 1, 0.5f, 3), *r = grey(2, 1, 0.5f, 3);
    struct film_difference d;
    assert_int_equal(film_compare(x, r, false, (struct log){0}, &d), SATIN_OK);
    assert_true(d.rmse == 0 && d.relmse == 0 && isinf(d.psnr) && d.psnr > 0);
    assert_true(d.mean_ratio == 1 && d.discernible == 0 && d.compared == 2 && !d.variance);
    for (int c = 0; c < 3; c++) x->channel[c][1] = 1.0f;
    assert_int_equal(film_compare(x, r, false, (struct log){0}, &d), SATIN_OK);
    assert_true(film_compare_near(d.rmse, sqrt(0.125)));
    assert_true(film_compare_near(d.relmse, 0.5 * 0.25 / 0.26));
    double step = 1.0 - (1.055 * pow(0.5, 1.0 / 2.4) - 0.055);
    assert_true(film_compare_near(d.psnr, -10.0 * log10(0.5 * step * step)));
    assert_true(film_compare_near(d.mean_ratio, 1.5));
    assert_true(d.discernible == 0.5);
    satin_film_free(x);
    satin_film_free(r);
}

// 1.9 % is not visible, 2.1 % is; on black any difference is visible.
static void discernible_pixels_follow_webers_law(void **state) {
    (void)state;
    struct satin_film *x = grey(4, 1, 1.0f, 3), *r = grey(4, 1, 1.0f, 3);
    for (int c = 0; c < 3; c++) {
        x->channel[c][0] = 1.019f;
        x->channel[c][1] = 0.979f;
        x->channel[c][2] = r->channel[c][2] = 0.0f;
        x->channel[c][3] = 1e-6f;
        r->channel[c][3] = 0.0f;
    }
    struct film_difference d;
    assert_int_equal(film_compare(x, r, false, (struct log){0}, &d), SATIN_OK);
    assert_true(d.discernible == 0.5);
    satin_film_free(x);
    satin_film_free(r);
}

// An exact image against a noisy reference of known variance has an error of zero on average: here
// 120000 values of (d^2 - v) / (r^2 + .01), each with a spread of at most 1.5 v / .8, so the mean
// lies within 5 sigma of zero, 5 * .9 v / sqrt(120000) = 1.3e-2 v.
static void reference_noise_is_subtracted(void **state) {
    (void)state;
    struct satin_film *x = grey(200, 200, 1.0f, 3), *r = grey(200, 200, 1.0f, 6);
    double v = 0.04 / 12.0;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 40000; i++) {
            struct rng rng = rng_make((uint64_t)c, RNG_TEST, (uint64_t)i);
            r->channel[c][i] = 0.9f + 0.2f * rng_float(&rng);
            r->channel[c + 3][i] = (float)v;
        }
    struct film_difference d;
    assert_int_equal(film_compare(x, r, false, (struct log){0}, &d), SATIN_OK);
    assert_true(d.variance);
    // Dividing by the noisy r^2 correlates with d; to second order it adds 3 v^2, far below.
    assert_true(fabs(d.relmse) < 1.3e-2 * v + 10 * v * v);
    satin_film_free(x);
    satin_film_free(r);
}

static void masked_and_nonfinite_pixels_are_left_out(void **state) {
    (void)state;
    struct satin_film *x = grey(4, 1, 1.0f, 9), *r = grey(4, 1, 1.0f, 3);
    x->channel[0][0] = NAN;
    x->channel[7][1] = 3.0f;
    x->channel[0][1] = 50.0f;
    struct film_difference d;
    assert_int_equal(film_compare(x, r, true, (struct log){0}, &d), SATIN_OK);
    assert_int_equal(d.nonfinite, 1);
    assert_int_equal(d.masked, 1);
    assert_int_equal(d.compared, 2);
    assert_true(d.rmse == 0);
    assert_int_equal(film_compare(r, r, true, (struct log){0}, &d), SATIN_ERROR_INPUT);
    struct satin_film *small = grey(3, 1, 1.0f, 3), *flat = grey(4, 1, 1.0f, 2);
    assert_int_equal(film_compare(x, small, false, (struct log){0}, &d), SATIN_ERROR_INPUT);
    assert_int_equal(film_compare(x, flat, false, (struct log){0}, &d), SATIN_ERROR_INPUT);
    for (int i = 0; i < 3; i++) small->channel[1][i] = INFINITY;
    assert_int_equal(film_compare(small, small, false, (struct log){0}, &d), SATIN_ERROR_INPUT);
    satin_film_free(x);
    satin_film_free(r);
    satin_film_free(small);
    satin_film_free(flat);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figures_agree_with_those_by_hand),
        cmocka_unit_test(discernible_pixels_follow_webers_law),
        cmocka_unit_test(reference_noise_is_subtracted),
        cmocka_unit_test(masked_and_nonfinite_pixels_are_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
