// SPDX-License-Identifier: Apache-2.0
// First pass `recursive` with four indirect bounces. In a closed box of albedo rho whose walls emit
// 1 - rho the radiance of paths of at most d segments is 1 - rho^d; elsewhere the mean is that of
// path tracing of the same length. usage: recursive FOLDER_OF_SCENES; prints one line per scene.
#include <math.h>
#include <stdio.h>

#include "stat_case.h"

// Measured: .04 % in the boxes, .35 % (caches are smooth where the image is not) in the other.
#define EXACT_BOUND 0.004
#define MEAN_BOUND 0.01

static double recursive_mean(const satin_scene *scene, const char *integrator, const char *spp) {
    const satin_setting setting[] = {
        {"integrator", integrator}, {"spp", spp},    {"first_pass", "recursive"},
        {"max_depth", "6"},         {"width", "24"}, {"height", "24"}};
    return stat_mean(scene, setting, 6);
}

// rho 0: the reference is by path tracing.
static bool agrees(const char *folder, const char *name, double rho) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.xml", folder, name);
    satin_scene *scene = NULL;
    if (satin_scene_load(path, NULL, 0, stat_say, NULL, &scene) != SATIN_OK) return false;
    double truth = rho > 0.0 ? 1.0 - pow(rho, 6.0) : recursive_mean(scene, "path", "4096");
    double error = recursive_mean(scene, "two-pass", "32") / truth - 1.0;
    bool ok = fabs(error) < (rho > 0.0 ? EXACT_BOUND : MEAN_BOUND);
    printf("%s: %.5f, recursive %+.2f %%%s\n", name, truth, 100.0 * error, ok ? "" : " FAILED");
    satin_scene_free(scene);
    return ok;
}

int main(int argc, char **argv) {
    if (argc < 2) return 2;
    bool ok = agrees(argv[1], "furnace-box-50", 0.5);
    ok = agrees(argv[1], "furnace-box-80", 0.8) && ok;
    ok = agrees(argv[1], "cornell-metal", 0.0) && ok;
    return ok ? 0 : 1;
}
