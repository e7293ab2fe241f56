// SPDX-License-Identifier: Apache-2.0
// The main path: its stages come in their order and under the names of satin/render.h, and a render
// that is cancelled in any of them ends with an image, and says in which; records of a time limit
// become finer until they are half a pixel wide.
#include "satin/render.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "film/film.h"
#include "scene/scene.h"

enum { STAGES_MAX = 8, OPTIONS_MAX = 8 };

static satin_scene *test_render_scene;

// What a render reported.
struct watch {
    const char *cancel;  // the stage to be cancelled, or NULL
    const char *stage[STAGES_MAX];
    int count;
    bool fell;  // `done` went down within a stage, or left [0, 1]
    double done;
    char message[256];
};

static void note_message(void *user, satin_log_severity severity, const char *message) {
    struct watch *watch = user;
    (void)severity;
    snprintf(watch->message, sizeof watch->message, "%s", message);
}

static bool note_progress(void *user, const satin_progress *now) {
    struct watch *watch = user;
    if (!watch->count || strcmp(watch->stage[watch->count - 1], now->stage) != 0) {
        assert_true(watch->count < STAGES_MAX);
        watch->stage[watch->count++] = now->stage;
        watch->done = 0.0;
    }
    watch->fell |= now->done < watch->done || now->done > 1.0;
    watch->done = now->done;
    return watch->cancel && strcmp(now->stage, watch->cancel) == 0;
}

// A draft of the box with further settings, ended by a name of NULL.
static satin_status render_box(struct watch *watch, const satin_setting *setting,
                               satin_film **film) {
    const satin_setting common[] = {{"quality", "draft"},
                                    {"width", "24"},
                                    {"height", "18"},
                                    {"photons", "2000"},
                                    {"caustic-photons", "2000"}};
    satin_options options;
    assert_int_equal(satin_options_resolve(test_render_scene, common,
                                           sizeof common / sizeof *common, NULL, NULL, &options),
                     SATIN_OK);
    for (; setting->name; setting++)
        assert_int_equal(satin_options_set(&options, setting->name, setting->value, NULL, NULL),
                         SATIN_OK);
    const satin_callbacks callbacks = {
        .log = note_message, .log_user = watch, .progress = note_progress, .progress_user = watch};
    *film = NULL;
    return satin_render(test_render_scene, &options, &callbacks, film);
}

static const satin_setting two_pass[] = {{NULL, NULL}};
static const satin_setting recursive[] = {{"first-pass", "recursive"}, {NULL, NULL}};
static const satin_setting render_path[] = {{"integrator", "path"}, {NULL, NULL}};
static const satin_setting photons[] = {{"integrator", "photons"}, {NULL, NULL}};

