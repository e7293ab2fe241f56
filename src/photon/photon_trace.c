// SPDX-License-Identifier: Apache-2.0
// Pass 1a: photons leave the lights, scatter and are kept where a smooth lobe could reflect them.
// Paths are dealt to the lights, by power or by what is seen of it (photon_deal.c), in one run of
// path indices each, so that well-spread numbers make the emission of every light even and no
// choice of a light adds noise. Scattering ends by Russian roulette at the albedo, which keeps the
// photons' powers alike [Jensen 2001]; shading normals get the factor of the adjoint BSDF [Veach
// 1997, 5.3.2].
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/sampling.h"
#include "photon/photon_map.h"

enum {
    CHUNK_PATHS = 2048,    // at least; large passes have
    CHUNKS_MAX = 1 << 16,  // no more chunks than this
    BOUNCES_MAX = 1000     // ends paths that a mirror with albedo 1 would keep for ever
};

// The hits of one chunk of paths.
struct chunk {
    struct photon_hit *hit;
    size_t count, capacity;
    uint64_t stored[PHOTON_CLASSES];
    bool failed;  // no memory
};

struct run {
    const struct photon_tracing *tracing;
    uint64_t *first;  // light_count + 1: the first path of each light
    struct chunk *chunk;
    size_t grain;         // paths of a chunk
    atomic_size_t count;  // photons kept so far
    atomic_bool failed;
};

// ---- One path ---------------------------------------------------------------------------------

// Where a mask lets photons pass, those that stop stand for all that would come to whole surface.
static bool keep_hit(const struct satin_scene *scene, struct chunk *chunk, const struct surfel *s,
                     vec3 wi, rgb power) {
    struct texture_place at = surfel_texture_place(scene, s);
    float opacity = s->light < 0 ? material_opacity(&scene->material[s->material], &at) : 1.0f;
    if (opacity < 1.0f) power = rgb_scale(power, 1.0f / fmaxf(opacity, 0.05f));
    size_t n = chunk->count + 1;
    void *items = chunk->hit;
    if (!array_reserve(&items, &chunk->capacity, n, sizeof *chunk->hit)) {
        chunk->failed = true;
        return false;
    }
    chunk->hit = items;
    vec3 n_side = v3_dot(s->ng, wi) < 0.0f ? v3_neg(s->ng) : s->ng;
    chunk->hit[chunk->count++] =
        (struct photon_hit){s->p, power, photon_pack(wi), photon_pack(n_side)};
    return true;
}

// Whether the surface's side towards wi has a smooth lobe, whatever its colour: a density estimate
// beside a black texel needs the photons on it.
static bool keeps_photons(const struct satin_scene *scene, const struct surfel *s, vec3 wi) {
    const struct material *m = &scene->material[s->material];
    bool behind = v3_dot(wi, s->frame.n) < 0.0f;
    struct scene_part part[MATERIAL_PARTS_MAX];
    int parts = scene_parts(scene, s, wi, part);
    for (int i = 0; i < parts; i++) {
        const struct material_side *side = part[i].side;
        unsigned lobes = side->base.model->lobes;
        if (behind && (!m->two_sided || side->one_sided))
            lobes &= brdf_transmits(&side->base) ? BRDF_DIFFUSE : 0u;
        if (lobes & BRDF_REFLECT) return true;
    }
    return false;
}

struct flight {
    struct ray ray;
    rgb power;
    enum photon_class class;
};

