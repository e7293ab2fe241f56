// SPDX-License-Identifier: Apache-2.0
// The film of a render: a crop window of the scene shows the same region of a film of any size, and
// one of the options has its own pixels.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "message_case.h"
#include "render/render.h"
#include "render/render_state.h"

// A film of 40x30 with a crop of 20x10 at (10, 5).
static struct satin_scene cropped_scene(void) {
    struct satin_scene scene = {
        .film = {.width = 40, .height = 30, .crop_x = 10, .crop_y = 5, .crop_width = 20}};
    scene.film.crop_height = 10;
    scene.camera.tan_x = 1.0f;
    scene.camera.tan_y = 0.75f;
    return scene;
}

static void a_crop_shows_the_same_region(void **state) {
    (void)state;
    static const struct {
        int width, height;      // of the options
        int whole[2], crop[4];  // that are wanted
    } cases[] = {
        {0, 0, {40, 30}, {10, 5, 20, 10}},
        {40, 0, {40, 30}, {10, 5, 20, 10}},
        {80, 0, {80, 60}, {20, 10, 40, 20}},
        {0, 60, {80, 60}, {20, 10, 40, 20}},
        {20, 15, {20, 15}, {5, 3, 10, 5}},  // rows 2.5 to 7.5, rounded up
        {60, 30, {60, 30}, {15, 5, 30, 10}},
        {41, 31, {41, 31}, {10, 5, 21, 11}},  // columns 10.25 to 30.75, rows 5.2 to 15.5
        {1, 1, {1, 1}, {0, 0, 1, 1}},
        {2, 2, {2, 2}, {1, 0, 1, 1}},  // columns .5 to 1.5, rows .3 to 1
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct satin_scene scene = cropped_scene();
        const struct scene_film *film = &scene.film;
        satin_options o = satin_options_default;
        o.width = cases[i].width;
        o.height = cases[i].height;
        assert_int_equal(render_window(&scene, &o, (struct log){0}), SATIN_OK);
        assert_int_equal(film->width, cases[i].whole[0]);
        assert_int_equal(film->height, cases[i].whole[1]);
        const int crop[4] = {film->crop_x, film->crop_y, film->crop_width, film->crop_height};
        for (int k = 0; k < 4; k++) assert_int_equal(crop[k], cases[i].crop[k]);
        // Pixels are square: the horizontal angle of view is that of the scene.
        assert_float_equal(scene.camera.tan_y, (float)film->height / (float)film->width, 1e-6f);
        assert_true(scene.camera.tan_x == 1.0f);
        // The options say what was rendered, so that they make the same film of it.
        satin_options again = o;
        struct satin_scene other = cropped_scene();
        again.width = film->width;
        again.height = film->height;
        assert_int_equal(render_window(&other, &again, (struct log){0}), SATIN_OK);
        assert_memory_equal(&other.film, film, sizeof *film);
    }
}

static void crops_of_the_options_have_their_own_pixels(void **state) {
    (void)state;
    struct message message = {0};
    const struct log log = {keep, &message};
    const struct satin_scene scene = cropped_scene();
    satin_options o = satin_options_default;
    int width = 0, height = 0;
    assert_int_equal(render_size(&scene, &o, log, &width, &height), SATIN_OK);
    assert_true(width == 20 && height == 10);
    o.width = 400;
    o.crop_x = 399;
    assert_int_equal(render_size(&scene, &o, log, &width, &height), SATIN_OK);
    assert_true(width == 1 && height == 300);
    o.crop_width = 2;
    assert_int_equal(render_size(&scene, &o, log, &width, &height), SATIN_ERROR_INPUT);
    assert_string_equal(
        message.text, "the crop of 2x300 pixels at (399, 0) is not inside of the film of 400x300");
    assert_true(width == 1 && height == 300);
}

// The side that follows from the other one can be beyond all limits.
static void sides_are_limited(void **state) {
    (void)state;
    struct message message = {0};
    const struct log log = {keep, &message};
    struct satin_scene scene = cropped_scene();
    scene.film =
        (struct scene_film){.width = 65536, .height = 1, .crop_width = 1, .crop_height = 1};
    satin_options o = satin_options_default;
    int width = 0, height = 0;
    o.height = 65536;
    assert_int_equal(render_size(&scene, &o, log, &width, &height), SATIN_ERROR_INPUT);
    assert_string_equal(message.text, "a film of 4294967296 x 65536 pixels is too large");
    o.height = 2;
    assert_int_equal(render_size(&scene, &o, log, &width, &height), SATIN_OK);
    o.width = o.height = 65536;
    o.crop_width = o.crop_height = 65536;
    assert_int_equal(render_size(&scene, &o, log, &width, &height), SATIN_ERROR_INPUT);
    assert_string_equal(message.text, "a film of 65536 x 65536 pixels is too large");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_crop_shows_the_same_region),
        cmocka_unit_test(crops_of_the_options_have_their_own_pixels),
        cmocka_unit_test(sides_are_limited),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
