// SPDX-License-Identifier: Apache-2.0
// OpenEXR files written: read back bit by bit, the same bytes for any number of threads, whole or
// absent.
#include <math.h>
#include <openexr.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/fileio.h"
#include "base/rng.h"
#include "film/film.h"
#include "folder_case.h"
#include "message_case.h"
#include "satin/render.h"

static const char *const film_exr_write_names[] = {
    "R", "G", "B", "direct.R", "depth.Z", "a.very.long.name.of.a.channel"};
enum { NAMES = 6 };

// Enough lines for more than one batch of chunks when `height` is over 1024.
static struct satin_film *film_exr_write_noisy(int width, int height) {
    struct satin_film *film = film_new(width, height, film_exr_write_names, NAMES);
    assert_non_null(film);
    for (int c = 0; c < NAMES; c++)
        for (int i = 0; i < width * height; i++) {
            struct rng rng = rng_make((uint64_t)c, RNG_TEST, (uint64_t)i);
            film->channel[c][i] = 100.0f * rng_float(&rng) - 20.0f;
        }
    assert_true(film_attribute_set(film, "satin:version", "0.1.0"));
    film->stats = strdup("{\n  \"photons.stored\": 12\n}\n");
    return film;
}

static char *slurp(const char *path, size_t *size) {
    char *data = NULL;
    assert_int_equal(
        fileio_read((struct log){0}, (struct log_place){0}, path, 1 << 30, &data, size), SATIN_OK);
    return data;
}

