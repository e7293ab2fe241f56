// SPDX-License-Identifier: Apache-2.0
// Traces the photons of all lights. Paths are allocated to the lights, by power or by visibility
// (guide_allocation.c), as one range of path indices each, so that the emission of every light is
// stratified and the choice of a light adds no noise. A consumer of fewer photons gets those of the
// first paths of each range, which are stratified too.
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/sampling.h"
#include "photon/photon_path.h"

enum {
    CHUNK_PATHS = 2048,    // least number of paths of a chunk
    CHUNKS_MAX = 1 << 16,  // largest number of chunks of a large pass, in which a chunk can take
                           // minutes
    ASK_PATHS = 256,       // paths after which a chunk checks for cancellation
    JOIN_CHUNKS = 4        // chunks of photons that are joined at a time
};

struct run {
    const struct photon_tracing *tracing;
    uint64_t *first;                    // light_count + 1: the first path of each light
    uint64_t *paths[PHOTON_CONSUMERS];  // by light: number of its first paths whose photons are
                                        // stored
    struct parallel *pool;
    struct photon_chunk *chunk;
    size_t chunk_paths;   // number of paths of a chunk
    atomic_size_t count;  // number of photons stored so far
    atomic_bool failed;
};

static uint64_t paths_of(const struct photon_tracing *tracing,
                         const struct photon_consumer *consumer, uint32_t light) {
    if (consumer->paths == 0) return 0;
    if (tracing->emission) return guide_emission_paths(tracing->emission, consumer->paths, light);
    const float *cdf = tracing->scene->light_cdf;
    double fraction = (double)cdf[light + 1] - (double)cdf[light];
    if (consumer->allocation && !consumer->allocation->by_power)
        fraction = (double)consumer->allocation->fraction[light];
    uint64_t n = (uint64_t)llround(fraction * (double)consumer->paths);
    return n > 0 ? n : 1;  // at least one path even for the faintest light
}

// Allocates the paths of each light. The consumer of most paths determines their number.
static bool allocate_photon_paths(struct run *run) {
    const uint32_t lights = run->tracing->scene->light_count;
    run->first = array_new(lights + 1, sizeof *run->first);
    run->paths[0] = array_new(PHOTON_CONSUMERS * (size_t)lights, sizeof *run->paths[0]);
    if (!run->first || !run->paths[0]) return false;
    for (int k = 0; k < PHOTON_CONSUMERS; k++) run->paths[k] = run->paths[0] + k * (size_t)lights;
    for (uint32_t i = 0; i < lights; i++) {
        uint64_t most = 0;
        for (int k = 0; k < PHOTON_CONSUMERS; k++) {
            const uint64_t paths = paths_of(run->tracing, &run->tracing->consumer[k], i);
            run->paths[k][i] = paths;
            if (paths > most) most = paths;
        }
        run->first[i + 1] = run->first[i] + most;
    }
    return true;
}

static uint32_t path_light(const uint64_t *first, uint32_t lights, uint64_t path) {
    uint32_t lo = 0, hi = lights;
    while (hi - lo > 1) {
        uint32_t mid = lo + (hi - lo) / 2;
        if (first[mid] <= path)
            lo = mid;
        else
            hi = mid;
    }
    return lo;
}

// The sequence has 2^32 points; higher bits of the index go to the seed.
void photon_start_numbers(const struct photon_tracing *tracing, uint32_t light, uint64_t index,
                          float u[4]) {
    const uint64_t key = rng_mix(tracing->seed + RNG_GOLDEN * (2 * light + 1) +
                                 (tracing->emission ? 0x632be59bd9b4e019ull : 0)) +
                         (index >> 32);
    sample_sobol4((uint32_t)index, (uint32_t)rng_mix(key), u);
}

