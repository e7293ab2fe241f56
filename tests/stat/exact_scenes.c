// SPDX-License-Identifier: Apache-2.0
// Scenes whose radiance is known exactly, through every estimator: mean error under 0.5 %, worst
// pixel under 2 %.
//   closed box, albedo rho, walls emit 1 - rho: radiance 1 everywhere
//   inside of a diffuse sphere, point light: indirect radiance rho^2 Phi / (4 pi^2 r^2 (1 - rho)),
//   constant, wherever the light is; with rho = 1/2, r = 1, Phi = 4 pi it is 1 / (2 pi).
// usage: exact_scenes FOLDER_OF_SCENES [ESTIMATOR]; prints one line per case.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "satin/render.h"

// Sample counts are such that the noise of a pixel is under a quarter of the bound.
struct estimator {
    const char *name;
    const char *setting[16];  // option, value, ..., NULL
};

static const struct estimator estimators[] = {
    {"path", {"integrator", "path", "spp", "16384", NULL}},
    {"photons",
     {"integrator", "photons", "spp", "16", "photons", "8000000", "photon_k", "6000", NULL}},
    {"irradiance records", {"spp", "256", "light_samples", "8", "radiance_cache", "off", NULL}},
    {"radiance records", {"spp", "256", "light_samples", "8", "radiance_diffuse", "on", NULL}},
};

struct exact_scenes_scene_case {
    const char *file;
    double exact;
    bool indirect;  // `exact` is the radiance without direct light
};

static const struct exact_scenes_scene_case exact_scenes_cases[] = {
    {"furnace-box-20.xml", 1.0, false},
    {"furnace-box-50.xml", 1.0, false},
    {"furnace-box-80.xml", 1.0, false},
    {"furnace-sphere-center.xml", 0.15915494309189535, true},
    {"furnace-sphere-off.xml", 0.15915494309189535, true},
};

enum { SIZE = 16 };

static void print_message(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    (void)severity;
    fprintf(stderr, "%s\n", message);
}

static satin_film *exact_scenes_render(const satin_scene *scene, const char *const *setting,
                                       const char *integrator) {
    satin_options options = satin_options_default;
    satin_options_preset(&options, SATIN_PRODUCTION);
    options.width = options.height = SIZE;
    for (; *setting; setting += 2)
        if (satin_options_set(&options, setting[0], setting[1], print_message, NULL)) return NULL;
    if (integrator && satin_options_set(&options, "integrator", integrator, print_message, NULL))
        return NULL;
    satin_callbacks callbacks = {.log = print_message};
    satin_film *film = NULL;
    return satin_render(scene, &options, &callbacks, &film) == SATIN_OK ? film : NULL;
}

// Mean and largest error of a channel, relative to the pixel's exact radiance: `exact`, plus the
// value of `direct` there if it is not NULL.
static void exact_scenes_errors(const satin_film *film, const satin_film *direct,
                                const char *channel, double exact, double *mean, double *worst) {
    const float *v = satin_film_channel(film, channel);
    const float *d = direct ? satin_film_channel(direct, channel) : NULL;
    double sum = 0.0;
    *worst = 0.0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        double seen_directly = d ? (double)d[i] : 0.0;
        double e = ((double)v[i] - seen_directly - exact) / (exact + seen_directly);
        sum += e;
        if (!(fabs(e) <= *worst)) *worst = fabs(e);
    }
    *mean = sum / (SIZE * SIZE);
}

static bool exact_scenes_run(const satin_scene *scene, const struct exact_scenes_scene_case *c,
                             const struct estimator *e) {
    satin_film *film = exact_scenes_render(scene, e->setting, NULL), *direct = NULL;
    if (c->indirect) direct = exact_scenes_render(scene, e->setting, "direct");
    if (!film || (c->indirect && !direct)) return false;
    double mean = 0.0, worst = 0.0;
    static const char *const channel[] = {"R", "G", "B"};
    for (int i = 0; i < 3; i++) {
        double m, w;
        exact_scenes_errors(film, direct, channel[i], c->exact, &m, &w);
        if (!(fabs(m) <= fabs(mean))) mean = m;
        if (!(w <= worst)) worst = w;
    }
    bool ok = fabs(mean) < 0.005 && worst < 0.02;
    printf("%-26s %-20s mean error %+.3f %%  worst pixel %.2f %%  %s\n", c->file, e->name,
           100.0 * mean, 100.0 * worst, ok ? "ok" : "FAILED");
    fflush(stdout);
    satin_film_free(film);
    satin_film_free(direct);
    return ok;
}

int main(int argc, char **argv) {
    if (argc < 2) return 2;
    int passed = 0, failed = 0;
    for (size_t i = 0; i < sizeof exact_scenes_cases / sizeof *exact_scenes_cases; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", argv[1], exact_scenes_cases[i].file);
        satin_scene *scene = NULL;
        if (satin_scene_load(path, NULL, 0, print_message, NULL, &scene) != SATIN_OK) return 1;
        for (size_t k = 0; k < sizeof estimators / sizeof *estimators; k++) {
            if (argc > 2 && strcmp(argv[2], estimators[k].name) != 0) continue;
            if (exact_scenes_run(scene, &exact_scenes_cases[i], &estimators[k]))
                passed++;
            else
                failed++;
        }
        satin_scene_free(scene);
    }
    printf("%d passed, %d failed\n", passed, failed);
    return failed != 0;
}
