// SPDX-License-Identifier: Apache-2.0
// Bias and variance of images of known noise, and the noise of a reference that is subtracted.
#include "film/film.h"
#include "study/study_work.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/rng.h"

enum { SIDE = 96, IMAGES = 6, PIECES = 8 };
static const char *const test_names[] = {"R", "G", "B", "emission.R", "emission.G", "emission.B"};

// A number of mean 0 and variance 1, of two values.
static double test_noise(uint64_t stream, size_t i) {
    return rng_mix(1000003u * stream + i) & 1 ? 1.0 : -1.0;
}

// The truth of each value is 1; the image has a bias and noise.
static satin_film *test_image(uint64_t stream, double bias, double deviation) {
    satin_film *film = film_new(SIDE, SIDE, test_names, 6);
    assert_non_null(film);
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < (size_t)SIDE * SIDE; i++)
            film_channel(film, test_names[c])[i] =
                (float)(1.0 + bias + deviation * test_noise(stream, i + (size_t)c * SIDE * SIDE));
    return film;
}

static struct study_reference test_reference(double deviation) {
    satin_film *piece[PIECES];
    struct study_reference reference = {0};
    for (uint64_t k = 0; k < PIECES; k++) piece[k] = test_image(100 + k, 0.0, deviation);
    assert_true(study_reference_average(piece, PIECES, &reference));
    for (size_t k = 0; k < PIECES; k++) satin_film_free(piece[k]);
    return reference;
}

static struct study_errors test_errors(size_t count, double bias, double deviation,
                                       double reference_deviation) {
    satin_film *image[IMAGES];
    struct study_errors errors;
    struct study_reference reference = test_reference(reference_deviation);
    for (size_t s = 0; s < count; s++) image[s] = test_image(s + 1, bias, deviation);
    assert_true(study_errors_find(image, count, &reference, true, &errors));
    for (size_t s = 0; s < count; s++) satin_film_free(image[s]);
    study_reference_free(&reference);
    return errors;
}

// Squares are over 1.01. The bounds are five standard errors: with n values of each image, noise of
// variance v and a reference of variance w, that of the bias is about sqrt(2 / n) (v / 6 + w) and
// 2 bias sqrt((v / 6 + w) / n).
static void bias_and_variance_are_separated(void **state) {
    (void)state;
    const double bias = 0.05, v = 0.04, w = 0.01 / PIECES, n = 3.0 * SIDE * SIDE;
    const struct study_errors e = test_errors(IMAGES, bias, sqrt(v), 0.1);
    const double sigma =
        (sqrt(2.0 / n) * (v / 6.0 + w) + 2.0 * bias * sqrt((v / 6.0 + w) / n)) / 1.01;
    assert_true(fabs(e.bias2 - bias * bias / 1.01) < 5.0 * sigma);
    assert_true(e.bias2_error > 0.2 * sigma && e.bias2_error < 5.0 * sigma);
    assert_true(fabs(e.variance - v / 1.01) < 0.02 * v);
    assert_true(fabs(e.relmse - e.bias2 - e.variance) < 1e-12);
    assert_true(fabs(e.mean_ratio - 1.0 - bias) < 5.0 * sqrt((v / 6.0 + w) / n));
}

// Without its variance, the noise of the reference would count as bias: w / 1.01 = .00124.
static void noise_of_the_reference_is_subtracted(void **state) {
    (void)state;
    const double w = 0.01 / PIECES, n = 3.0 * SIDE * SIDE;
    const struct study_errors e = test_errors(IMAGES, 0.0, 0.01, 0.1);
    assert_true(fabs(e.bias2) < 5.0 * sqrt(2.0 / n) * (w + 1e-4));
    // The 1.01 is a mean over 1 / (r^2 + .01), which noise of r changes by less than 1 %.
    assert_true(fabs(e.reference_noise - w / 1.01) < 0.03 * w);
}

static void few_seeds_leave_the_rest_unknown(void **state) {
    (void)state;
    struct study_errors e = test_errors(1, 0.0, 0.1, 0.0);
    assert_true(isfinite(e.relmse) && isnan(e.bias2) && isnan(e.variance));
    e = test_errors(2, 0.0, 0.1, 0.0);
    assert_true(isfinite(e.bias2) && isfinite(e.variance) && isnan(e.bias2_error));
    e = test_errors(0, 0.0, 0.1, 0.0);
    assert_true(isnan(e.relmse) && e.images == 0 && e.reference_noise == 0.0);
}

static void emitters_and_what_is_not_finite_are_left_out(void **state) {
    (void)state;
    struct study_reference reference = test_reference(0.0);
    struct study_errors e;
    satin_film *image[2] = {test_image(1, 0.0, 0.0), test_image(2, 0.0, 0.0)};
    film_channel(image[0], "R")[5] = 100.0f;
    film_channel(image[0], "emission.G")[5] = 1.0f;
    film_channel(image[1], "B")[7] = NAN;
    assert_true(study_errors_find(image, 2, &reference, true, &e));
    assert_true(e.relmse == 0.0 && e.bias2 == 0.0);
    assert_true(study_errors_find(image, 2, &reference, false, &e));
    assert_true(e.relmse > 0.0);
    satin_film_free(image[0]);
    satin_film_free(image[1]);
    study_reference_free(&reference);
}

// The noise of the reference is that of the pixels of which the error is.
static void noise_of_the_reference_is_of_compared_pixels(void **state) {
    (void)state;
    struct study_reference reference = test_reference(0.1);
    struct study_errors before, e;
    satin_film *image = test_image(1, 0.0, 0.0);
    assert_int_equal(reference.pieces, PIECES);
    assert_true(study_errors_find(&image, 1, &reference, true, &before));
    film_channel(image, "emission.G")[5] = 1.0f;
    film_channel(reference.mean, "variance.R")[5] = 1e6f;
    film_channel(reference.mean, "B")[7] = NAN;
    assert_int_equal(study_reference_nonfinite(reference.mean), 1);
    assert_true(study_errors_find(&image, 1, &reference, true, &e));
    assert_true(fabs(e.reference_noise / before.reference_noise - 1.0) < 0.01);
    assert_true(study_errors_find(&image, 1, &reference, false, &e));
    assert_true(e.reference_noise > 10.0);
    satin_film_free(image);
    study_reference_free(&reference);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bias_and_variance_are_separated),
        cmocka_unit_test(noise_of_the_reference_is_subtracted),
        cmocka_unit_test(noise_of_the_reference_is_of_compared_pixels),
        cmocka_unit_test(few_seeds_leave_the_rest_unknown),
        cmocka_unit_test(emitters_and_what_is_not_finite_are_left_out),
    };
    return cmocka_run_group_tests_name("study_errors", tests, NULL, NULL);
}
