// SPDX-License-Identifier: Apache-2.0
// Photons beyond the first batch. Where photons are many, it is the points that read them which are
// kept in memory, and the photons pass by [Havran, Herzog and Seidel 2005]. These points are here
// the entries of irradiance of the first batch instead of the hits of gather rays, which are not
// known yet. Each further batch is traced, sorted and searched from all entries, each of which sums
// the photons in the disc of its own estimate; then the batch is freed. So memory holds the entries
// and one batch, whatever the number of photons.
//
// The discs keep their radii. If they shrink from batch to batch as in photon_sppm.c, bias falls no
// faster, because it comes from the spacing of the entries more than from the width of their discs,
// while noise falls slower: 1.02 to 1.15 times the error after 4 to 64 batches
// (docs/experiments/first-passes.md).
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum { REVERSE_CHUNK = 256 };  // entries of a chunk

// The disc of an entry, apart from what struct photon_irradiance has of it.
struct reverse_disc {
    uint32_t n;   // packed normal
    int area;     // index of its area; -1: the surface covers the whole disc
    float scale;  // as in photon_disc
};

// All that is done for the entries.
struct reverse_run {
    const struct photon_reverse *what;
    struct photon_irradiance *irradiance;
    struct reverse_disc *disc;  // by entry
    struct photon_area *area;   // of the discs that are cut
    // The present batch:
    struct photon_map map;
    struct photon_trace trace;  // its counts alone
    float weight;               // its number of paths over that of all batches
    uint8_t *refused;           // by entry: whether a sum is not finite
    atomic_bool failed;
};

// ---- The discs ----------------------------------------------------------------------------------

// Makes the estimate of an entry without its photons. False if the entry has none, as the first
// batch had too few photons.
static bool disc_of(const struct reverse_run *run, size_t entry, struct photon_disc *out) {
    const struct photon_irradiance *r = run->irradiance;
    const float radius = r->radius[entry];
    if (!(radius > 0.0f) || !isfinite(radius)) return false;
    *out = (struct photon_disc){.map = &run->map,
                                .p = photon_entry_position(&r->position, entry),
                                .n = photon_unpack(run->disc[entry].n),
                                .kernel = KERNEL_FLAT,
                                .r = radius,
                                .r2 = radius * radius};
    return true;
}

static void find_disc_areas(void *ctx, size_t begin, size_t end, int worker) {
    const struct reverse_run *run = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct photon_disc disc;
        const int area = run->disc[i].area;
        if (!disc_of(run, i, &disc)) continue;
        photon_disc_scale(&disc, area < 0 ? NULL : run->what->tracing->scene);
        run->disc[i].scale = disc.scale;
        if (area >= 0) run->area[area] = disc.area;
    }
}

// Finds the discs of the entries, given the map of the first batch.
static satin_status find_entry_discs(struct reverse_run *run, const struct photon_map *first,
                                     struct parallel *pool) {
    const size_t count = run->irradiance->count;
    size_t areas = 0;
    run->disc = array_new_unset(count, sizeof *run->disc);
    run->refused = array_new(count, sizeof *run->refused);
    if (!run->disc || !run->refused) return SATIN_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++)
        run->disc[i] = (struct reverse_disc){first->photon[i * first->stride].n,
                                             first->whole_disc[i] ? -1 : (int)areas++, 0.0f};
    if (areas > 0) run->area = array_new(areas, sizeof *run->area);
    if (areas > 0 && !run->area) return SATIN_ERROR_MEMORY;
    return parallel_for(pool, count, REVERSE_CHUNK, find_disc_areas, run) ? SATIN_OK
                                                                          : SATIN_CANCELLED;
}

// ---- The sums -----------------------------------------------------------------------------------

// The rows of the photons near an entry, which grow as needed.
struct found_rows {
    int *row;
    float *distance2;
    int count, capacity;
};

