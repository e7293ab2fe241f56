// SPDX-License-Identifier: Apache-2.0
// CIE 171:2006, test case 5.8: the illuminance in a closed cube with diffuse walls, which is the
// light's flux over their area, times the sum of the powers of the reflectance rho, by every
// integrator and every first pass. usage: cie_171 cie-171.xml; prints one line per illuminance.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "stat_case.h"

// Measured: at most .2 %. First passes `path` and `recursive` are .9 % dark and bright at rho .8,
// and integrator `photons`, by the noise of its photons, .6 % dark at rho .2.
#define CIE_BOUND 0.005
#define CIE_BOUND_LAST 0.015

static const double FLUX_PER_AREA = 10000.0 / 96.0;  // [lx]

struct cie_method {
    const char *integrator, *first_pass;
    int bounces;       // number of indirect bounces; < 0: all
    bool approximate;  // whether the bound is CIE_BOUND_LAST
};

// The illuminance of the wall in view [lx].
static double illuminance(const char *file, const char *rho, const struct cie_method *method) {
    const satin_define define = {"rho", rho};
    satin_scene *scene = NULL;
    if (satin_scene_load(file, &define, 1, stat_say, NULL, &scene) != SATIN_OK) return NAN;
    const satin_setting setting[] = {{"integrator", method->integrator},
                                     {"first_pass", method->first_pass},
                                     {"quality", "draft"},
                                     {"spp", "16"}};
    const double mean = stat_mean(scene, setting, 4);
    satin_scene_free(scene);
    return mean * M_PI / strtod(rho, NULL);
}

int main(int argc, char **argv) {
    static const struct cie_method method[] = {{"direct", "none", 0, false},
                                               {"two-pass", "none", 1, false},
                                               {"two-pass", "precomputed", -1, false},
                                               {"two-pass", "photons", -1, false},
                                               {"two-pass", "path", -1, true},
                                               {"two-pass", "recursive", -1, true},
                                               {"path", "none", -1, false},
                                               {"photons", "none", -1, true},
                                               {"sppm", "none", -1, false}};
    static const char *const reflectance[] = {"0.2", "0.5", "0.8"};
    int failed = 0;
    if (argc != 2) return 2;
    for (size_t i = 0; i < sizeof method / sizeof *method; i++)
        for (int k = 0; k < 3; k++) {
            const double rho = strtod(reflectance[k], NULL), bounces = method[i].bounces;
            const double sum =
                (1.0 - (bounces < 0.0 ? 0.0 : pow(rho, bounces + 1.0))) / (1.0 - rho);
            const double found = illuminance(argv[1], reflectance[k], &method[i]);
            const double error = found / (FLUX_PER_AREA * sum) - 1.0;
            const bool ok = fabs(error) < (method[i].approximate ? CIE_BOUND_LAST : CIE_BOUND);
            printf("%s, first pass %s, reflectance %s: %.2f lx of %.2f, %+.2f %%%s\n",
                   method[i].integrator, method[i].first_pass, reflectance[k], found,
                   FLUX_PER_AREA * sum, 100.0 * error, ok ? "" : " FAILED");
            failed += !ok;
        }
    return failed != 0;
}
