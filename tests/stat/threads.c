// SPDX-License-Identifier: Apache-2.0
// The image is bit-identical for any number of threads.
// usage: threads SCENE.xml ...; prints the hash of all channels of each render. The denoiser is
// that of SATIN_OIDN, or the one that is installed.
#include <stdio.h>
#include <string.h>

#include "base/fileio.h"
#include "stat_case.h"

// Settings that run every stage in a few seconds.
static const char *const setting[][2] = {
    {"quality", "draft"},       {"width", "48"},
    {"height", "48"},           {"spp", "6"},
    {"photons", "30000"},       {"caustic_photons", "30000"},
    {"irradiance_rays", "200"}, {"radiance_rays", "600"},
    {"adaptive_cache", "on"},   {"irradiance_radius", "hessian"},
    {"denoise", "on"},
};

struct mode {
    const char *integrator, *first_pass;
};

static uint64_t render_hash(const satin_scene *scene, const char *threads, struct mode mode) {
    satin_options options = satin_options_default;
    for (size_t i = 0; i < sizeof setting / sizeof *setting; i++)
        if (satin_options_set(&options, setting[i][0], setting[i][1], stat_say, NULL)) return 0;
    if (satin_options_set(&options, "threads", threads, stat_say, NULL)) return 0;
    if (satin_options_set(&options, "integrator", mode.integrator, stat_say, NULL) ||
        satin_options_set(&options, "first-pass", mode.first_pass, stat_say, NULL))
        return 0;
    satin_callbacks callbacks = {.log = stat_say};
    satin_film *film = NULL;
    if (satin_render(scene, &options, &callbacks, &film) != SATIN_OK) return 0;
    int width, height;
    satin_film_size(film, &width, &height);
    uint64_t hash = FILEIO_HASH;
    const char *name;
    for (int i = 0; (name = satin_film_channel_name(film, i)); i++)
        hash = fileio_hash(hash, satin_film_channel(film, name),
                           sizeof(float) * (size_t)width * (size_t)height);
    satin_film_free(film);
    return hash;
}

int main(int argc, char **argv) {
    static const char *const threads[] = {"1", "3", "8"};
    static const struct mode modes[] = {{"two-pass", "precomputed"},
                                        {"two-pass", "recursive"},
                                        {"path", "precomputed"},
                                        {"photons", "precomputed"},
                                        {"sppm", "precomputed"}};
    enum { MODES = sizeof modes / sizeof *modes, THREADS = sizeof threads / sizeof *threads };
    int failed = 0;
    for (int s = 1; s < argc; s++) {
        satin_scene *scene = NULL;
        if (satin_scene_load(argv[s], NULL, 0, stat_say, NULL, &scene) != SATIN_OK) return 1;
        for (int k = 0; k < MODES; k++) {
            uint64_t first = 0;
            for (int t = 0; t < THREADS; t++) {
                uint64_t hash = render_hash(scene, threads[t], modes[k]);
                if (t == 0) first = hash;
                bool same = hash != 0 && hash == first;
                failed += !same;
                printf("%s %s, first pass %s, --threads %s: %016llx%s\n", argv[s],
                       modes[k].integrator, modes[k].first_pass, threads[t],
                       (unsigned long long)hash, same ? "" : " DIFFERS");
            }
        }
        satin_scene_free(scene);
    }
    printf("%d passed, %d failed\n", THREADS * MODES * (argc - 1) - failed, failed);
    return failed != 0 || argc < 2;
}