// Finds all photons of the disc. False if there is no memory.
static bool find_rows(const struct photon_disc *disc, struct found_rows *found) {
    const float query[3] = {disc->p.x, disc->p.y, disc->p.z};
    for (;;) {
        if (found->capacity)
            found->count = photon_index_within(disc->map->index, query, found->capacity, disc->r2,
                                               found->row, found->distance2);
        if (found->count < found->capacity) return true;
        const int more = found->capacity ? 2 * found->capacity : 512;
        free(found->row);
        free(found->distance2);
        found->row = malloc((size_t)more * sizeof *found->row);
        found->distance2 = malloc((size_t)more * sizeof *found->distance2);
        if (!found->row || !found->distance2) return false;
        found->capacity = more;
    }
}

// Adds the light of the batch to an entry.
static void add_batch_light(const struct reverse_run *run, size_t entry,
                            const struct photon_disc *disc) {
    struct photon_irradiance *r = run->irradiance;
    const rgb E = photon_disc_irradiance(disc);
    if (!rgb_finite(E)) {
        run->refused[entry] = 1;
        return;
    }
    r->E[entry] = rgb_mad(r->E[entry], E, run->weight);
    if (r->last) r->last[entry] = rgb_mad(r->last[entry], photon_disc_last(disc), run->weight);
}

static void add_photons(void *ctx, size_t begin, size_t end, int worker) {
    struct reverse_run *run = ctx;
    struct found_rows found = {0};
    (void)worker;
    for (size_t i = begin; i < end && run->map.count > 0 && !atomic_load(&run->failed); i++) {
        struct photon_disc disc;
        if (!disc_of(run, i, &disc)) continue;
        if (!find_rows(&disc, &found)) {
            atomic_store(&run->failed, true);
            break;
        }
        disc.row = found.row;
        disc.distance2 = found.distance2;
        disc.count = found.count;
        disc.scale = run->disc[i].scale;
        disc.corrected = run->disc[i].area >= 0;
        if (disc.corrected) disc.area = run->area[run->disc[i].area];
        photon_disc_drop_hidden(run->what->tracing->scene, found.row, found.distance2, &disc);
        add_batch_light(run, i, &disc);
    }
    free(found.row);
    free(found.distance2);
}

// The counts of the batch's photons are those of the first chunk.
static void pack_counts(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct reverse_run *run = ctx;
    (void)end;
    if (begin > 0) return;
    bytes_put_u64(out, run->trace.emitted);
    bytes_put_u64(out, run->trace.refused);
    bytes_put(out, run->trace.stored, sizeof run->trace.stored);
    bytes_put(out, run->trace.power, sizeof run->trace.power);
}

static bool unpack_counts(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    struct reverse_run *run = ctx;
    (void)end;
    if (begin > 0) return true;
    run->trace.emitted = bytes_get_u64(in);
    run->trace.refused = bytes_get_u64(in);
    bytes_get(in, run->trace.stored, sizeof run->trace.stored);
    bytes_get(in, run->trace.power, sizeof run->trace.power);
    return true;
}

// ---- The batches --------------------------------------------------------------------------------

// The number of paths of the batches before this one.
static uint64_t paths_before_batch(const struct photon_reverse *what, uint64_t batch) {
    const uint64_t each = what->paths / what->batches, rest = what->paths % what->batches;
    return batch * each + (batch < rest ? batch : rest);
}

uint64_t photon_reverse_paths(const struct photon_reverse *what, uint64_t batch) {
    return paths_before_batch(what, batch + 1) - paths_before_batch(what, batch);
}

