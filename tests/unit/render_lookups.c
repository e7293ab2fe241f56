// SPDX-License-Identifier: Apache-2.0
// Each first pass states the noise of its lookups in the statistics of a render, the same for any
// number of threads; renders without gather rays state none.
#include "satin/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "film/film.h"

static satin_scene *lookups_scene;

// What a first pass states; NAN where it states nothing.
struct stated {
    double lookups, error, sampled, stored, cpu_s;
};

static double stated_value(const char *json, const char *name) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"first_pass.%s\": ", name);
    const char *at = strstr(json, quoted);
    return at ? strtod(at + strlen(quoted), NULL) : (double)NAN;
}

// A small draft of the scene with one further setting.
static struct stated render_lookups_of(const char *name, const char *value, const char *threads) {
    const satin_setting setting[] = {{"quality", "draft"},
                                     {"width", "36"},
                                     {"height", "30"},
                                     {"photons", "20000"},
                                     {"photon-batch", "5000"},
                                     {"caustic-photons", "2000"},
                                     {"threads", threads},
                                     {"irradiance-rays", "32"},
                                     {"radiance-rays", "64"},
                                     {"spp", "1"},
                                     {name, value}};
    satin_options options;
    satin_film *film = NULL;
    assert_int_equal(satin_options_resolve(lookups_scene, setting, sizeof setting / sizeof *setting,
                                           NULL, NULL, &options),
                     SATIN_OK);
    assert_int_equal(satin_render(lookups_scene, &options, NULL, &film), SATIN_OK);
    const char *json = film->stats;
    assert_non_null(json);
    const struct stated stated = {stated_value(json, "lookups"), stated_value(json, "error"),
                                  stated_value(json, "error_sampled"),
                                  stated_value(json, "error_stored"),
                                  stated_value(json, "lookup_cpu_s")};
    satin_film_free(film);
    return stated;
}

static void each_first_pass_states_its_noise(void **state) {
    (void)state;
    static const struct {
        const char *name;
        bool stores;  // photons or records
    } pass[] = {{"photons", true},   {"precomputed", true}, {"reverse", true},
                {"recursive", true}, {"path", false},       {"none", false}};
    double error[6], stored[6];
    for (int i = 0; i < 6; i++) {
        const struct stated one = render_lookups_of("first-pass", pass[i].name, "1"),
                            three = render_lookups_of("first-pass", pass[i].name, "3");
        print_message("%s: %.0f lookups, %.4f, sampled %.4f, stored %.4f\n", pass[i].name,
                      one.lookups, one.error, one.sampled, one.stored);
        assert_true(one.lookups > 500.0 && one.lookups <= 1024.0);
        assert_true(one.error > 0.0 && one.cpu_s > 0.0);
        assert_true(fabs(hypot(one.sampled, one.stored) / one.error - 1.0) < 1e-6);
        assert_true(pass[i].stores == (one.stored > 0.0));
        assert_true(one.lookups == three.lookups && one.sampled == three.sampled &&
                    one.stored == three.stored);
        error[i] = one.error;
        stored[i] = one.stored;
    }
    // One map has the noise of 50 photons at most, batches have less, and paths are the noisiest.
    assert_true(stored[0] < 0.25 && stored[1] < 0.25 && stored[2] < 0.7 * stored[1]);
    for (int i = 0; i < 4; i++) assert_true(error[i] < error[4]);
}

static void other_integrators_state_none(void **state) {
    (void)state;
    assert_true(isnan(render_lookups_of("integrator", "path", "1").error));
    assert_true(isnan(render_lookups_of("integrator", "photons", "1").error));
    assert_true(isnan(render_lookups_of("max-depth", "2", "1").error));
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_first_pass_states_its_noise),
        cmocka_unit_test(other_integrators_state_none),
    };
    if (argc != 2 || satin_scene_load(argv[1], NULL, 0, NULL, NULL, &lookups_scene) != SATIN_OK) {
        fprintf(stderr, "usage: render_lookups SCENE.xml\n");
        return 2;
    }
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    satin_scene_free(lookups_scene);
    return failed;
}
