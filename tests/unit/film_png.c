// SPDX-License-Identifier: Apache-2.0
// PNG files: known sRGB bytes, values out of range and not finite, films without a beauty.
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

static void pixels_have_the_known_bytes(void **state) {
    (void)state;
    const char *const names[] = {"R", "G", "B"};
    struct satin_film *film = film_new(8, 1, names, 3);
    const float value[8] = {0.0f, 0.002f, 0.18f, 0.5f, 1.0f, 7.0f, -1.0f, NAN};
    const int byte[8] = {0, 7, 118, 188, 255, 255, 0, 0};  // IEC 61966-2-1, rounded
    for (int i = 0; i < 8; i++) film->channel[1][i] = value[i];
    film->channel[0][3] = INFINITY;
    assert_int_equal(satin_film_write_png(film, "known.png", NULL, NULL, NULL), SATIN_OK);
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, "known.png"));
    assert_int_equal(image.width, 8);
    assert_int_equal(image.height, 1);
    image.format = PNG_FORMAT_RGB;
    unsigned char pixel[24];
    assert_true(png_image_finish_read(&image, NULL, pixel, 0, NULL));
    for (int i = 0; i < 8; i++) assert_int_equal(pixel[3 * i + 1], byte[i]);
    assert_int_equal(pixel[9], 255);
    satin_film_free(film);
    unlink("known.png");
}

// The light of a film is multiplied by its alpha, and that of a PNG is not. Pictures of layers are
// over black.
static void alpha_is_straight(void **state) {
    (void)state;
    const char *const names[] = {"R", "G", "B", "A", "lamp.R", "lamp.G", "lamp.B"};
    struct satin_film *film = film_new(4, 1, names, 7);
    const float alpha[4] = {1.0f, 0.5f, 0.0f, 0.25f};
    for (int i = 0; i < 4; i++) {
        for (int c = 0; c < 3; c++)
            film->channel[c][i] = film->channel[4 + c][i] = 0.18f * alpha[i];
        film->channel[3][i] = alpha[i];
    }
    const satin_tonemap layer = {.layer = "lamp"};
    const unsigned char green[4] = {118, 118, 0, 118}, opacity[4] = {255, 128, 0, 64};
    for (int k = 0; k < 3; k++) {
        const struct log log = {NULL, NULL};
        const satin_status status =
            k == 1 ? film_write_preview(film, "alpha.png", NULL, log)
                   : satin_film_write_png(film, "alpha.png", k ? &layer : NULL, NULL, NULL);
        assert_int_equal(status, SATIN_OK);
        png_image image = {.version = PNG_IMAGE_VERSION};
        assert_true(png_image_begin_read_from_file(&image, "alpha.png"));
        assert_int_equal(image.format & PNG_FORMAT_FLAG_ALPHA, k < 2 ? PNG_FORMAT_FLAG_ALPHA : 0);
        image.format = PNG_FORMAT_RGBA;
        unsigned char pixel[16];
        assert_true(png_image_finish_read(&image, NULL, pixel, 0, NULL));
        for (int i = 0; i < 4 && k < 2; i++) {
            assert_int_equal(pixel[4 * i + 1], green[i]);
            assert_int_equal(pixel[4 * i + 3], opacity[i]);
        }
        unlink("alpha.png");
    }
    satin_film_free(film);
}

// The green bytes of a picture of four pixels.
static void picture_bytes(const struct satin_film *film, const satin_tonemap *tonemap, int out[4]) {
    assert_int_equal(satin_film_write_png(film, "tone.png", tonemap, NULL, NULL), SATIN_OK);
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, "tone.png"));
    image.format = PNG_FORMAT_RGB;
    unsigned char pixel[12];
    assert_true(png_image_finish_read(&image, NULL, pixel, 0, NULL));
    for (int i = 0; i < 4; i++) out[i] = pixel[3 * i + 1];
    unlink("tone.png");
}

static void exposure_and_tonemap_change_the_tones(void **state) {
    (void)state;
    const char *const names[] = {"R", "G", "B", "lamp.R", "lamp.G", "lamp.B"};
    struct satin_film *film = film_new(4, 1, names, 6);
    const float value[4] = {0.09f, 0.36f, 0.0f, NAN};  // the geometric mean is .18
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 4; i++) {
            film->channel[c][i] = value[i];
            film->channel[3 + c][i] = 0.01f * value[i];
        }
    int at[4];
    picture_bytes(film, &(satin_tonemap){.exposure = 1.0f}, at);
    assert_true(at[0] == 118 && at[1] == 221 && at[2] == 0 && at[3] == 0);  // of .18 and .72
    picture_bytes(film, &(satin_tonemap){.auto_exposure = true}, at);
    assert_true(at[0] == 85 && at[1] == 162);  // of .09 and .36
    picture_bytes(film, &(satin_tonemap){.layer = "lamp", .auto_exposure = true}, at);
    assert_true(at[0] == 85 && at[1] == 162);
    // 0.18 (2.51 0.18 + 0.03) / (0.18 (2.43 0.18 + 0.59) + 0.14) = 0.267
    picture_bytes(film, &(satin_tonemap){.exposure = 1.0f, .tone = SATIN_TONE_FILMIC}, at);
    assert_true(at[0] == 141 && at[2] == 0 && at[3] == 0);
    picture_bytes(film, &(satin_tonemap){.exposure = 90.0f, .tone = SATIN_TONE_FILMIC}, at);
    assert_true(at[0] == 255 && at[1] == 255 && at[2] == 0);
    const satin_tonemap wrong[2] = {{.layer = "amp"}, {.exposure = INFINITY}};
    for (int i = 0; i < 2; i++)
        assert_int_equal(satin_film_write_png(film, "tone.png", &wrong[i], NULL, NULL),
                         SATIN_ERROR_ARGUMENT);
    satin_film_free(film);
}

static void a_png_needs_the_beauty(void **state) {
    (void)state;
    const char *const names[] = {"R", "G"};
    struct satin_film *film = film_new(8, 1, names, 2);
    assert_int_equal(satin_film_write_png(film, "none.png", NULL, NULL, NULL),
                     SATIN_ERROR_ARGUMENT);
    assert_int_not_equal(access("none.png", F_OK), 0);
    satin_film_free(film);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_have_the_known_bytes),
        cmocka_unit_test(alpha_is_straight),
        cmocka_unit_test(exposure_and_tonemap_change_the_tones),
        cmocka_unit_test(a_png_needs_the_beauty),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
