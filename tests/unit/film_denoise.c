// SPDX-License-Identifier: Apache-2.0
// Denoising: by a replacement for Open Image Denoise (tests/fake_oidn.c), which makes every
// pixel the mean and checks what it is given; and by the real one, where it is found.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/rng.h"
#include "film/film.h"
#include "message_case.h"

enum { WIDTH = 48, HEIGHT = 32, PIXELS = WIDTH * HEIGHT };

static rgb film_denoise_light[PIXELS], albedo[PIXELS], normal[PIXELS], denoised[PIXELS];

static float random01(uint64_t i) { return (float)(rng_mix(i) >> 40) * 0x1p-24f; }

// A grey noisy image of mean `brightness`, two colours of albedo, one normal.
static struct film_noisy film_denoise_noisy(int width, int height, float brightness) {
    for (int i = 0; i < width * height; i++) {
        const float value = 2.0f * brightness * random01((uint64_t)i);
        film_denoise_light[i] = rgb_make(value, value, value);
        albedo[i] = rgb_make(i % width < width / 2 ? 0.5f : 1.0f, 0.25f, 0.25f);
        normal[i] = rgb_make(0.0f, 0.0f, 1.0f);
        denoised[i] = rgb_grey(-1.0f);
    }
    return (struct film_noisy){width, height, film_denoise_light, albedo, normal, denoised, true};
}

static struct film_denoiser *open_fake(const char *mode) {
    struct message message = {0};
    struct film_denoiser *d = NULL;
    setenv("SATIN_OIDN", getenv("FAKE_OIDN_LIBRARY"), 1);
    setenv("FAKE_OIDN", mode, 1);
    assert_int_equal(film_denoiser_open(2, (struct log){keep, &message}, &d), SATIN_OK);
    assert_int_equal(message.count, 0);
    return d;
}

static satin_status denoise(struct film_denoiser *d, const struct film_noisy *image) {
    return film_denoise(d, image, NULL, NULL, (struct log){0});
}

static double film_denoise_mean(const rgb *image, int pixels) {
    double sum = 0.0;
    for (int i = 0; i < pixels; i++) sum += (double)image[i].r;
    return sum / pixels;
}

static void the_library_is_opened_and_tried(void **state) {
    (void)state;
    struct film_denoiser *d = open_fake("");
    assert_string_equal(film_denoiser_name(d), "Open Image Denoise 2.1.3");
    const double seconds = film_denoiser_pixel_seconds(d, false);
    assert_true(seconds > 0.0 && film_denoiser_pixel_seconds(d, true) > seconds);
    film_denoiser_free(d);
    film_denoiser_free(NULL);
}

// The fake refuses values over 2^26.
static void light_of_any_brightness_is_denoised(void **state) {
    (void)state;
    struct film_denoiser *d = open_fake("");
    const float brightness[] = {1e-35f, 1e-12f, 1.0f, 1e12f, 1e35f};
    for (size_t k = 0; k < sizeof brightness / sizeof *brightness; k++) {
        const struct film_noisy image = film_denoise_noisy(WIDTH, HEIGHT, brightness[k]);
        assert_int_equal(denoise(d, &image), SATIN_OK);
        for (int i = 0; i < PIXELS; i++)
            assert_true(fabs((double)denoised[i].r / film_denoise_mean(film_denoise_light, PIXELS) -
                             1.0) < 1e-6);
    }
    film_denoiser_free(d);
}

static void values_beyond_the_range_stay(void **state) {
    (void)state;
    struct film_denoiser *d = open_fake("");
    const struct film_noisy image = film_denoise_noisy(WIDTH, HEIGHT, 1.0f);
    film_denoise_light[7] = rgb_grey(-3.0f);
    film_denoise_light[9] = rgb_grey(1e30f);
    albedo[3] = rgb_grey(1.5f);
    normal[4] = rgb_grey(-2.0f);
    assert_int_equal(denoise(d, &image), SATIN_OK);
    assert_float_equal(denoised[7].g, denoised[6].g - 3.0f, denoised[6].g * 1e-6f);
    assert_float_equal(denoised[9].g / 1e30f, 1.0f, 1e-6f);
    // The part of the bright pixel within the range is distributed over all pixels: 2^24 times the
    // brightness, which is a power of two near 1.
    assert_true(denoised[6].g < 0x1p26f / PIXELS);
    film_denoiser_free(d);
}

static void black_stays_black(void **state) {
    (void)state;
    struct film_denoiser *d = open_fake("fail");
    const struct film_noisy image = film_denoise_noisy(WIDTH, HEIGHT, 0.0f);
    assert_int_equal(denoise(d, &image), SATIN_OK);
    for (int i = 0; i < PIXELS; i++) assert_true(rgb_black(denoised[i]));
    film_denoiser_free(d);
}

static void an_image_may_have_one_pixel(void **state) {
    (void)state;
    struct film_denoiser *d = open_fake("");
    const struct film_noisy image = film_denoise_noisy(1, 1, 1.0f);
    assert_int_equal(denoise(d, &image), SATIN_OK);
    assert_float_equal(denoised[0].r, film_denoise_light[0].r, 1e-6f);
    film_denoiser_free(d);
}

