// SPDX-License-Identifier: Apache-2.0
// Traces photons: they leave the lights, scatter, and are stored where a smooth lobe could reflect
// them. Paths are allocated to the lights, by power or by visibility (guide_allocation.c), as one
// range of path indices each, so that the emission of every light is stratified and the choice of a
// light adds no noise. A consumer of fewer photons gets those of the first paths of each range,
// which are stratified too. Scattering ends by Russian roulette with the albedo, which keeps the
// photons' powers equal [Jensen 2001]. Shading normals have the factor of the adjoint BSDF [Veach
// 1997, 5.3.2].
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/sampling.h"
#include "photon/photon_map.h"

enum {
    CHUNK_PATHS = 2048,    // least number of paths of a chunk
    CHUNKS_MAX = 1 << 16,  // largest number of chunks of a large pass, in which a chunk can take
                           // minutes
    ASK_PATHS = 256,       // paths after which a chunk checks for cancellation
    JOIN_CHUNKS = 4,       // chunks of photons that are joined at a time
    BOUNCES_MAX = 1000     // ends paths that a mirror with albedo 1 would continue for ever
};

// The photons of one chunk of paths for one consumer.
struct consumer_photons {
    struct photon_hit *hit;
    size_t count, capacity;
    size_t first;  // index of the first of them among those of all chunks
    uint64_t stored[PHOTON_CLASSES];
};

struct chunk {
    struct consumer_photons photons[PHOTON_CONSUMERS];
    uint64_t refused;  // number of photons that are not finite
    bool failed;       // whether memory ran out
};

struct run {
    const struct photon_tracing *tracing;
    uint64_t *first;                    // light_count + 1: the first path of each light
    uint64_t *paths[PHOTON_CONSUMERS];  // by light: number of its first paths whose photons are
                                        // stored
    struct parallel *pool;
    struct chunk *chunk;
    size_t chunk_paths;   // number of paths of a chunk
    atomic_size_t count;  // number of photons stored so far
    atomic_bool failed;
};

// ---- One path ---------------------------------------------------------------------------------

struct photon_path {
    struct ray ray;
    rgb power;
    uint8_t bounces;  // these as in photon_hit
    bool last;
    enum photon_class class;             // direct, unless a chain deflects it: see class_of
    struct light_chain chain;            // of a direct photon
    unsigned classes[PHOTON_CONSUMERS];  // classes that each consumer gets from this path
    unsigned wanted;                     // classes that any of them gets
    float factor[PHOTON_CONSUMERS];      // factor of its power, for each consumer
};

static bool append(struct consumer_photons *photons, struct photon_hit hit,
                   enum photon_class class) {
    void *items = photons->hit;
    if (!array_reserve(&items, &photons->capacity, photons->count + 1, sizeof hit)) return false;
    photons->hit = items;
    photons->hit[photons->count++] = hit;
    photons->stored[class]++;
    return true;
}

static bool is_valid_hit(const struct photon_hit *hit) {
    return v3_finite(hit->p) && rgb_finite(hit->power) &&
           fminf(hit->power.r, fminf(hit->power.g, hit->power.b)) >= 0.0f;
}

// A direct photon that glass has deflected is a caustic one.
static enum photon_class class_of(const struct photon_path *photon) {
    const bool deflected =
        photon->class == PHOTON_DIRECT && !light_chain_straight(&photon->chain, photon->ray.d);
    return deflected ? PHOTON_CAUSTIC : photon->class;
}

// Where a mask lets some photons pass, the others represent all that would hit a surface without
// holes.
static bool store_photon(const struct satin_scene *scene, struct chunk *chunk,
                         const struct interaction *s, const struct photon_path *photon) {
    const vec3 wi = v3_neg(photon->ray.d), n = v3_dot(s->ng, wi) < 0.0f ? v3_neg(s->ng) : s->ng;
    const struct texture_lookup at = scene_interaction_texture_lookup(scene, s);
    const struct material *material = &scene->material[s->material];
    const float opacity = s->light < 0 ? scene_opacity_material(material, &at) : 1.0f;
    const enum photon_class class = class_of(photon);
    struct photon_hit hit = {.p = s->p,
                             .wi = photon_pack(wi),
                             .n = photon_pack(n),
                             .bounces = photon->bounces,
                             .last = photon->last};
    for (int i = 0; i < PHOTON_CONSUMERS; i++) {
        if (!(photon->classes[i] >> class & 1u)) continue;
        hit.power = rgb_scale(photon->power, photon->factor[i]);
        if (opacity < 1.0f) hit.power = rgb_scale(hit.power, 1.0f / fmaxf(opacity, 0.05f));
        if (!is_valid_hit(&hit))
            chunk->refused++;
        else if (!append(&chunk->photons[i], hit, class))
            chunk->failed = true;
    }
    return !chunk->failed;
}

