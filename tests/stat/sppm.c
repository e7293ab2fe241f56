// SPDX-License-Identifier: Apache-2.0
// Integrator sppm converges to the truth: in a closed box of albedo rho whose walls emit 1 - rho
// the radiance of paths of at most d segments is 1 - rho^d; elsewhere the mean is that of path
// tracing of the same length, as it was measured once with 32768 samples per pixel or more. usage:
// sppm FOLDER_OF_SCENES; prints one line per scene.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "stat_case.h"

// The standard deviation of an image of the closed box is .09 %, over ten seeds: the mean of two
// has a third of the bound. More photons per pass make the lookups smaller, not the noise.
#define EXACT_BOUND 0.002
#define EXACT_IMAGES 2
#define MEAN_BOUND 0.01

struct sppm_case {
    const char *name, *max_depth;
    double rho;   // 0: the reference is by path tracing
    double mean;  // that of path tracing, with a standard deviation below .0001
};

static double sppm_mean(const satin_scene *scene, const struct sppm_case *c) {
    const int images = c->rho > 0.0 ? EXACT_IMAGES : 1;
    double sum = 0.0;
    for (int i = 0; i < images; i++) {
        const char seed[] = {(char)('0' + i), 0};
        const satin_setting setting[] = {
            {"integrator", "sppm"},       {"spp", "64"},   {"photons", "20000"},
            {"caustic_photons", "20000"}, {"width", "24"}, {"height", "24"},
            {"max_depth", c->max_depth},  {"seed", seed}};
        sum += stat_mean(scene, setting, 8);
    }
    return sum / images;
}

static bool converges(const char *folder, const struct sppm_case *c) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.xml", folder, c->name);
    satin_scene *scene = NULL;
    if (satin_scene_load(path, NULL, 0, stat_say, NULL, &scene) != SATIN_OK) return false;
    const double depth = strtod(c->max_depth, NULL);
    double truth = 1.0 - pow(c->rho, depth < 0.0 ? INFINITY : depth);
    if (!(c->rho > 0.0)) truth = c->mean;
    const double error = sppm_mean(scene, c) / truth - 1.0;
    const bool ok = fabs(error) < (c->rho > 0.0 ? EXACT_BOUND : MEAN_BOUND);
    printf("%s, max-depth %s: %.5f, sppm %+.2f %%%s\n", c->name, c->max_depth, truth, 100.0 * error,
           ok ? "" : " FAILED");
    satin_scene_free(scene);
    return ok;
}

int main(int argc, char **argv) {
    static const struct sppm_case cases[] = {
        {"furnace-box-80", "-1", 0.8, 0.0},   {"furnace-box-80", "4", 0.8, 0.0},
        {"caustic", "-1", 0.0, 0.24263},      {"cornell-metal", "-1", 0.0, 0.28623},
        {"cornell-metal", "4", 0.0, 0.27594}, {"vase", "-1", 0.0, 0.25514}};
    if (argc < 2) return 2;
    int failed = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        failed += !converges(argv[1], &cases[i]);
    return failed != 0;
}
