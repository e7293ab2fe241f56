// SPDX-License-Identifier: Apache-2.0
// CIE 171:2006, test case 5.8: the illuminance in a closed cube with diffuse walls, which is the
// light's flux over their area, times the sum of the powers of the reflectance rho, by every
// integrator and every first pass, which is also shown directly. usage: cie_171 cie-171.xml; prints
// one line per illuminance.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "stat_case.h"

// Measured: at most .4 %, that of first pass `recursive` at rho .8 (docs/experiments/agreement.md).
// Integrator `photons` is .6 % dark at rho .2, and what is stored, shown directly, up to .8 %
// bright.
#define CIE_BOUND 0.005
#define CIE_BOUND_LAST 0.015

static const double FLUX_PER_AREA = 10000.0 / 96.0;  // [lx]

struct cie_method {
    const char *integrator, *first_pass, *final_gather;
    int bounces;       // number of indirect bounces; < 0: all
    bool approximate;  // whether the bound is CIE_BOUND_LAST
    int seeds;         // number of images whose mean is taken at the largest reflectance
};
static const char *const cie_reflectance[] = {"0.2", "0.5", "0.8"};

// The noise of one image, .2 to .4 % at the largest reflectance, is at most .12 % at the others, a
// quarter of the bound.
static int seeds_of(const struct cie_method *method, int k) { return k < 2 ? 1 : method->seeds; }

// The illuminance of the wall in the image [lx].
static double illuminance(const char *file, const char *rho, const struct cie_method *method,
                          int seeds) {
    double mean = 0.0;
    const satin_define define = {"rho", rho};
    satin_scene *scene = NULL;
    if (satin_scene_load(file, &define, 1, stat_say, NULL, &scene) != SATIN_OK) return NAN;
    for (int i = 0; i < seeds; i++) {
        char seed[16];
        snprintf(seed, sizeof seed, "%d", i);
        const satin_setting setting[] = {{"integrator", method->integrator},
                                         {"first_pass", method->first_pass},
                                         {"final_gather", method->final_gather},
                                         {"quality", "draft"},
                                         {"photon_batch", "20000"},
                                         {"spp", "16"},
                                         {"seed", seed}};
        mean += stat_mean(scene, setting, sizeof setting / sizeof *setting) / seeds;
    }
    satin_scene_free(scene);
    return mean * M_PI / strtod(rho, NULL);
}

int main(int argc, char **argv) {
    static const struct cie_method method[] = {{"direct", "none", "on", 0, false, 1},
                                               {"two-pass", "none", "on", 1, false, 1},
                                               {"two-pass", "precomputed", "on", -1, false, 1},
                                               {"two-pass", "photons", "on", -1, false, 1},
                                               {"two-pass", "reverse", "on", -1, false, 1},
                                               {"two-pass", "path", "on", -1, false, 8},
                                               {"two-pass", "recursive", "on", -1, false, 8},
                                               {"two-pass", "none", "off", 0, false, 1},
                                               {"two-pass", "precomputed", "off", -1, true, 1},
                                               {"two-pass", "photons", "off", -1, true, 1},
                                               {"two-pass", "reverse", "off", -1, true, 1},
                                               {"two-pass", "path", "off", -1, false, 8},
                                               {"two-pass", "recursive", "off", -1, true, 2},
                                               {"path", "none", "on", -1, false, 8},
                                               {"photons", "none", "on", -1, true, 1},
                                               {"sppm", "none", "on", -1, false, 1}};
    int failed = 0;
    if (argc != 2) return 2;
    for (size_t i = 0; i < sizeof method / sizeof *method; i++)
        for (int k = 0; k < 3; k++) {
            const double rho = strtod(cie_reflectance[k], NULL), bounces = method[i].bounces;
            const double sum =
                (1.0 - (bounces < 0.0 ? 0.0 : pow(rho, bounces + 1.0))) / (1.0 - rho);
            const double found =
                illuminance(argv[1], cie_reflectance[k], &method[i], seeds_of(&method[i], k));
            const double error = found / (FLUX_PER_AREA * sum) - 1.0;
            const bool ok = fabs(error) < (method[i].approximate ? CIE_BOUND_LAST : CIE_BOUND);
            printf(
                "%s, first pass %s, final gather %s, reflectance %s: %.2f lx of %.2f, %+.2f %%%s\n",
                method[i].integrator, method[i].first_pass, method[i].final_gather,
                cie_reflectance[k], found, FLUX_PER_AREA * sum, 100.0 * error, ok ? "" : " FAILED");
            failed += !ok;
        }
    return failed != 0;
}