// Starts path `index` of a light. False if it has no power, or a power that is not finite.
static bool start_path(const struct run *run, uint32_t light, uint64_t index,
                       struct photon_path *photon, uint64_t *refused) {
    const struct photon_tracing *tracing = run->tracing;
    float u[4], factor = 1.0f;
    photon_start_numbers(tracing, light, index, u);
    const struct light_aim *aim = tracing->aim;
    if (tracing->emission) {
        factor =
            guide_emission_warp(tracing->emission, tracing->consumer[0].paths, light, index, u);
        aim = guide_emission_aim(tracing->emission);
    }
    struct light_ray start;
    if (!light_emit(tracing->scene, light, aim, u, &start)) return false;
    const float paths = (float)(run->first[light + 1] - run->first[light]);
    const rgb power = rgb_scale(start.power, factor / paths);
    *photon = (struct photon_path){.ray = start.ray,
                                   .power = power,
                                   .unit = rgb_max(power),
                                   .entering = start.entering * rgb_max(power),
                                   .light = light,
                                   .chain = light_chain_begin(&start.ray)};
    for (int k = 0; k < PHOTON_CONSUMERS; k++) {
        if (index >= run->paths[k][light]) continue;
        photon->classes[k] = tracing->consumer[k].classes;
        photon->wanted |= photon->classes[k];
        photon->factor[k] = paths / (float)run->paths[k][light];
    }
    if (!rgb_finite(photon->power)) ++*refused;
    return rgb_finite(photon->power) && rgb_max(photon->power) > 0.0f;
}

static void trace_photon_paths(void *ctx, size_t begin, size_t end, int worker) {
    struct run *run = ctx;
    const struct photon_tracing *tracing = run->tracing;
    struct photon_chunk *chunk = &run->chunk[begin / run->chunk_paths];
    if (atomic_load(&run->failed)) return;
    uint32_t light = path_light(run->first, tracing->scene->light_count, begin);
    for (uint64_t path = begin; path < end && !chunk->failed; path++) {
        if ((path - begin) % ASK_PATHS == ASK_PATHS - 1 && parallel_cancelled(run->pool, worker))
            break;
        while (path >= run->first[light + 1]) light++;
        struct rng rng =
            rng_make(tracing->seed, tracing->emission ? RNG_CAUSTIC : RNG_PHOTON, path);
        struct photon_path photon;
        if (!start_path(run, light, path - run->first[light], &photon, &chunk->refused)) continue;
        photon.path = (uint8_t)(rng_mix(path) >> 58);
        chunk->power[photon_power_index(light)].emitted += (double)rgb_luminance(photon.power);
        photon_path_follow(tracing->scene, tracing->emission != NULL, tracing->bounces,
                           tracing->aim ? tracing->aim->openings : NULL, photon, &rng, chunk);
    }
    // The kd-tree numbers photons by int.
    size_t own = 0;
    for (int k = 0; k < PHOTON_CONSUMERS; k++) own += chunk->photons[k].count;
    if (chunk->failed || atomic_fetch_add(&run->count, own) + own > INT_MAX)
        atomic_store(&run->failed, true);
}

// The photons of a chunk as bytes: their counts, then the hits of each consumer.
static void pack_photons(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct run *run = ctx;
    const struct photon_chunk *chunk = &run->chunk[begin / run->chunk_paths];
    (void)end;
    out->failed = out->failed || atomic_load(&run->failed);
    bytes_put_u64(out, chunk->refused);
    bytes_put(out, chunk->power, sizeof chunk->power);
    for (int k = 0; k < PHOTON_CONSUMERS; k++) {
        const struct photon_stored *photons = &chunk->photons[k];
        bytes_put_u64(out, photons->count);
        bytes_put(out, photons->stored, sizeof photons->stored);
        bytes_put(out, photons->hit, photons->count * sizeof *photons->hit);
    }
}