// Scatters the photon at s; false if it is absorbed.
static bool scatter(const struct satin_scene *scene, const struct surfel *s, unsigned lobes,
                    struct rng *rng, struct flight *f) {
    vec3 wi = v3_neg(f->ray.d);
    struct brdf b;
    struct frame frame;
    if (!scene_brdf(scene, s, wi, &b, &frame)) return false;
    float u_lobe = rng_float(rng), u = rng_float(rng), v = rng_float(rng);
    struct brdf_sample sample;
    if (!brdf_sample(&b, frame_to_local(&frame, wi), u_lobe, u, v, lobes, BRDF_POWER, &sample))
        return false;
    vec3 wo = frame_to_world(&frame, sample.wi);
    float in_s = fabsf(v3_dot(wi, frame.n)), in_g = fabsf(v3_dot(wi, s->ng)),
          out_s = fabsf(v3_dot(wo, frame.n)), out_g = fabsf(v3_dot(wo, s->ng));
    float adjoint = in_s * out_g / (in_g * out_s);
    rgb power = rgb_scale(rgb_mul(f->power, sample.weight), adjoint);
    float before = rgb_max(f->power), after = rgb_max(power);
    if (!(after > 0.0f) || !rgb_finite(power)) return false;
    float survival = fminf(after / before, 1.0f);
    if (rng_float(rng) >= survival) return false;
    if (!(sample.lobe & BRDF_DELTA))
        f->class = PHOTON_INDIRECT;
    else if (f->class == PHOTON_DIRECT)
        f->class = PHOTON_CAUSTIC;
    f->power = rgb_scale(power, 1.0f / survival);
    f->ray = scene_spawn(scene, s->p, s->ng, wo);
    return true;
}

static void walk(const struct photon_tracing *tracing, struct flight f, struct rng *rng,
                 struct chunk *chunk) {
    const struct satin_scene *scene = tracing->scene;
    unsigned lobes = tracing->guide ? BRDF_DELTA : BRDF_ALL;
    const int most = tracing->bounces < 0 ? BOUNCES_MAX : tracing->bounces;
    for (int bounce = 0; bounce <= most; bounce++) {
        struct surfel s;
        if (!scene_intersect(scene, &f.ray, &s)) return;
        vec3 wi = v3_neg(f.ray.d);
        if (tracing->keep >> f.class & 1u && keeps_photons(scene, &s, wi)) {
            if (!keep_hit(scene, chunk, &s, wi, f.power)) return;
            chunk->stored[f.class]++;
        }
        if (!scatter(scene, &s, lobes, rng, &f)) return;
    }
}

// ---- All paths --------------------------------------------------------------------------------

static uint64_t paths_of(const struct photon_tracing *tracing, uint32_t light) {
    if (tracing->guide) return photon_guide_paths(tracing->guide, light);
    const struct photon_deal *deal = tracing->deal;
    const float *cdf = tracing->scene->light_cdf;
    double share = (double)cdf[light + 1] - (double)cdf[light];
    if (deal && !deal->by_power) share = (double)deal->share[light];
    uint64_t n = (uint64_t)llround(share * (double)tracing->paths);
    return n > 0 ? n : 1;  // even the faintest light is represented
}

