// SPDX-License-Identifier: Apache-2.0
// The forecast of a render's time: which renders have one, what it is made of, that the time that
// is left is then known before the first record, and that the image is the same; the caller may
// cancel during it.
#include "satin/render.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "film/film.h"
#include "render/render_state.h"

enum { WIDTH = 280, HEIGHT = 200 };  // samples enough for a forecast

static satin_scene *test_forecast_scene;

// What a render reported.
struct reported {
    const char *cancel;    // the stage to be cancelled, or NULL
    bool began;            // records were reported
    double tables, first;  // the time that was left at the last report of the tables, and at the
                           // first one of records
    char message[256];
};

static void note_text(void *user, satin_log_severity severity, const char *message) {
    struct reported *reported = user;
    (void)severity;
    snprintf(reported->message, sizeof reported->message, "%s", message);
}

static bool note_left(void *user, const satin_progress *now) {
    struct reported *reported = user;
    if (strcmp(now->stage, "BRDF tables") == 0) reported->tables = now->left;
    if (strcmp(now->stage, "records") == 0 && !reported->began) {
        reported->began = true;
        reported->first = now->left;
    }
    return reported->cancel && strcmp(now->stage, reported->cancel) == 0;
}

static satin_status render_forecast_box(struct reported *reported, bool forecast,
                                        satin_film **film) {
    satin_options options = {0};
    satin_options_preset(&options, SATIN_DRAFT);
    options.width = WIDTH;
    options.height = HEIGHT;
    const satin_callbacks callbacks = {.log = note_text,
                                       .log_user = reported,
                                       .progress = note_left,
                                       .progress_user = reported,
                                       .forecast = forecast};
    *film = NULL;
    return satin_render(test_forecast_scene, &options, &callbacks, film);
}

static void the_end_is_known_before_records(void **state) {
    (void)state;
    struct reported without = {0}, with = {0};
    satin_film *film[2];
    assert_int_equal(render_forecast_box(&without, false, &film[0]), SATIN_OK);
    assert_int_equal(render_forecast_box(&with, true, &film[1]), SATIN_OK);
    assert_true(without.began && with.began);
    assert_true(without.tables < 0.0 && without.first < 0.0);
    assert_true(with.tables > 0.0 && with.first > 0.0);
    assert_null(strstr(satin_film_stats(film[0]), "time.forecast_s"));
    assert_non_null(strstr(satin_film_stats(film[1]), "time.forecast_s"));
    assert_int_equal(film[0]->channel_count, film[1]->channel_count);
    for (int i = 0; i < film[0]->channel_count; i++)
        assert_memory_equal(film[0]->channel[i], film[1]->channel[i],
                            WIDTH * HEIGHT * sizeof(float));
    satin_film_free(film[0]);
    satin_film_free(film[1]);
}

static void the_caller_may_cancel_it(void **state) {
    (void)state;
    struct reported reported = {.cancel = "forecast"};
    satin_film *film;
    assert_int_equal(render_forecast_box(&reported, true, &film), SATIN_CANCELLED);
    assert_non_null(film);
    assert_string_equal(film_attribute_get(film, "satin:cancelled"), "forecast");
    assert_non_null(strstr(reported.message, "cancelled during forecast"));
    satin_film_free(film);
}