static bool unpack_photons(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    struct run *run = ctx;
    struct photon_chunk *chunk = &run->chunk[begin / run->chunk_paths];
    size_t own = 0;
    (void)end;
    chunk->refused = bytes_get_u64(in);
    bytes_get(in, chunk->power, sizeof chunk->power);
    for (int k = 0; k < PHOTON_CONSUMERS; k++) {
        struct photon_stored *photons = &chunk->photons[k];
        const uint64_t count = bytes_get_u64(in);
        bytes_get(in, photons->stored, sizeof photons->stored);
        if (in->failed || count > in->left / sizeof *photons->hit) return false;
        photons->count = photons->capacity = (size_t)count;
        own += photons->count;
        if (count == 0) continue;
        photons->hit = malloc(photons->count * sizeof *photons->hit);
        if (!photons->hit) return false;
        bytes_get(in, photons->hit, photons->count * sizeof *photons->hit);
    }
    if (atomic_fetch_add(&run->count, own) + own > INT_MAX) atomic_store(&run->failed, true);
    return true;
}

struct joining {
    struct run *run;
    int consumer;
    struct photon_hit *hit;
};

// Moves the photons of some chunks to their indices and frees the chunks.
static void copy_chunks(void *ctx, size_t begin, size_t end, int worker) {
    const struct joining *j = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct photon_stored *photons = &j->run->chunk[i].photons[j->consumer];
        if (photons->count)
            memcpy(j->hit + photons->first, photons->hit, photons->count * sizeof *photons->hit);
        free(photons->hit);
        photons->hit = NULL;
    }
}

// Adds a fraction of the power of a chunk.
static void add_power(const struct photon_chunk *chunk, double fraction,
                      struct photon_power sum[PHOTON_POWERS]) {
    for (int i = 0; i < PHOTON_POWERS; i++) {
        sum[i].emitted += fraction * chunk->power[i].emitted;
        sum[i].absorbed += fraction * chunk->power[i].absorbed;
        sum[i].escaped += fraction * chunk->power[i].escaped;
        sum[i].ended += fraction * chunk->power[i].ended;
    }
}

// Joins the chunks in order.
static satin_status join(struct run *run, size_t chunks, int consumer, struct photon_trace *out) {
    const struct photon_tracing *tracing = run->tracing;
    const double paths = (double)tracing->consumer[0].paths,
                 fraction = tracing->batches ? paths / (double)tracing->batches : 1.0;
    struct photon_trace trace = {.hit = NULL};
    for (size_t i = 0; i < chunks; i++) {
        struct photon_stored *photons = &run->chunk[i].photons[consumer];
        photons->first = trace.count;
        trace.count += photons->count;
        for (int c = 0; c < PHOTON_CLASSES; c++) trace.stored[c] += photons->stored[c];
    }
    if (trace.count) trace.hit = malloc(trace.count * sizeof *trace.hit);
    if (trace.count && !trace.hit) return SATIN_ERROR_MEMORY;
    struct joining joining = {run, consumer, trace.hit};
    if (!parallel_for(run->pool, chunks, JOIN_CHUNKS, copy_chunks, &joining)) {
        free(trace.hit);
        return SATIN_CANCELLED;
    }
    for (uint32_t i = 0; i < tracing->scene->light_count; i++)
        trace.emitted += run->paths[consumer][i];
    for (size_t i = 0; i < chunks; i++) {
        trace.refused += run->chunk[i].refused;
        if (!tracing->emission && !tracing->repeated)
            add_power(&run->chunk[i], fraction, trace.power);
    }
    *out = trace;
    return SATIN_OK;
}

// The number of the loop in the journal; 0: it is not a passing one.
static uint32_t passing_number(const struct photon_tracing *tracing) {
    const uint32_t number = (uint32_t)rng_mix(tracing->seed + (tracing->emission != NULL));
    return !tracing->passing ? 0 : number ? number : 1;
}