static uint32_t light_of(const uint64_t *first, uint32_t lights, uint64_t path) {
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

// Starts path `index` of a light; false if it carries no power.
static bool launch(const struct photon_tracing *tracing, uint32_t light, uint64_t index,
                   uint64_t paths, struct flight *f) {
    // The sequence has 2^32 points; the rest of the index is part of the seed.
    uint64_t key = rng_mix(tracing->seed + 0x9e3779b97f4a7c15ull * (2 * light + 1) +
                           (tracing->guide ? 0x632be59bd9b4e019ull : 0)) +
                   (index >> 32);
    float u[4], factor = 1.0f;
    sample_sobol4((uint32_t)index, (uint32_t)rng_mix(key), u);
    const struct light_aim *aim = NULL;
    if (tracing->guide) {
        factor = photon_guide_warp(tracing->guide, light, index, u);
        aim = photon_guide_aim(tracing->guide);
    }
    struct light_ray start;
    if (!light_emit(tracing->scene, light, aim, u, &start)) return false;
    *f = (struct flight){start.ray, rgb_scale(start.power, factor / (float)paths), PHOTON_DIRECT};
    return rgb_finite(f->power) && rgb_max(f->power) > 0.0f;
}

static void trace_chunk(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct run *run = ctx;
    const struct photon_tracing *tracing = run->tracing;
    uint32_t lights = tracing->scene->light_count;
    struct chunk *chunk = &run->chunk[begin / run->grain];
    if (atomic_load(&run->failed)) return;
    uint32_t light = light_of(run->first, lights, begin);
    for (uint64_t path = begin; path < end && !chunk->failed; path++) {
        while (path >= run->first[light + 1]) light++;
        struct rng rng = rng_make(tracing->seed, tracing->guide ? RNG_CAUSTIC : RNG_PHOTON, path);
        struct flight f;
        uint64_t paths = run->first[light + 1] - run->first[light];
        if (launch(tracing, light, path - run->first[light], paths, &f))
            walk(tracing, f, &rng, chunk);
    }
    // The kd-tree numbers photons by int.
    size_t count = atomic_fetch_add(&run->count, chunk->count) + chunk->count;
    if (chunk->failed || count > INT_MAX) atomic_store(&run->failed, true);
}

// Joins the chunks in their order and gives their memory back on the way.
static satin_status join(struct run *run, size_t chunks, struct photon_trace *out) {
    size_t count = 0;
    for (size_t i = 0; i < chunks; i++) count += run->chunk[i].count;
    struct photon_hit *hit = count ? malloc(count * sizeof *hit) : NULL;
    if (count && !hit) return SATIN_ERROR_MEMORY;
    struct photon_trace trace = {.hit = hit,
                                 .emitted = run->first[run->tracing->scene->light_count]};
    for (size_t i = 0; i < chunks; i++) {
        struct chunk *c = &run->chunk[i];
        if (c->count) memcpy(hit + trace.count, c->hit, c->count * sizeof *hit);
        trace.count += c->count;
        for (int k = 0; k < PHOTON_CLASSES; k++) trace.stored[k] += c->stored[k];
        free(c->hit);
        c->hit = NULL;
    }
    *out = trace;
    return SATIN_OK;
}

satin_status photon_trace_run(const struct photon_tracing *tracing, struct parallel *pool,
                              struct log log, struct photon_trace *out) {
    uint32_t lights = tracing->scene->light_count;
    if (lights == 0 || tracing->paths == 0) {
        *out = (struct photon_trace){0};
        return SATIN_OK;
    }
    struct run run = {.tracing = tracing, .first = malloc((lights + 1) * sizeof *run.first)};
    atomic_init(&run.failed, false);
    atomic_init(&run.count, 0);
    satin_status status = SATIN_ERROR_MEMORY;
    size_t chunks = 0;
    if (!run.first) goto done;
    run.first[0] = 0;
    for (uint32_t i = 0; i < lights; i++) run.first[i + 1] = run.first[i] + paths_of(tracing, i);
    size_t paths = (size_t)run.first[lights];
    run.grain = paths / CHUNKS_MAX > CHUNK_PATHS ? paths / CHUNKS_MAX + 1 : CHUNK_PATHS;
    chunks = paths / run.grain + (paths % run.grain != 0);
    run.chunk = calloc(chunks, sizeof *run.chunk);
    if (!run.chunk) goto done;
    if (!parallel_for(pool, paths, run.grain, trace_chunk, &run))
        status = SATIN_CANCELLED;
    else if (!atomic_load(&run.failed))
        status = join(&run, chunks, out);
done:
    if (run.chunk)
        for (size_t i = 0; i < chunks; i++) free(run.chunk[i].hit);
    free(run.chunk);
    free(run.first);
    if (status == SATIN_ERROR_MEMORY)
        log_fail(log, status, "not enough memory for the photons; ask for fewer");
    return status;
}

void photon_trace_free(struct photon_trace *trace) {
    free(trace->hit);
    trace->hit = NULL;
    trace->count = 0;
}