static void auxiliary_images_are_passed_on(void **state) {
    (void)state;
    struct film_denoiser *d = open_fake("auxiliary");
    struct film_noisy image = film_denoise_noisy(WIDTH, HEIGHT, 1.0f);
    for (int i = 0; i < PIXELS; i++) film_denoise_light[i] = rgb_grey(1.0f);  // its brightness is 1
    for (int clean = 0; clean < 2; clean++) {
        const float factor = clean ? 2.0f : 1.0f;
        image.clean = clean;
        assert_int_equal(denoise(d, &image), SATIN_OK);
        assert_float_equal(denoised[5].r, factor * 0.75f, 1e-6f);
        assert_float_equal(denoised[5].g, factor * 0.25f, 1e-6f);
        assert_float_equal(denoised[5].b, factor * 1.0f, 1e-6f);
    }
    film_denoiser_free(d);
}

static void failures_are_reported_once(void **state) {
    (void)state;
    static const struct {
        const char *mode, *text;
        satin_status status;
    } cases[] = {
        {"fail", "Open Image Denoise failed: the fake was asked to", SATIN_ERROR_INTERNAL},
        {"memory", "Open Image Denoise failed: the fake has no memory", SATIN_ERROR_MEMORY},
        {"nan", "Open Image Denoise failed: its result is not finite", SATIN_ERROR_INTERNAL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct message message = {0};
        struct film_denoiser *d = open_fake(cases[i].mode);
        const struct film_noisy image = film_denoise_noisy(WIDTH, HEIGHT, 1.0f);
        const struct log log = {keep, &message};
        assert_int_equal(film_denoise(d, &image, NULL, NULL, log), cases[i].status);
        assert_int_equal(message.count, 1);
        assert_string_equal(message.text, cases[i].text);
        film_denoiser_free(d);
    }
}

static bool stop_later(void *user, double done) {
    *(double *)user = done;
    return done < 0.5;
}

static void denoising_can_be_cancelled(void **state) {
    (void)state;
    struct message message = {0};
    struct film_denoiser *d = open_fake("slow");
    const struct film_noisy image = film_denoise_noisy(WIDTH, HEIGHT, 1.0f);
    double done = 0.0;
    assert_int_equal(film_denoise(d, &image, stop_later, &done, (struct log){keep, &message}),
                     SATIN_CANCELLED);
    assert_true(done == 0.5);
    assert_int_equal(message.count, 0);
    film_denoiser_free(d);
}

static void film_denoise_refuse(const char *library, const char *mode, const char *text) {
    struct message message = {0};
    struct film_denoiser *d = NULL;
    setenv("SATIN_OIDN", library, 1);
    setenv("FAKE_OIDN", mode, 1);
    assert_int_equal(film_denoiser_open(2, (struct log){keep, &message}, &d), SATIN_ERROR_INPUT);
    assert_null(d);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, text));
}

static void an_unusable_library_is_refused(void **state) {
    (void)state;
    film_denoise_refuse("/nonexistent/libOpenImageDenoise.so.2", "",
                        "cannot open Open Image Denoise, which SATIN_OIDN names: /nonexistent/");
    film_denoise_refuse("libm.so.6", "",
                        "libm.so.6 is not Open Image Denoise 2: it has no oidnNewDevice");
    film_denoise_refuse(getenv("FAKE_OIDN_LIBRARY"), "device", "the fake has no device");
}

// Relative root mean square error against a flat image of the brightness 1.
static double error_of(const rgb *image) {
    double sum = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        const double e = (double)image[i].r - 1.0;
        sum += e * e;
    }
    return sqrt(sum / PIXELS);
}

// With the real library, uniform noise of a standard deviation of .577 fell to .041 to .059 with
// eight sets of random numbers; the bound is twice the worst. The result does not depend on
// threads.
static void the_real_library_denoises(void **state) {
    (void)state;
    static rgb first[PIXELS];
    const char *real = getenv("SATIN_OIDN_REAL");
    setenv("SATIN_OIDN", real ? real : "", 1);
    for (int threads = 1; threads <= 3; threads++) {
        struct film_denoiser *d = NULL;
        if (film_denoiser_open(threads, (struct log){0}, &d) != SATIN_OK) {
            print_message("Open Image Denoise is not there: its own test is skipped\n");
            skip();
        }
        const struct film_noisy image = film_denoise_noisy(WIDTH, HEIGHT, 1.0f);
        assert_int_equal(denoise(d, &image), SATIN_OK);
        if (threads == 1)
            memcpy(first, denoised, sizeof first);
        else
            assert_memory_equal(first, denoised, sizeof first);
        film_denoiser_free(d);
    }
    assert_true(error_of(denoised) < 0.12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_library_is_opened_and_tried),
        cmocka_unit_test(light_of_any_brightness_is_denoised),
        cmocka_unit_test(values_beyond_the_range_stay),
        cmocka_unit_test(black_stays_black),
        cmocka_unit_test(an_image_may_have_one_pixel),
        cmocka_unit_test(auxiliary_images_are_passed_on),
        cmocka_unit_test(failures_are_reported_once),
        cmocka_unit_test(denoising_can_be_cancelled),
        cmocka_unit_test(an_unusable_library_is_refused),
        cmocka_unit_test(the_real_library_denoises),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
