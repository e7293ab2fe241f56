// SPDX-License-Identifier: Apache-2.0
// Where a glossy floor reads few lookups, these are gathered anew: the image varies less from seed
// to seed and has the same mean, the same for any number of threads. A diffuse scene, one bounce,
// and paths that end before need nothing.
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

enum { REFINE_SIDE = 48, REFINE_SEEDS = 6 };

static satin_scene *refine_glossy, *refine_diffuse;

// An image of few photons with one further setting.
static satin_film *render_refined(const satin_scene *scene, const char *seed, const char *threads,
                                  const char *name, const char *value) {
    const satin_setting setting[] = {{"quality", "draft"}, {"width", "48"},     {"height", "48"},
                                     {"photons", "20000"}, {"spp", "64"},       {"seed", seed},
                                     {name, value},        {"threads", threads}};
    satin_options options;
    satin_film *film = NULL;
    assert_int_equal(satin_options_resolve(scene, setting, sizeof setting / sizeof *setting, NULL,
                                           NULL, &options),
                     SATIN_OK);
    assert_int_equal(satin_render(scene, &options, NULL, &film), SATIN_OK);
    return film;
}

// What the statistics say of refined entries; 0 if nothing.
static double refined_entries(const satin_film *film) {
    const char *name = "\"first_pass.refined\": ", *at = strstr(satin_film_stats(film), name);
    return at ? strtod(at + strlen(name), NULL) : 0.0;
}

// The mean of glossy light over all seeds, and the variance of a pixel by its seed.
static void refine_measure(const char *refine, double *mean, double *variance) {
    static float Y[REFINE_SEEDS][REFINE_SIDE * REFINE_SIDE];
    *mean = *variance = 0.0;
    for (int s = 0; s < REFINE_SEEDS; s++) {
        char seed[8];
        snprintf(seed, sizeof seed, "%d", s);
        satin_film *film = render_refined(refine_glossy, seed, "0", "refine-lookups", refine);
        memcpy(Y[s], satin_film_channel(film, "indirect_glossy.G"), sizeof Y[s]);
        satin_film_free(film);
    }
    for (int i = 0; i < REFINE_SIDE * REFINE_SIDE; i++) {
        double sum = 0.0, squares = 0.0;
        for (int s = 0; s < REFINE_SEEDS; s++) {
            sum += (double)Y[s][i];
            squares += (double)Y[s][i] * (double)Y[s][i];
        }
        *mean += sum;
        *variance += (squares - sum * sum / REFINE_SEEDS) / (REFINE_SEEDS - 1);
    }
}

static void glossy_floors_vary_less(void **state) {
    (void)state;
    double mean[2], variance[2];
    refine_measure("off", &mean[0], &variance[0]);
    refine_measure("on", &mean[1], &variance[1]);
    print_message("glossy light: mean %+.2f %%, variance %.2f times\n",
                  100.0 * (mean[1] / mean[0] - 1.0), variance[1] / variance[0]);
    assert_true(fabs(mean[1] / mean[0] - 1.0) < 0.02);
    assert_true(variance[1] < 0.7 * variance[0]);
}

static void threads_change_nothing(void **state) {
    (void)state;
    satin_film *one = render_refined(refine_glossy, "3", "1", "refine-lookups", "on"),
               *three = render_refined(refine_glossy, "3", "3", "refine-lookups", "on");
    assert_true(refined_entries(one) > 20.0);
    assert_true(refined_entries(one) == refined_entries(three));
    assert_memory_equal(satin_film_channel(one, "G"), satin_film_channel(three, "G"),
                        REFINE_SIDE * REFINE_SIDE * sizeof(float));
    satin_film_free(one);
    satin_film_free(three);
}

static void nothing_is_refined_in_vain(void **state) {
    (void)state;
    const struct {
        const satin_scene *scene;
        const char *name, *value;
    } without[] = {{refine_glossy, "refine-lookups", "off"}, {refine_glossy, "max-depth", "3"},
                   {refine_glossy, "final-gather", "off"},   {refine_glossy, "first-pass", "path"},
                   {refine_glossy, "integrator", "path"},    {refine_diffuse, "max-depth", "-1"},
                   {refine_glossy, "gather-direct", "off"}};
    for (size_t i = 0; i < sizeof without / sizeof *without; i++) {
        satin_film *film =
            render_refined(without[i].scene, "0", "0", without[i].name, without[i].value);
        assert_true(refined_entries(film) == 0.0);
        satin_film_free(film);
    }
    satin_film *film = render_refined(refine_glossy, "0", "0", "max-depth", "4");
    assert_true(refined_entries(film) > 0.0);
    satin_film_free(film);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(glossy_floors_vary_less),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(nothing_is_refined_in_vain),
    };
    if (argc != 3 || satin_scene_load(argv[1], NULL, 0, NULL, NULL, &refine_glossy) != SATIN_OK ||
        satin_scene_load(argv[2], NULL, 0, NULL, NULL, &refine_diffuse) != SATIN_OK) {
        fprintf(stderr, "usage: render_refine GLOSSY.xml DIFFUSE.xml\n");
        return 2;
    }
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    satin_scene_free(refine_glossy);
    satin_scene_free(refine_diffuse);
    return failed;
}