// Whether the surface's side towards wi has a smooth lobe, whatever its colour: a density estimate
// beside a black texel needs the photons on it.
static bool stores_photons(const struct satin_scene *scene, const struct interaction *s, vec3 wi) {
    const struct material *m = &scene->material[s->material];
    bool behind = v3_dot(wi, s->frame.n) < 0.0f;
    struct scene_component component[MATERIAL_COMPONENTS_MAX];
    int count = scene_components(scene, s, wi, component);
    for (int i = 0; i < count; i++) {
        const struct material_side *side = component[i].side;
        unsigned lobes = side->base.model->lobes;
        if (behind && (!m->two_sided || side->one_sided))
            lobes &= brdf_transmits(&side->base) ? BRDF_DIFFUSE : 0u;
        if (lobes & BRDF_REFLECT) return true;
    }
    return false;
}

// Scatters the photon at s. False if it is absorbed, or refused because its power is not finite.
static bool scatter(const struct satin_scene *scene, const struct interaction *s, unsigned lobes,
                    struct rng *rng, struct photon_path *photon, uint64_t *refused) {
    vec3 wi = v3_neg(photon->ray.d);
    struct brdf b;
    struct frame frame;
    if (!scene_brdf(scene, s, wi, &b, &frame)) return false;
    float u_lobe = rng_float(rng), u = rng_float(rng), v = rng_float(rng);
    struct brdf_sample sample;
    if (!brdf_sample_wi(&b, frame_to_local(&frame, wi), u_lobe, (vec2){u, v}, lobes, BRDF_POWER,
                        &sample))
        return false;
    vec3 wo = frame_to_world(&frame, sample.wi);
    float in_s = fabsf(v3_dot(wi, frame.n)), in_g = fabsf(v3_dot(wi, s->ng)),
          out_s = fabsf(v3_dot(wo, frame.n)), out_g = fabsf(v3_dot(wo, s->ng));
    float adjoint = in_s * out_g / (in_g * out_s);
    rgb power = rgb_scale(rgb_mul(photon->power, sample.weight), adjoint);
    float before = rgb_max(photon->power), after = rgb_max(power);
    if (!rgb_finite(power)) {
        ++*refused;
        return false;
    }
    if (!(after > 0.0f)) return false;
    float survival = fminf(after / before, 1.0f);
    if (rng_float(rng) >= survival) return false;
    if (!(sample.lobe & BRDF_DELTA))
        photon->class = PHOTON_INDIRECT;
    else if (photon->class == PHOTON_DIRECT)
        light_chain_pass(&photon->chain, scene, s, wi, frame_to_local(&frame, wi), &sample);
    photon->power = rgb_scale(power, 1.0f / survival);
    photon->ray = scene_spawn(scene, s->p, s->ng, wo);
    return true;
}

static void follow_photon(const struct photon_tracing *tracing, struct photon_path photon,
                          struct rng *rng, struct chunk *chunk) {
    const struct satin_scene *scene = tracing->scene;
    unsigned lobes = tracing->emission ? BRDF_DELTA : BRDF_ALL;
    const int most = tracing->bounces < 0 ? BOUNCES_MAX : tracing->bounces;
    for (int bounce = 0; bounce <= most; bounce++) {
        struct interaction s;
        if (!scene_intersect(scene, &photon.ray, &s)) return;
        photon.bounces = (uint8_t)(bounce < PHOTON_BOUNCES_MOST ? bounce : PHOTON_BOUNCES_MOST);
        photon.last = bounce == tracing->bounces;
        if (photon.wanted >> class_of(&photon) & 1u &&
            stores_photons(scene, &s, v3_neg(photon.ray.d)) &&
            !store_photon(scene, chunk, &s, &photon))
            return;
        if (!scatter(scene, &s, lobes, rng, &photon, &chunk->refused)) return;
    }
}

// ---- All paths --------------------------------------------------------------------------------