static satin_status trace_all(struct run *run, struct photon_trace out[PHOTON_CONSUMERS]) {
    if (!allocate_photon_paths(run)) return SATIN_ERROR_MEMORY;
    const size_t paths = (size_t)run->first[run->tracing->scene->light_count];
    run->chunk_paths = paths / CHUNKS_MAX > CHUNK_PATHS ? paths / CHUNKS_MAX + 1 : CHUNK_PATHS;
    const size_t chunks = paths / run->chunk_paths + (paths % run->chunk_paths != 0);
    run->chunk = array_new(chunks, sizeof *run->chunk);
    if (!run->chunk) return SATIN_ERROR_MEMORY;
    satin_status status = SATIN_OK;
    const struct parallel_results photons = {.pack = pack_photons,
                                             .unpack = unpack_photons,
                                             .journaled = true,
                                             .passing = passing_number(run->tracing)};
    if (!parallel_for_results(run->pool, paths, run->chunk_paths, trace_photon_paths, run,
                              &photons))
        status = SATIN_CANCELLED;
    else if (atomic_load(&run->failed))
        status = SATIN_ERROR_MEMORY;
    for (int k = 0; k < PHOTON_CONSUMERS; k++) {
        if (status == SATIN_OK) status = join(run, chunks, k, &out[k]);
        for (size_t i = 0; i < chunks; i++) free(run->chunk[i].photons[k].hit);
    }
    return status;
}

satin_status photon_trace_run(const struct photon_tracing *tracing, struct parallel *pool,
                              struct log log, struct photon_trace out[PHOTON_CONSUMERS]) {
    struct photon_trace trace[PHOTON_CONSUMERS] = {0};
    struct run run = {.tracing = tracing, .pool = pool};
    atomic_init(&run.failed, false);
    atomic_init(&run.count, 0);
    bool some = false;
    for (int k = 0; k < PHOTON_CONSUMERS; k++) some = some || tracing->consumer[k].paths > 0;
    satin_status status = SATIN_OK;
    if (tracing->scene->light_count > 0 && some) status = trace_all(&run, trace);
    free(run.chunk);
    free(run.first);
    free(run.paths[0]);
    for (int k = 0; k < PHOTON_CONSUMERS; k++) {
        if (status == SATIN_OK)
            out[k] = trace[k];
        else
            photon_trace_free(&trace[k]);
    }
    if (status == SATIN_ERROR_MEMORY)
        log_fail(log, status, "not enough memory for the photons; ask for fewer");
    return status;
}

void photon_trace_free(struct photon_trace *trace) {
    free(trace->hit);
    trace->hit = NULL;
    trace->count = 0;
}

// ---- Statistics ---------------------------------------------------------------------------------

// Adds the power of the paths of a light, or of all (-1), to the statistics of this.
static void count_power(const struct photon_power *power, int light, struct stats *stats) {
    const struct {
        const char *name;
        double value;
    } entry[] = {{"emitted", power->emitted},
                 {"absorbed", power->absorbed},
                 {"escaped", power->escaped},
                 {"ended", power->ended}};
    for (size_t i = 0; i < sizeof entry / sizeof *entry; i++) {
        char name[STATS_NAME];
        if (light < 0)
            snprintf(name, sizeof name, "photons.power_%s", entry[i].name);
        else
            snprintf(name, sizeof name, "photons.light_%d.power_%s", light, entry[i].name);
        stats_add(stats, name, entry[i].value);
    }
}

void photon_power_scale(double factor, struct stats *stats) {
    for (int i = 0; i < stats->count; i++)
        if (strstr(stats->entry[i].name, "power_")) stats->entry[i].value *= factor;
}

void photon_trace_count(const struct photon_trace *trace, struct stats *stats) {
    stats_add(stats, "photons.emitted", (double)trace->emitted);
    stats_add(stats, "photons.refused", (double)trace->refused);
    for (int i = 0; i < PHOTON_POWERS; i++) count_power(&trace->power[i], -1, stats);
    for (int i = 0; i < PHOTON_POWERS; i++)
        if (trace->power[i].emitted > 0.0) count_power(&trace->power[i], i, stats);
    stats_add(stats, "photons.stored_direct", (double)trace->stored[PHOTON_DIRECT]);
    stats_add(stats, "photons.stored_caustic", (double)trace->stored[PHOTON_CAUSTIC]);
    stats_add(stats, "photons.stored_indirect", (double)trace->stored[PHOTON_INDIRECT]);
}

// One segment is from the light to the first surface.
int photon_bounces_left(const satin_options *o, int after) {
    if (o->max_depth < 0) return -1;
    return o->max_depth > after + 1 ? o->max_depth - after - 1 : 0;
}