static void writing_and_reading_return_the_same(void **state) {
    (void)state;
    struct satin_film *film = film_exr_write_noisy(37, 1100), *back = NULL;
    assert_int_equal(satin_film_write_exr(film, "round_trip.exr", NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("round_trip.exr", NULL, NULL, &back), SATIN_OK);
    assert_int_equal(back->channel_count, NAMES);
    for (int c = 0; c < NAMES; c++) {
        const float *read = satin_film_channel(back, film_exr_write_names[c]);
        assert_non_null(read);
        assert_memory_equal(read, film->channel[c], 37 * 1100 * sizeof(float));
    }
    assert_string_equal(film_attribute_get(back, "satin:version"), "0.1.0");
    assert_string_equal(satin_film_stats(back), film->stats);
    satin_film_free(back);
    satin_film_free(film);
    unlink("round_trip.exr");
}

static void threads_do_not_change_the_bytes_of_a_file(void **state) {
    (void)state;
    struct satin_film *film = film_exr_write_noisy(64, 1100);
    size_t size[3];
    char *data[3];
    for (int i = 0; i < 3; i++) {
        struct parallel *pool = i ? parallel_new(i == 1 ? 2 : 5) : NULL;
        assert_int_equal(film_write_exr(film, "threads.exr", pool, (struct log){0}), SATIN_OK);
        data[i] = slurp("threads.exr", &size[i]);
        parallel_free(pool);
        assert_int_equal(size[i], size[0]);
        assert_memory_equal(data[i], data[0], size[0]);
    }
    for (int i = 0; i < 3; i++) free(data[i]);
    satin_film_free(film);
    unlink("threads.exr");
}

static float half_error(float x, float read) { return fabsf(read - x) / fmaxf(fabsf(x), 0x1p-14f); }

// Colours have half floats, rounded to nearest; other channels, and colours that half floats cannot
// hold, are exact.
static void colours_are_half_floats_where_these_serve(void **state) {
    (void)state;
    static const satin_exr_compression all[] = {SATIN_EXR_ZIP, SATIN_EXR_ZIPS, SATIN_EXR_PIZ,
                                                SATIN_EXR_RLE, SATIN_EXR_NONE};
    struct satin_film *film = film_exr_write_noisy(37, 90);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        const satin_exr_format format = {.compression = all[i]};
        struct satin_film *back = NULL;
        assert_int_equal(satin_film_write_exr_as(film, "half.exr", &format, NULL, NULL), SATIN_OK);
        assert_int_equal(satin_film_read("half.exr", NULL, NULL, &back), SATIN_OK);
        float worst = 0.0f;
        for (int k = 0; k < 37 * 90; k++)
            worst = fmaxf(worst, half_error(film->channel[1][k], satin_film_channel(back, "G")[k]));
        assert_true(worst <= 0x1p-11f && worst > 0x1p-13f);
        assert_memory_equal(satin_film_channel(back, "depth.Z"), film->channel[4], 37 * 90 * 4);
        satin_film_free(back);
    }
    // One value of one channel decides for its layer alone.
    film->channel[2][5] = 1e6f;
    struct satin_film *back = NULL;
    assert_int_equal(satin_film_write_exr_as(film, "half.exr", NULL, NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("half.exr", NULL, NULL, &back), SATIN_OK);
    assert_memory_equal(satin_film_channel(back, "R"), film->channel[0], 37 * 90 * 4);
    assert_memory_equal(satin_film_channel(back, "B"), film->channel[2], 37 * 90 * 4);
    assert_true(satin_film_channel(back, "direct.R")[0] != film->channel[3][0]);
    satin_film_free(back);
    // Dark images keep their precision.
    for (int k = 0; k < 37 * 90; k++) film->channel[3][k] *= 1e-7f;
    assert_int_equal(satin_film_write_exr_as(film, "half.exr", NULL, NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("half.exr", NULL, NULL, &back), SATIN_OK);
    assert_memory_equal(satin_film_channel(back, "direct.R"), film->channel[3], 37 * 90 * 4);
    satin_film_free(back);
    const satin_exr_format wrong = {.compression = (satin_exr_compression)9};
    assert_int_equal(satin_film_write_exr_as(film, "wrong.exr", &wrong, NULL, NULL),
                     SATIN_ERROR_ARGUMENT);
    satin_film_free(film);
    unlink("half.exr");
}

// All that a file of half floats returns is known before it is written.
static void halves_are_those_of_files(void **state) {
    (void)state;
    enum { SIDE = 256 };
    struct satin_film *film = film_exr_write_noisy(SIDE, SIDE), *back = NULL;
    const satin_exr_format plain = {.full_float = false}, full = {.full_float = true};
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        // Each half, the middle between it and the next one, and the floats beside that.
        const uint32_t h = i < 0x7bff ? i : i - 0x8000;
        const int exponent = (int)(h >> 10 & 31);
        const float mantissa = (float)(h & 1023) + (exponent ? 1024.0f : 0.0f);
        const float spacing = ldexpf(1.0f, (exponent ? exponent : 1) - 25);
        const float value = ldexpf(mantissa, (exponent ? exponent : 1) - 25);
        const float middle = value + 0.5f * spacing;
        film->channel[0][i] = h < 0x7bff ? value : 1.0f;
        film->channel[1][i] = h < 0x7bff ? nextafterf(middle, i & 1 ? 0.0f : 1e6f) : 1.0f;
        film->channel[2][i] = h < 0x7bff ? (i < 0x7bff ? middle : -middle) : 1.0f;
    }
    assert_int_equal(satin_film_write_exr_as(film, "half.exr", &plain, NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("half.exr", NULL, NULL, &back), SATIN_OK);
    for (int c = 0; c < 3; c++) {
        const float *read = satin_film_channel(back, film->channel_name[c]);
        assert_true(film_is_half(film, &plain, film->channel_name[c]));
        assert_false(film_is_half(film, &full, film->channel_name[c]));
        for (int i = 0; i < SIDE * SIDE; i++) {
            const float rounded = film_half(film->channel[c][i]);
            assert_memory_equal(&rounded, &read[i], sizeof rounded);
        }
    }
    assert_false(film_is_half(film, &plain, "depth.Z"));
    satin_film_free(back);
    satin_film_free(film);
    unlink("half.exr");
}

// The header says which primaries the colours have, and how the camera maps points to the image.
static void the_header_describes_colours_and_camera(void **state) {
    (void)state;
    struct satin_film *film = film_exr_write_noisy(4, 4);
    film->camera.known = true;
    for (int i = 0; i < 16; i++) {
        film->camera.to_camera[i] = (float)i;
        film->camera.to_ndc[i] = (float)(100 + i);
    }
    assert_int_equal(satin_film_write_exr(film, "header.exr", NULL, NULL), SATIN_OK);
    exr_context_t exr;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    assert_int_equal(exr_start_read(&exr, "header.exr", &init), EXR_ERR_SUCCESS);
    exr_attr_chromaticities_t primaries;
    exr_attr_m44f_t matrix;
    assert_int_equal(exr_attr_get_chromaticities(exr, 0, "chromaticities", &primaries),
                     EXR_ERR_SUCCESS);
    assert_true(primaries.red_x == 0.64f && primaries.green_y == 0.60f &&
                primaries.white_x == 0.3127f && primaries.white_y == 0.3290f);
    assert_int_equal(exr_attr_get_m44f(exr, 0, "worldToCamera", &matrix), EXR_ERR_SUCCESS);
    assert_true(matrix.m[0] == 0.0f && matrix.m[13] == 13.0f);
    assert_int_equal(exr_attr_get_m44f(exr, 0, "worldToNDC", &matrix), EXR_ERR_SUCCESS);
    assert_true(matrix.m[0] == 100.0f && matrix.m[15] == 115.0f);
    exr_finish(&exr);
    // They come back, also with other primaries.
    struct satin_film *back = NULL;
    film->chromaticities[0] = 0.7347f;
    assert_int_equal(satin_film_write_exr(film, "header.exr", NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("header.exr", NULL, NULL, &back), SATIN_OK);
    assert_true(back->camera.known);
    assert_memory_equal(back->camera.to_camera, film->camera.to_camera, 16 * sizeof(float));
    assert_memory_equal(back->camera.to_ndc, film->camera.to_ndc, 16 * sizeof(float));
    assert_memory_equal(back->chromaticities, film->chromaticities, 8 * sizeof(float));
    satin_film_free(back);
    film->camera.known = false;
    assert_int_equal(satin_film_write_exr(film, "header.exr", NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("header.exr", NULL, NULL, &back), SATIN_OK);
    assert_false(back->camera.known);
    satin_film_free(back);
    satin_film_free(film);
    unlink("header.exr");
}

static void the_window_of_a_crop_is_kept(void **state) {
    (void)state;
    struct satin_film *film = film_exr_write_noisy(9, 40), *back = NULL;
    int x, y, width, height;
    satin_film_window(film, &x, &y, &width, &height);
    assert_true(x == 0 && y == 0 && width == 9 && height == 40);
    film->x = 5;
    film->y = 7;
    film->full_width = 30;
    film->full_height = 50;
    assert_int_equal(satin_film_write_exr(film, "crop.exr", NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("crop.exr", NULL, NULL, &back), SATIN_OK);
    satin_film_window(back, &x, &y, &width, &height);
    assert_true(x == 5 && y == 7 && width == 30 && height == 50);
    satin_film_size(back, &width, &height);
    assert_true(width == 9 && height == 40);
    assert_memory_equal(satin_film_channel(back, "B"), film->channel[2], 9 * 40 * sizeof(float));
    satin_film_free(back);
    satin_film_free(film);
    unlink("crop.exr");
}

static void values_that_are_not_finite_become_zero(void **state) {
    (void)state;
    struct satin_film *film = film_exr_write_noisy(8, 20), *back = NULL;
    film->channel[0][0] = NAN;
    film->channel[1][100] = INFINITY;
    film->channel[2][159] = -INFINITY;
    struct message message = {0};
    assert_int_equal(film_write_exr(film, "finite.exr", NULL, (struct log){keep, &message}),
                     SATIN_OK);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, "3 values"));
    assert_int_equal(satin_film_read("finite.exr", NULL, NULL, &back), SATIN_OK);
    assert_true(satin_film_channel(back, "R")[0] == 0.0f);
    assert_true(satin_film_channel(back, "G")[100] == 0.0f);
    assert_true(satin_film_channel(back, "B")[159] == 0.0f);
    assert_true(isnan(film->channel[0][0]));
    satin_film_free(back);
    satin_film_free(film);
    unlink("finite.exr");
}

static void a_failure_leaves_no_file(void **state) {
    (void)state;
    struct satin_film *film = film_exr_write_noisy(8, 8), *twice = NULL;
    struct message message = {0};
    assert_int_equal(satin_film_write_exr(film, "no/such/folder.exr", keep, &message),
                     SATIN_ERROR_IO);
    assert_int_equal(message.count, 1);
    assert_true(strncmp(message.text, "no/such/folder.exr: ", 20) == 0);
    // Two channels of one name cannot be written; the old file stays.
    assert_int_equal(satin_film_write_exr(film, "kept.exr", NULL, NULL), SATIN_OK);
    const char *const same[] = {"R", "R"};
    twice = film_new(4, 4, same, 2);
    assert_int_not_equal(satin_film_write_exr(twice, "kept.exr", keep, &message), SATIN_OK);
    assert_int_equal(message.count, 2);
    struct satin_film *back = NULL;
    assert_int_equal(satin_film_read("kept.exr", NULL, NULL, &back), SATIN_OK);
    assert_int_equal(back->width, 8);
    assert_int_not_equal(system("ls -a . | grep -q '[.]tmp'"), 0);
    satin_film_free(back);
    satin_film_free(twice);
    satin_film_free(film);
    unlink("kept.exr");
}

static void the_time_of_writing_grows_with_the_channels(void **state) {
    (void)state;
    double one = 0.0, twenty = 0.0;
    for (int i = 0; i < 5; i++) {
        one += film_exr_pixel_seconds(1, false);
        twenty += film_exr_pixel_seconds(20, false);
    }
    assert_true(one > 0.0 && twenty > one && twenty < 1e-3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_time_of_writing_grows_with_the_channels),
        cmocka_unit_test(writing_and_reading_return_the_same),
        cmocka_unit_test(threads_do_not_change_the_bytes_of_a_file),
        cmocka_unit_test(colours_are_half_floats_where_these_serve),
        cmocka_unit_test(halves_are_those_of_files),
        cmocka_unit_test(the_header_describes_colours_and_camera),
        cmocka_unit_test(the_window_of_a_crop_is_kept),
        cmocka_unit_test(values_that_are_not_finite_become_zero),
        cmocka_unit_test(a_failure_leaves_no_file),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