static void only_two_passes_without_a_limit_have_one(void **state) {
    (void)state;
    static const struct {
        satin_callbacks callbacks;
        satin_options options;
        bool forecast;
    } cases[] = {
        {{.progress = note_left, .forecast = true}, {0}, true},
        {{.progress = note_left}, {0}, false},
        {{.forecast = true}, {0}, false},
        {{.progress = note_left, .forecast = true, .resume = true}, {0}, false},
        {{.progress = note_left, .forecast = true}, {.time = 5.0}, false},
        {{.progress = note_left, .forecast = true}, {.first_pass = SATIN_FIRST_RECURSIVE}, false},
        {{.progress = note_left, .forecast = true}, {.integrator = SATIN_PATH}, false},
        {{.progress = note_left, .forecast = true}, {.max_depth = 2}, false},
        {{.progress = note_left, .forecast = true}, {.width = 40}, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct render r = {.callbacks = cases[i].callbacks, .options = cases[i].options};
        if (r.options.max_depth == 0) r.options.max_depth = -1;
        r.options.final_gather = true;
        if (r.options.width == 0) r.options.width = WIDTH;
        r.options.height = HEIGHT;
        r.options.spp = 9;
        render_take_course(&r, render_first_course(&r.options));
        assert_int_equal(render_forecasts(&r), cases[i].forecast);
    }
}

// Records grow with their rays and with a power of the pixels, the image with its samples; ranks
// divide both.
static void it_grows_with_rays_and_samples(void **state) {
    (void)state;
    satin_ranks ranks = {.count = 2};
    struct render small = {
        .options = {
            .width = 10, .height = 10, .spp = 4, .irradiance_rays = 50, .radiance_rays = 100}};
    stats_set(&small.stats, "records.irradiance", 30.0);
    stats_set(&small.stats, "records.radiance", 10.0);
    stats_set(&small.stats, "time.records_s", 0.5);
    stats_set(&small.stats, "time.image_s", 0.25);
    struct render r = {.options = small.options};
    render_forecast_take(&r, &small);
    const struct render_forecast same = r.progress.forecast;
    assert_true(same.records > 0.1 && same.records < 0.5 && same.image > 0.1 && same.image < 0.5);
    // (30 * 500 + 10 * 2000) over (30 * 50 + 10 * 100) rays, 16 times the pixels, and 3 times the
    // samples in each.
    r.options = (satin_options){
        .width = 40, .height = 40, .spp = 12, .irradiance_rays = 500, .radiance_rays = 2000};
    render_forecast_take(&r, &small);
    assert_float_equal(r.progress.forecast.records / same.records, 14.0 * pow(16.0, 0.4), 1e-6);
    assert_float_equal(r.progress.forecast.image / same.image, 48.0, 1e-6);
    r.callbacks.ranks = &ranks;
    render_forecast_take(&r, &small);
    assert_float_equal(r.progress.forecast.image / same.image, 24.0, 1e-6);
}

// The forecast counts at the beginning of a stage, and its speed at the end.
static void speed_replaces_it(void **state) {
    (void)state;
    struct render r = {.progress = {.stage = STAGE_PHOTONS,
                                    .start = 100.0,
                                    .stage_start = 100.0,
                                    .forecast = {.records = 8.0, .image = 20.0}}};
    assert_true(render_progress_left(&r, 0.0, 0.1) < 0.0);
    assert_float_equal(render_progress_left(&r, 0.5, 3.0), 3.0 + 8.0 + 20.0, 1e-9);
    // Photons of caustics are expected to take until 25 seconds after the beginning.
    r.progress.photons_end = 25.0;
    assert_float_equal(render_progress_left(&r, 0.5, 3.0), 22.0 + 8.0 + 20.0, 1e-9);
    r.progress.photons_end = 0.0;
    r.progress.stage = STAGE_TABLES;
    assert_float_equal(render_progress_left(&r, 0.0, 0.1), 28.0, 1e-9);
    r.progress.stage = STAGE_RECORDS;
    assert_float_equal(render_progress_left(&r, 0.0, 2.0), 6.0 + 20.0, 1e-9);
    assert_float_equal(render_progress_left(&r, 0.0, 9.0), 20.0, 1e-9);
    r.progress.stage = STAGE_IMAGE;
    assert_float_equal(render_progress_left(&r, 0.0, 2.0), 18.0, 1e-9);
    // A quarter took 10 seconds, so all takes 40, and by the forecast 20.
    assert_float_equal(render_progress_left(&r, 0.25, 10.0), 0.75 * (15.0 + 10.0), 1e-9);
    assert_float_equal(render_progress_left(&r, 1.0, 40.0), 0.0, 1e-9);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_end_is_known_before_records),
        cmocka_unit_test(the_caller_may_cancel_it),
        cmocka_unit_test(only_two_passes_without_a_limit_have_one),
        cmocka_unit_test(it_grows_with_rays_and_samples),
        cmocka_unit_test(speed_replaces_it),
    };
    if (argc != 2 ||
        satin_scene_load(argv[1], NULL, 0, NULL, NULL, &test_forecast_scene) != SATIN_OK) {
        fprintf(stderr, "usage: render_forecast SCENE.xml\n");
        return 2;
    }
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    satin_scene_free(test_forecast_scene);
    return failed;
}
