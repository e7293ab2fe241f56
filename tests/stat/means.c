// SPDX-License-Identifier: Apache-2.0
// Scenes in which few photons arrive at what the eye sees: the mean of an image in two passes is
// that of path tracing. With so few photons, images of different seeds differ by up to half of
// the bound, so that the mean over several counts. usage: means QUALITY SAMPLES SEEDS SCENE.xml,
// with the samples per pixel of path tracing and the number of images in two passes; prints a
// line.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "stat_case.h"

#define BOUND 0.02

// The standard deviation of one image is .2 % on a wide ground, .4 % with a polished mirror, and
// .8 % behind a wide pane; that of path tracing with the samples of meson.build is .1 to .3 %.
static double means_mean(const satin_scene *scene, const char *quality, const char *integrator,
                         const char *spp, int seeds) {
    double sum = 0.0;
    for (int i = 0; i < seeds; i++) {
        char seed[16];
        snprintf(seed, sizeof seed, "%d", i);
        const satin_setting setting[] = {
            {"quality", quality}, {"integrator", integrator}, {"spp", spp}, {"seed", seed}};
        sum += stat_mean(scene, setting, 4);
    }
    return sum / seeds;
}

int main(int argc, char **argv) {
    satin_scene *scene = NULL;
    if (argc != 5 || satin_scene_load(argv[4], NULL, 0, stat_say, NULL, &scene) != SATIN_OK)
        return 1;
    const double path = means_mean(scene, argv[1], "path", argv[2], 1);
    const double two = means_mean(scene, argv[1], "two-pass", "16", atoi(argv[3]));
    const double error = two / path - 1.0;
    const bool ok = fabs(error) < BOUND;
    printf("%s: path %.5f, two passes %+.2f %%%s\n", argv[4], path, 100.0 * error,
           ok ? "" : " FAILED");
    satin_scene_free(scene);
    return !ok;
}