static uint64_t paths_of(const struct photon_tracing *tracing,
                         const struct photon_consumer *consumer, uint32_t light) {
    if (consumer->paths == 0) return 0;
    if (tracing->emission) return guide_emission_paths(tracing->emission, light);
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

// Starts path `index` of a light. False if it has no power, or a power that is not finite.
static bool start_path(const struct run *run, uint32_t light, uint64_t index,
                       struct photon_path *photon, uint64_t *refused) {
    const struct photon_tracing *tracing = run->tracing;
    // The sequence has 2^32 points; higher bits of the index go to the seed.
    uint64_t key = rng_mix(tracing->seed + RNG_GOLDEN * (2 * light + 1) +
                           (tracing->emission ? 0x632be59bd9b4e019ull : 0)) +
                   (index >> 32);
    float u[4], factor = 1.0f;
    sample_sobol4((uint32_t)index, (uint32_t)rng_mix(key), u);
    const struct light_aim *aim = NULL;
    if (tracing->emission) {
        factor = guide_emission_warp(tracing->emission, light, index, u);
        aim = guide_emission_aim(tracing->emission);
    }
    struct light_ray start;
    if (!light_emit(tracing->scene, light, aim, u, &start)) return false;
    const float paths = (float)(run->first[light + 1] - run->first[light]);
    *photon = (struct photon_path){.ray = start.ray,
                                   .power = rgb_scale(start.power, factor / paths),
                                   .chain = light_chain_begin(start.ray.d)};
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
    struct chunk *chunk = &run->chunk[begin / run->chunk_paths];
    if (atomic_load(&run->failed)) return;
    uint32_t light = path_light(run->first, tracing->scene->light_count, begin);
    for (uint64_t path = begin; path < end && !chunk->failed; path++) {
        if ((path - begin) % ASK_PATHS == ASK_PATHS - 1 && parallel_cancelled(run->pool, worker))
            break;
        while (path >= run->first[light + 1]) light++;
        struct rng rng =
            rng_make(tracing->seed, tracing->emission ? RNG_CAUSTIC : RNG_PHOTON, path);
        struct photon_path photon;
        if (start_path(run, light, path - run->first[light], &photon, &chunk->refused))
            follow_photon(tracing, photon, &rng, chunk);
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
    const struct chunk *chunk = &run->chunk[begin / run->chunk_paths];
    (void)end;
    bytes_put_u64(out, chunk->refused);
    for (int k = 0; k < PHOTON_CONSUMERS; k++) {
        const struct consumer_photons *photons = &chunk->photons[k];
        bytes_put_u64(out, photons->count);
        bytes_put(out, photons->stored, sizeof photons->stored);
        bytes_put(out, photons->hit, photons->count * sizeof *photons->hit);
    }
}

static bool unpack_photons(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    struct run *run = ctx;
    struct chunk *chunk = &run->chunk[begin / run->chunk_paths];
    size_t own = 0;
    (void)end;
    chunk->refused = bytes_get_u64(in);
    for (int k = 0; k < PHOTON_CONSUMERS; k++) {
        struct consumer_photons *photons = &chunk->photons[k];
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
        struct consumer_photons *photons = &j->run->chunk[i].photons[j->consumer];
        if (photons->count)
            memcpy(j->hit + photons->first, photons->hit, photons->count * sizeof *photons->hit);
        free(photons->hit);
        photons->hit = NULL;
    }
}

// Joins the chunks in order.
static satin_status join(struct run *run, size_t chunks, int consumer, struct photon_trace *out) {
    struct photon_trace trace = {.hit = NULL};
    for (size_t i = 0; i < chunks; i++) {
        struct consumer_photons *photons = &run->chunk[i].photons[consumer];
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
    for (uint32_t i = 0; i < run->tracing->scene->light_count; i++)
        trace.emitted += run->paths[consumer][i];
    for (size_t i = 0; i < chunks; i++) trace.refused += run->chunk[i].refused;
    *out = trace;
    return SATIN_OK;
}

static satin_status trace_all(struct run *run, struct photon_trace out[PHOTON_CONSUMERS]) {
    if (!allocate_photon_paths(run)) return SATIN_ERROR_MEMORY;
    const size_t paths = (size_t)run->first[run->tracing->scene->light_count];
    run->chunk_paths = paths / CHUNKS_MAX > CHUNK_PATHS ? paths / CHUNKS_MAX + 1 : CHUNK_PATHS;
    const size_t chunks = paths / run->chunk_paths + (paths % run->chunk_paths != 0);
    run->chunk = array_new(chunks, sizeof *run->chunk);
    if (!run->chunk) return SATIN_ERROR_MEMORY;
    satin_status status = SATIN_OK;
    const struct parallel_results photons = {
        .pack = pack_photons, .unpack = unpack_photons, .journaled = true};
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

void photon_trace_count(const struct photon_trace *trace, struct stats *stats) {
    stats_add(stats, "photons.emitted", (double)trace->emitted);
    stats_add(stats, "photons.refused", (double)trace->refused);
    stats_add(stats, "photons.stored_direct", (double)trace->stored[PHOTON_DIRECT]);
    stats_add(stats, "photons.stored_caustic", (double)trace->stored[PHOTON_CAUSTIC]);
    stats_add(stats, "photons.stored_indirect", (double)trace->stored[PHOTON_INDIRECT]);
}

// One segment is from the light to the first surface.
int photon_bounces_left(const satin_options *o, int after) {
    if (o->max_depth < 0) return -1;
    return o->max_depth > after + 1 ? o->max_depth - after - 1 : 0;
}