// Traces the photons of a batch and builds their map.
static satin_status trace_batch(struct reverse_run *run, uint64_t batch, struct parallel *pool,
                                struct log log, struct stats *stats) {
    const double start = stats_wall();
    struct photon_tracing tracing = *run->what->tracing;
    struct photon_trace trace[PHOTON_CONSUMERS];
    tracing.seed = rng_mix(tracing.seed + RNG_GOLDEN * batch);
    tracing.passing = true;
    tracing.batches = run->what->paths;
    tracing.consumer[0].paths = photon_reverse_paths(run->what, batch);
    for (int k = 1; k < PHOTON_CONSUMERS; k++) tracing.consumer[k].paths = 0;
    parallel_begin_part(pool, "trace");
    satin_status status = photon_trace_run(&tracing, pool, log, trace);
    if (status != SATIN_OK) return status;
    const double traced = stats_wall();
    parallel_begin_part(pool, "sort");
    status = photon_map_build(tracing.scene, trace->hit, trace->count, pool, log, &run->map);
    photon_trace_free(trace);
    run->trace = *trace;
    stats_add(stats, "photons.trace_s", traced - start);
    stats_add(stats, "photons.build_s", stats_wall() - traced);
    return status;
}

// Adds a batch to the entries, or reads their sums from the journal.
static satin_status add_batch(struct reverse_run *run, uint64_t batch, struct parallel *pool,
                              struct log log, struct stats *stats) {
    struct photon_irradiance *r = run->irradiance;
    const struct parallel_results sums = {.slot = {{r->E, sizeof *r->E},
                                                   {r->last, sizeof *r->last},
                                                   {run->refused, sizeof *run->refused}},
                                          .pack = pack_counts,
                                          .unpack = unpack_counts,
                                          .journaled = true};
    run->weight =
        (float)((double)photon_reverse_paths(run->what, batch) / (double)run->what->paths);
    if (!parallel_read_results(pool, r->count, REVERSE_CHUNK, run, &sums)) {
        satin_status status = trace_batch(run, batch, pool, log, stats);
        if (status != SATIN_OK) return status;
        const double start = stats_wall();
        parallel_begin_part(pool, "estimate");
        if (!parallel_for_results(pool, r->count, REVERSE_CHUNK, add_photons, run, &sums))
            status = SATIN_CANCELLED;
        else if (atomic_load(&run->failed))
            status = log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for irradiance");
        stats_add(stats, "photons.precompute_s", stats_wall() - start);
        photon_map_free(&run->map);
        if (status != SATIN_OK) return status;
    }
    photon_trace_count(&run->trace, stats);
    return parallel_status(pool) == SATIN_OK ? SATIN_OK : SATIN_CANCELLED;
}

satin_status photon_reverse_add(const struct photon_reverse *what, struct photon_map *first,
                                struct parallel *pool, struct log log, struct stats *stats,
                                struct photon_irradiance *irradiance) {
    stats_set(stats, "photons.batches", (double)what->batches);
    struct reverse_run run = {.what = what, .irradiance = irradiance};
    atomic_init(&run.failed, false);
    satin_status status = SATIN_OK;
    if (what->batches > 1 && irradiance->count > 0) {
        status = find_entry_discs(&run, first, pool);
        if (status == SATIN_ERROR_MEMORY) log_fail(log, status, "not enough memory for irradiance");
    }
    photon_map_free(first);
    if (irradiance->count == 0) return status;
    const float weight = (float)((double)photon_reverse_paths(what, 0) / (double)what->paths);
    for (size_t i = 0; i < irradiance->count && what->batches > 1; i++) {
        irradiance->E[i] = rgb_scale(irradiance->E[i], weight);
        if (irradiance->last) irradiance->last[i] = rgb_scale(irradiance->last[i], weight);
    }
    // The power of each batch is that of the lights: that of the first one counts with its weight.
    photon_power_scale((double)weight, stats);
    for (uint64_t b = 1; b < what->batches && status == SATIN_OK; b++)
        status = add_batch(&run, b, pool, log, stats);
    size_t refused = 0;
    for (size_t i = 0; i < irradiance->count && run.refused; i++) refused += run.refused[i];
    irradiance->refused += refused;
    stats_add(stats, "estimates.refused", (double)refused);
    free(run.disc);
    free(run.area);
    free(run.refused);
    return status;
}
