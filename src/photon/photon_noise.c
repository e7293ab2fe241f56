// SPDX-License-Identifier: Apache-2.0
// The noise of density estimates, from the photons of one map. An estimate sums the light of many
// paths, of which each is independent of the others; so its variance is the sum over the paths of
// the square of what each of them adds. Photons of a path that bounces between near walls are in
// one estimate together, so their sum is squared.
//
// Photons have only a hash of their path, with H values. The squares of the sums by hash also have
// the products of photons that have a hash in common by chance: of all products of two paths, one
// in H. Where S is the sum of all photons and s that of a hash, (sum s^2 - S^2 / H) / (1 - 1 / H)
// has the mean of the sum of squares by path.
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    NOISE_HASHES = 64,
    NOISE_ENTRIES = 1024,  // which give the mean to 5 %, as each has 50 photons
    NOISE_CHUNK = 32       // entries of a chunk
};

struct noise_loop {
    const struct photon_maps *maps;
    const struct satin_scene *scene;
    size_t count;    // of entries that are measured
    double *noise2;  // of each; negative: it has no light
};

double photon_disc_noise2(const struct photon_disc *disc) {
    double sum[NOISE_HASHES] = {0.0}, all = 0.0, squares = 0.0;
    for (int i = 0; i < disc->count; i++) {
        const float weight = photon_disc_weight(disc, i);
        if (!(weight > 0.0f)) continue;
        const struct photon *photon = &disc->map->photon[disc->row[i]];
        const double light =
            (double)(weight * photon_unpack_tilt(photon->tilt) * rgb_luminance(photon->power));
        sum[photon->path] += light;
        all += light;
    }
    if (!(all > 0.0)) return -1.0;
    for (int i = 0; i < NOISE_HASHES; i++) squares += sum[i] * sum[i];
    return (squares / (all * all) - 1.0 / NOISE_HASHES) / (1.0 - 1.0 / NOISE_HASHES);
}

static void measure_entries(void *ctx, size_t begin, size_t end, int worker) {
    const struct noise_loop *loop = ctx;
    const struct photon_map *map = &loop->maps->global;
    const struct photon_irradiance *r = &loop->maps->irradiance;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const size_t photon = i * r->count / loop->count * map->stride;
        const struct photon_query query = {map,
                                           loop->scene,
                                           photon_position(map, photon),
                                           photon_unpack(map->photon[photon].n),
                                           loop->maps->photon_k,
                                           KERNEL_FLAT,
                                           loop->maps->area ? AREA_IF_NEEDED : AREA_WHOLE};
        int row[PHOTON_K_MAX];
        float distance2[PHOTON_K_MAX];
        struct photon_disc disc;
        photon_disc_find(&query, row, distance2, &disc);
        loop->noise2[i] = disc.r > 0.0f ? photon_disc_noise2(&disc) : -1.0;
    }
}

satin_status photon_noise_find(const struct satin_scene *scene, struct parallel *pool,
                               struct photon_maps *maps) {
    const size_t entries = maps->irradiance.count;
    struct noise_loop loop = {maps, scene, entries < NOISE_ENTRIES ? entries : NOISE_ENTRIES, NULL};
    maps->noise2 = 0.0f;
    if (loop.count == 0) return SATIN_OK;
    loop.noise2 = array_new(loop.count, sizeof *loop.noise2);
    if (!loop.noise2) return SATIN_ERROR_MEMORY;
    const struct parallel_results noise = {.slot = {{loop.noise2, sizeof *loop.noise2}}};
    const bool whole =
        parallel_for_results(pool, loop.count, NOISE_CHUNK, measure_entries, &loop, &noise);
    double sum = 0.0, lit = 0.0;
    for (size_t i = 0; whole && i < loop.count; i++) {
        if (loop.noise2[i] < 0.0) continue;
        sum += loop.noise2[i];
        lit += 1.0;
    }
    free(loop.noise2);
    if (lit > 0.0) maps->noise2 = (float)(sum / lit);
    return whole ? SATIN_OK : SATIN_CANCELLED;
}

float photon_noise2(const struct photon_maps *maps) { return maps->noise2; }