static void stages_come_in_their_order(void **state) {
    (void)state;
    static const struct {
        const satin_setting *setting;
        const char *stage[STAGES_MAX];
    } cases[] = {
        {two_pass, {"photons", "BRDF tables", "records", "image"}},
        {recursive, {"photons", "BRDF tables", "indirect bounces", "records", "image"}},
        {render_path, {"image"}},
        {photons, {"photons", "image"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct watch watch = {0};
        satin_film *film;
        assert_int_equal(render_box(&watch, cases[i].setting, &film), SATIN_OK);
        for (int k = 0; cases[i].stage[k] || k < watch.count; k++) {
            assert_non_null(cases[i].stage[k]);
            assert_true(k < watch.count);
            assert_string_equal(watch.stage[k], cases[i].stage[k]);
        }
        assert_false(watch.fell);
        assert_null(film_attribute_get(film, "satin:cancelled"));
        satin_film_free(film);
    }
}

// The content of the coarse image depends on the progress of the stage when the caller cancelled;
// without photons it can only be direct light.
static void a_cancelled_render_has_an_image(void **state) {
    (void)state;
    static const struct {
        const char *stage, *message;
    } cases[] = {
        {"photons", "cancelled during photons: the image is coarse, with direct light alone"},
        {"BRDF tables", "cancelled during BRDF tables: the image is coarse"},
        {"indirect bounces", "cancelled during indirect bounces: the image is coarse"},
        {"records", "cancelled during records: the image is coarse"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct watch watch = {.cancel = cases[i].stage};
        satin_film *film;
        assert_int_equal(render_box(&watch, recursive, &film), SATIN_CANCELLED);
        assert_non_null(film);
        assert_string_equal(watch.stage[watch.count - 1], cases[i].stage);
        assert_memory_equal(watch.message, cases[i].message, strlen(cases[i].message));
        assert_string_equal(film_attribute_get(film, "satin:cancelled"), cases[i].stage);
        double sum = 0.0;
        const float *green = satin_film_channel(film, "G");
        for (int k = 0; k < 24 * 18; k++) sum += (double)green[k];
        assert_true(sum > 0.0);
        satin_film_free(film);
    }
}

static void a_cancelled_image_is_what_was_sampled(void **state) {
    (void)state;
    struct watch watch = {.cancel = "image"};
    satin_film *film;
    assert_int_equal(render_box(&watch, render_path, &film), SATIN_CANCELLED);
    assert_non_null(film);
    assert_string_equal(film_attribute_get(film, "satin:cancelled"), "image");
    satin_film_free(film);
}

// A struct that was only zeroed is no render of darkness.
static void zeroed_options_are_refused(void **state) {
    (void)state;
    struct watch watch = {0};
    const satin_callbacks callbacks = {.log = note_message, .log_user = &watch};
    satin_options options = {.width = 8, .height = 8};
    satin_film *film = NULL;
    assert_int_equal(satin_render(test_render_scene, &options, &callbacks, &film),
                     SATIN_ERROR_INPUT);
    assert_null(film);
    assert_non_null(strstr(watch.message, "satin_options_preset"));
    satin_options_preset(&options, SATIN_DRAFT);
    options.integrator = SATIN_DIRECT;
    assert_int_equal(satin_render(test_render_scene, &options, &callbacks, &film), SATIN_OK);
    double sum = 0.0;
    for (int i = 0; i < 64; i++) sum += (double)satin_film_channel(film, "G")[i];
    assert_true(sum > 0.0);
    satin_film_free(film);
}

static void count_snapshot(void *user, const satin_film *film) {
    int *count = user, width, height;
    satin_film_size(film, &width, &height);
    assert_true(width == 160 && height == 120 && satin_film_channel(film, "emission.R"));
    assert_null(satin_film_stats(film));
    ++*count;
}

// Also without a progress function.
static void snapshots_do_not_change_the_image(void **state) {
    (void)state;
    int count = 0;
    satin_film *film[2] = {NULL, NULL};
    satin_options options = satin_options_default;
    options.integrator = SATIN_PATH;
    options.width = 160;
    options.height = 120;
    // Some tenths of a second on any machine.
    options.spp = 128;
    options.threads = 2;
    for (int i = 0; i < 2; i++) {
        const satin_callbacks callbacks = {.snapshot = i ? count_snapshot : NULL,
                                           .snapshot_user = &count};
        assert_int_equal(satin_render(test_render_scene, &options, &callbacks, &film[i]), SATIN_OK);
    }
    assert_true(count > 0);
    assert_int_equal(film[0]->channel_count, film[1]->channel_count);
    for (int i = 0; i < film[0]->channel_count; i++)
        assert_memory_equal(film[0]->channel[i], film[1]->channel[i], 160 * 120 * sizeof(float));
    satin_film_free(film[0]);
    satin_film_free(film[1]);
}

// If not even the first photons fit into a time limit, the second pass traces paths: the film says
// so, and has the channels of that integrator.
static void paths_replace_photons_without_time(void **state) {
    (void)state;
    static const satin_setting hurried[] = {
        {"time", "1e-9"}, {"spp", "1"}, {"denoise", "off"}, {NULL, NULL}};
    struct watch watch = {0};
    satin_film *film;
    assert_int_equal(render_box(&watch, hurried, &film), SATIN_OK);
    assert_non_null(strstr(film_attribute_get(film, "satin:options"), "integrator=path"));
    assert_null(satin_film_channel(film, "density.Y"));
    satin_film_free(film);
}

// With enough time, the rounds of records continue until half a pixel, not to a fixed round:
// after five, down to .55, a and the least radius of 3 pixels fall by 3/4 each time. Two rounds
// leave 3 * .55 * (9 / 16)^2 = .52 pixels; a third makes them .5.
static void rounds_go_on_to_half_a_pixel(void **state) {
    (void)state;
    static const satin_setting coarse[] = {{"time", "600"},
                                           {"spp", "1"},
                                           {"irradiance-rays", "16"},
                                           {"radiance-rays", "16"},
                                           {"irradiance-min-pixels", "3"},
                                           {"radiance-min-pixels", "2"},
                                           {NULL, NULL}};
    struct watch watch = {0};
    satin_film *film;
    assert_int_equal(render_box(&watch, coarse, &film), SATIN_OK);
    assert_non_null(strstr(satin_film_stats(film), "\"records.rounds\": 8,"));
    satin_film_free(film);
}

// A point of an eye ray is, by the film's matrix, at the film position of the ray.
static void the_matrix_of_the_film_is_that_of_its_rays(void **state) {
    (void)state;
    struct watch watch = {0};
    satin_film *film;
    const satin_setting direct[] = {{"integrator", "direct"}, {"spp", "1"}, {NULL, NULL}};
    assert_int_equal(render_box(&watch, direct, &film), SATIN_OK);
    assert_true(film->camera.known);
    satin_scene shifted = *test_render_scene;  // whose film has the size of the scene file
    for (int i = 0; i < 5; i++) {
        const float s = 0.1f + 0.2f * (float)i, t = 0.9f - 0.15f * (float)i;
        const struct ray ray =
            scene_camera_ray(&shifted, &shifted.camera,
                             (vec2){s * (float)shifted.film.width, t * (float)shifted.film.height},
                             (vec2){0.5f, 0.5f}, NULL);
        const vec3 point = v3_mad(ray.o, 0.5f + (float)i, ray.d);
        const float row[4] = {point.x, point.y, point.z, 1.0f};
        float out[4] = {0};
        for (int k = 0; k < 16; k++) out[k % 4] += row[k / 4] * film->camera.to_ndc[k];
        assert_true(fabsf(out[0] / out[3] - s) < 1e-5f && fabsf(out[1] / out[3] - t) < 1e-5f);
    }
    satin_film_free(film);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stages_come_in_their_order),
        cmocka_unit_test(a_cancelled_render_has_an_image),
        cmocka_unit_test(zeroed_options_are_refused),
        cmocka_unit_test(a_cancelled_image_is_what_was_sampled),
        cmocka_unit_test(snapshots_do_not_change_the_image),
        cmocka_unit_test(paths_replace_photons_without_time),
        cmocka_unit_test(the_matrix_of_the_film_is_that_of_its_rays),
        cmocka_unit_test(rounds_go_on_to_half_a_pixel),
    };
    if (argc != 2 ||
        satin_scene_load(argv[1], NULL, 0, NULL, NULL, &test_render_scene) != SATIN_OK) {
        fprintf(stderr, "usage: render SCENE.xml\n");
        return 2;
    }
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    satin_scene_free(test_render_scene);
    return failed;
}
