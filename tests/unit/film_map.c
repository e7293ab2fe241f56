// SPDX-License-Identifier: Apache-2.0
// Images of numbers: colours become lighter in equal steps, zero and values that are not finite are
// black, single large values do not darken the others, dots cover the grey beauty.
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmocka.h>

#include "film/film.h"
#include "folder_case.h"

enum { WIDTH = 1024 };

static void film_map_read_png(const char *path, unsigned char pixel[3 * WIDTH]) {
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, path));
    assert_int_equal(image.width, WIDTH);
    image.format = PNG_FORMAT_RGB;
    assert_true(png_image_finish_read(&image, NULL, pixel, 0, NULL));
    unlink(path);
}

// CIE lightness, by another formula than the one that makes the colours.
static double lightness(const unsigned char *p) {
    static const double weight[3] = {0.2126, 0.7152, 0.0722};
    double y = 0.0;
    for (int c = 0; c < 3; c++) {
        double v = p[c] / 255.0;
        y += weight[c] * (v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
    }
    return y > 0.008856 ? 116.0 * cbrt(y) - 16.0 : 903.3 * y;
}

static void colours_become_lighter_with_the_value(void **state) {
    (void)state;
    const char *const names[] = {"x"};
    struct satin_film *film = film_new(WIDTH, 1, names, 1);
    float *value = film->channel[0], top = 0.0f;
    for (int i = 0; i < WIDTH; i++) value[i] = (float)i;
    value[1] = NAN;
    value[2] = INFINITY;
    value[3] = -1.0f;
    value[WIDTH - 1] = 1e30f;
    assert_int_equal(film_write_map(film, value, "map.png", (struct log){0}, &top), SATIN_OK);
    assert_true(top > 0.98f * WIDTH && top < WIDTH);
    unsigned char pixel[3 * WIDTH];
    film_map_read_png("map.png", pixel);
    for (int i = 0; i < 12; i++) assert_int_equal(pixel[i], 0);
    // The steps are equal in CIE lightness too, except for the difference of the two formulas.
    const int step = 100;
    for (int i = step; i + step < WIDTH; i += step) {
        double rise = lightness(&pixel[3 * (i + step)]) - lightness(&pixel[3 * i]);
        assert_true(rise > 4.0 && rise < 14.0);
    }
    assert_true(lightness(&pixel[3 * (WIDTH - 1)]) > 90.0);
    satin_film_free(film);
}

static void a_map_of_nothing_is_black(void **state) {
    (void)state;
    const char *const names[] = {"x"};
    struct satin_film *film = film_new(WIDTH, 1, names, 1);
    float top = 1.0f;
    assert_int_equal(film_write_map(film, film->channel[0], "map.png", (struct log){0}, &top),
                     SATIN_OK);
    assert_true(top == 0.0f);
    unsigned char pixel[3 * WIDTH];
    film_map_read_png("map.png", pixel);
    for (int i = 0; i < 3 * WIDTH; i++) assert_int_equal(pixel[i], 0);
    satin_film_free(film);
}

static void records_are_dots_over_a_grey_image(void **state) {
    (void)state;
    const char *const names[] = {"R", "G", "B", "x"};
    struct satin_film *film = film_new(WIDTH, 1, names, 4);
    for (int c = 0; c < 3; c++) film->channel[c][0] = film->channel[c][1] = 0.5f;
    film->channel[3][1] = 1.0f;
    assert_int_equal(film_write_dots(film, film->channel[3], "map.png", (struct log){0}), SATIN_OK);
    unsigned char pixel[3 * WIDTH];
    film_map_read_png("map.png", pixel);
    assert_true(pixel[0] == pixel[1] && pixel[1] == pixel[2] && abs(pixel[0] - 188) <= 1);
    assert_int_equal(pixel[3], 255);
    assert_true(pixel[5] < 100);
    satin_film_free(film);
}

static void a_map_needs_the_beauty(void **state) {
    (void)state;
    const char *const names[] = {"x"};
    struct satin_film *film = film_new(4, 1, names, 1);
    assert_int_equal(film_write_dots(film, film->channel[0], "none.png", (struct log){0}),
                     SATIN_ERROR_INPUT);
    assert_int_not_equal(access("none.png", F_OK), 0);
    satin_film_free(film);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_become_lighter_with_the_value),
        cmocka_unit_test(a_map_of_nothing_is_black),
        cmocka_unit_test(records_are_dots_over_a_grey_image),
        cmocka_unit_test(a_map_needs_the_beauty),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
