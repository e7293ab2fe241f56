// SPDX-License-Identifier: Apache-2.0
// The pilot of caustics: follows a few paths from everywhere on the lights, and finds which of them
// store photons that are seen. From these paths it is learnt where the caustic photons start
// (guide_emission.c).
#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "photon/photon_path.h"

enum {
    EMISSION_CHUNK = 256,
    EMISSION_LEAST = 16  // paths of the pilot of a light, however many lights there are
};

struct emission_tracing {
    const struct photon_request *request;
    const struct guide_region *region;
    struct guide_emission_pilot *pilot;
    int bounces;
    atomic_bool failed;
};

// The root of the squared powers of what a path stores where it is seen.
static float stored_power(const struct emission_tracing *t, size_t path, const float u[4],
                          struct photon_chunk *chunk) {
    const struct satin_scene *scene = t->request->scene;
    const uint32_t light = (uint32_t)(path / t->pilot->per_light);
    struct light_ray start;
    if (!light_emit(scene, light, &t->pilot->aim, u, &start) || !rgb_finite(start.power))
        return 0.0f;
    struct rng rng = rng_make(t->request->options->seed, RNG_EMISSION, path);
    const struct photon_path photon = {.ray = start.ray,
                                       .power = start.power,
                                       .unit = rgb_max(start.power),
                                       .light = light,
                                       .chain = light_chain_begin(&start.ray),
                                       .classes = {1 << PHOTON_CAUSTIC},
                                       .wanted = 1 << PHOTON_CAUSTIC,
                                       .factor = {1.0f}};
    chunk->photons[0].count = 0;
    photon_path_follow(scene, true, t->bounces, NULL, photon, &rng, chunk);
    double squares = 0.0;
    for (size_t i = 0; i < chunk->photons[0].count; i++) {
        const struct photon_hit *hit = &chunk->photons[0].hit[i];
        if (guide_region_holds(t->region, hit->p))
            squares += pow((double)rgb_luminance(hit->power), 2.0);
    }
    return (float)fmin(sqrt(squares), (double)FLT_MAX);
}

static void trace_emission(void *ctx, size_t begin, size_t end, int worker) {
    struct emission_tracing *t = ctx;
    struct photon_chunk chunk = {.failed = false};
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct guide_emission_sample *sample = &t->pilot->sample[i];
        const size_t light = i / t->pilot->per_light;
        sample_sobol4((uint32_t)(i % t->pilot->per_light),
                      (uint32_t)rng_mix(t->request->options->seed + light), sample->u);
        sample->power = stored_power(t, i, sample->u, &chunk);
    }
    free(chunk.photons[0].hit);
    if (chunk.failed) atomic_store(&t->failed, true);
}

static satin_status run_pilot(const struct photon_request *request,
                              struct guide_emission_pilot *pilot, struct parallel *pool) {
    struct emission_tracing t = {
        .request = request, .pilot = pilot, .bounces = photon_bounces_left(request->options, 1)};
    struct guide_region *region = NULL;
    atomic_init(&t.failed, false);
    if (!guide_region_make(request->scene, request->options->seed, request->paths.region, pool,
                           &region))
        return SATIN_ERROR_MEMORY;
    t.region = region;
    const size_t count = pilot->per_light * request->scene->light_count;
    satin_status status = SATIN_OK;
    if (!parallel_for(pool, count, EMISSION_CHUNK, trace_emission, &t))
        status = SATIN_CANCELLED;
    else if (atomic_load(&t.failed))
        status = SATIN_ERROR_MEMORY;
    guide_region_free(region);
    return status;
}

satin_status photon_emission_build(const struct photon_request *request, struct parallel *pool,
                                   struct log log, struct guide_emission **out) {
    const struct satin_scene *scene = request->scene;
    const struct photon_paths *paths = &request->paths;
    struct guide_emission_pilot pilot = {.scene = scene};
    *out = NULL;
    // With integrator photons, caustics are in the global map.
    if (!paths->caustic || request->options->integrator == SATIN_PHOTONS) return SATIN_OK;
    struct guide_seen seen;
    guide_seen_make(scene, request->options->seed, paths->seen, pool, &seen);
    if (!guide_aim_make(scene, &seen, &pilot.aim)) return SATIN_OK;
    const uint64_t most =
        paths->caustic < paths->emission_most ? paths->caustic : paths->emission_most;
    pilot.per_light = (size_t)(most / scene->light_count);
    if (pilot.per_light > (size_t)paths->emission) pilot.per_light = (size_t)paths->emission;
    if (pilot.per_light < EMISSION_LEAST) pilot.per_light = EMISSION_LEAST;
    pilot.sample = array_new_unset(pilot.per_light * scene->light_count, sizeof *pilot.sample);
    satin_status status = pilot.sample ? run_pilot(request, &pilot, pool) : SATIN_ERROR_MEMORY;
    if (status == SATIN_ERROR_MEMORY) log_fail(log, status, "not enough memory for caustics");
    if (status == SATIN_OK) status = guide_emission_learn(&pilot, log, out);
    free(pilot.sample);
    return status;
}
