// SPDX-License-Identifier: Apache-2.0
// Pixels along a lamp's edge are as even at few samples as the rays that look for emission alone
// make them.
// usage: rims SCENE.xml
#include <stdlib.h>

#include "stat_case.h"

enum { SIZE = 128, SEEDS = 6 };

static bool render(const satin_scene *scene, const char *spp, const char *seed, float *emission) {
    const satin_setting setting[] = {{"integrator", "direct"},
                                     {"width", "128"},
                                     {"height", "128"},
                                     {"spp", spp},
                                     {"seed", seed}};
    satin_options options;
    satin_callbacks callbacks = {.log = stat_say};
    satin_film *film = NULL;
    if (satin_options_resolve(scene, setting, 5, stat_say, NULL, &options) ||
        satin_render(scene, &options, &callbacks, &film) != SATIN_OK)
        return false;
    const float *green = satin_film_channel(film, "emission.G");
    const float *all = satin_film_channel(film, "G"),
                *direct = satin_film_channel(film, "direct.G");
    bool whole = true;
    for (int i = 0; i < SIZE * SIZE; i++) {
        emission[i] = green[i];
        // The beauty is the sum of its layers, to a rounding error of each of a few additions.
        whole = whole && fabsf(all[i] - direct[i] - green[i]) <= 1e-5f * (1.0f + all[i]);
    }
    satin_film_free(film);
    return whole;
}

int main(int argc, char **argv) {
    static const char *const seed[SEEDS] = {"1", "2", "3", "4", "5", "6"};
    static float reference[SIZE * SIZE], image[SIZE * SIZE];
    satin_scene *scene = NULL;
    if (argc != 2 || satin_scene_load(argv[1], NULL, 0, stat_say, NULL, &scene) != SATIN_OK)
        return 1;
    if (!render(scene, "256", "99", reference)) return 1;
    double square = 0.0, mean = 0.0;
    int count = 0;
    float lamp = 0.0f;
    for (int i = 0; i < SIZE * SIZE; i++) lamp = fmaxf(lamp, reference[i]);
    for (int s = 0; s < SEEDS; s++) {
        if (!render(scene, "9", seed[s], image)) return 1;
        for (int i = 0; i < SIZE * SIZE; i++) {
            const float part = reference[i] / lamp;
            if (part < 0.02f || part > 0.98f) continue;
            const double off = (double)((image[i] - reference[i]) / lamp);
            square += off * off;
            mean += off;
            count++;
        }
    }
    satin_scene_free(scene);
    const double rms = sqrt(square / count);
    mean /= count;
    // The samples alone err by .012, with the further rays by .005.
    const bool passed = count > 100 && rms < 0.008 && fabs(mean) < 4.0 * rms / sqrt(count);
    printf("%d rims: rms %.4f, mean %+.5f of the lamp\n%d passed, %d failed\n", count, rms, mean,
           passed, !passed);
    return !passed;
}
