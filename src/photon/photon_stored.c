// SPDX-License-Identifier: Apache-2.0
// How many photons the paths of the first pass store, and the memory that these need, from a few
// paths that are traced before all others.
#include <math.h>
#include <stdlib.h>

#include "photon/photon_map.h"

// Paths of the pilot for each map, which follow from its accuracy, not from a budget. The number of
// photons of a path is at most about the number of its bounces, whose standard deviation is near
// their mean: 4096 paths give the mean within 2 %.
enum { PILOT_PATHS = 4096 };
// Paths that show whether all have very many bounces: their mean within a tenth.
enum { BOUNCES_PATHS = 256 };

// Bytes per stored photon at the peak of building a map, measured in corner and cornell-glossy with
// .4 to 3.4 million photons (92 to 98 in the global map, 97 with integrator photons), and in
// caustic with .17 million (149 in the caustic map, whose every photon has precomputed irradiance).
// Integrator sppm has the photons of the first pass, of one and of the next (201 to 250; of the
// caustic ones up to 1.16 times as many as the pilot finds, whose paths are not aimed as well). A
// further batch of first pass `reverse` is in memory beside the entries of the first one: 50 more
// in indirect-room, with 1.2 million photons of a batch.
static const double GLOBAL_BYTES = 100.0, CAUSTIC_BYTES = 150.0, PASS_BYTES = 280.0,
                    BATCH_BYTES = 150.0;
// Photons that are only summed, or sorted into clusters: twice while their chunks are joined.
static const double HIT_BYTES = 2.0 * sizeof(struct photon_hit);

static double stored_per_path(const struct photon_trace *trace, unsigned classes) {
    double sum = 0.0;
    for (int c = 0; c < PHOTON_CLASSES; c++)
        if (classes >> c & 1u) sum += (double)trace->stored[c];
    return trace->emitted ? sum / (double)trace->emitted : 0.0;
}

static satin_status trace_pilot(const struct photon_tracing *tracing, struct parallel *pool,
                                struct log log, struct photon_trace *out) {
    struct photon_trace trace[PHOTON_CONSUMERS] = {0};
    const satin_status status = photon_trace_run(tracing, pool, log, trace);
    *out = trace[0];
    photon_trace_free(out);
    return status;
}

static satin_status trace_caustic_pilot(const struct photon_request *request, struct parallel *pool,
                                        struct log log, struct photon_trace *out) {
    const satin_options *o = request->options;
    struct guide_emission *emission = NULL;
    struct photon_request few = *request;
    few.paths.caustic = PILOT_PATHS;
    satin_status status = photon_emission_build(&few, pool, log, &emission);
    *out = (struct photon_trace){0};
    if (status != SATIN_OK || !emission) return status;
    const struct photon_tracing tracing = {
        .scene = request->scene,
        .seed = o->seed,
        .consumer = {{.paths = PILOT_PATHS, .classes = 1 << PHOTON_CAUSTIC}},
        .bounces = photon_bounces_left(o, 1),
        .emission = emission};
    status = trace_pilot(&tracing, pool, log, out);
    guide_emission_free(emission);
    return status;
}

satin_status photon_count_stored(const struct photon_request *request, struct parallel *pool,
                                 struct log log, double *per_path) {
    const unsigned all = 1 << PHOTON_DIRECT | 1 << PHOTON_CAUSTIC | 1 << PHOTON_INDIRECT;
    const struct photon_tracing tracing = {
        .scene = request->scene,
        .seed = request->options->seed,
        .consumer = {{.paths = BOUNCES_PATHS, .classes = all}},
        .bounces = photon_bounces_left(request->options, photon_hit_depth(request->options)),
        .aim = request->aim};
    struct photon_trace trace;
    const satin_status status = trace_pilot(&tracing, pool, log, &trace);
    if (status == SATIN_OK) *per_path = stored_per_path(&trace, all);
    return status;
}

satin_status photon_memory_measure(const struct photon_request *request, struct parallel *pool,
                                   struct log log, struct photon_memory *out) {
    const satin_options *o = request->options;
    const bool shown = o->integrator == SATIN_PHOTONS, passes = o->integrator == SATIN_SPPM;
    const unsigned all = 1 << PHOTON_DIRECT | 1 << PHOTON_CAUSTIC | 1 << PHOTON_INDIRECT;
    const unsigned bounced = 1 << PHOTON_CAUSTIC | 1 << PHOTON_INDIRECT;
    struct guide_allocation allocation;
    guide_allocation_make(request->scene, o->seed, request->paths.seen, pool, &allocation);
    const struct photon_tracing tracing = {
        .scene = request->scene,
        .seed = o->seed,
        .consumer = {{.paths = PILOT_PATHS, .classes = all, .allocation = &allocation}},
        .bounces = photon_bounces_left(o, photon_hit_depth(o)),
        .aim = request->aim};
    struct photon_trace global, caustic = {0};
    satin_status status = trace_pilot(&tracing, pool, log, &global);
    if (status == SATIN_OK && request->paths.caustic)
        status = trace_caustic_pilot(request, pool, log, &caustic);
    if (status != SATIN_OK) return status;
    const bool direct = !passes && (!o->gather_direct || shown);
    out->global =
        stored_per_path(&global, direct ? all : bounced) * (passes              ? PASS_BYTES
                                                            : photon_streams(o) ? BATCH_BYTES
                                                                                : GLOBAL_BYTES);
    out->clusters = stored_per_path(&global, all) * HIT_BYTES;
    out->direct = stored_per_path(&global, 1 << PHOTON_DIRECT) * HIT_BYTES;
    out->caustic = stored_per_path(&caustic, all) * (passes ? PASS_BYTES : CAUSTIC_BYTES);
    return SATIN_OK;
}

double photon_memory_bytes(const struct photon_memory *memory, const struct photon_paths *paths) {
    return memory->global * (double)paths->batch + memory->clusters * (double)paths->clusters +
           memory->direct * (double)paths->direct + memory->caustic * (double)paths->caustic;
}
