// SPDX-License-Identifier: Apache-2.0
// The noise of the first pass, apart from that of gathering: what single gather rays read differs
// from its mean. Two causes add up. Random decisions after the hit, as where the path continues and
// which light is sampled: two lookups of a ray with independent random numbers differ by them.
// And the noise of what is stored, photons or records, which is the same in both lookups: its
// variance is known from the photons and records themselves.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/stats.h"
#include "gather/gather_near.h"
#include "gather/gather_segment.h"

enum { LOOKUP_CHUNK = 64 };  // rays of a chunk
// Streams of the random decisions of both lookups, which no site of a record has.
static const uint64_t LOOKUP_STREAM[2] = {~0ull, ~1ull};

// What one ray reads.
struct noise_lookup {
    bool hit;        // whether it hits a surface, where something is read
    float L[2];      // luminance by either lookup
    float variance;  // of the stored light, of the luminance
    bool read;       // whether photons are read
};

struct noise_rays {
    const struct gather *g;
    const struct ray *ray;
    struct noise_lookup *lookup;
    struct gather_scratch **scratch;  // by worker
    double *cpu_s;                    // by worker
};

// The variance of the stored light that a ray reads. Sets whether that is of photons.
static float variance_of_stored(const struct gather *g, const struct ray *ray, uint32_t item,
                                bool *photons) {
    const satin_first_pass first = g->options->first_pass;
    struct sampler sampler = {item, (uint32_t)g->options->seed, 0};
    if (g->maps && (first == SATIN_FIRST_PHOTONS || photon_precomputes(g->options))) {
        struct gather_lookup read;
        *photons = gather_look_up(g, *ray, 0.0f, &sampler, &read);
        if (!*photons) return 0.0f;
        return photon_noise2(g->maps) * sqrf(rgb_luminance(read.L));
    }
    if (!g->next.gather) return 0.0f;
    const struct gather_segment_start start = {.ray = *ray, .depth = gather_hit_depth(g) - 1};
    struct gather_segment segment = {.first = GATHER_NOTHING};
    struct shading_point y;
    if (!gather_segment_trace(g, &start, &sampler, &segment, &y)) return 0.0f;
    return sqrf(rgb_luminance(segment.T)) * cache_reflected_variance(g->next.reader, &y);
}

static void look_up_rays(void *ctx, size_t begin, size_t end, int worker) {
    const struct noise_rays *r = ctx;
    const size_t count = end - begin;
    const double start = stats_thread();
    for (int k = 0; k < 2; k++) {
        struct gather_ray rays[LOOKUP_CHUNK];
        for (size_t i = 0; i < count; i++)
            rays[i] = (struct gather_ray){.ray = r->ray[begin + i], .item = (uint32_t)(begin + i)};
        gather_rays(r->g, r->scratch[worker], rays, count, LOOKUP_STREAM[k]);
        for (size_t i = 0; i < count; i++) {
            r->lookup[begin + i].L[k] = rgb_luminance(rays[i].L);
            r->lookup[begin + i].hit = isfinite(rays[i].first.r);
        }
    }
    r->cpu_s[worker] += stats_thread() - start;
    for (size_t i = begin; i < end; i++)
        r->lookup[i].variance =
            variance_of_stored(r->g, &r->ray[i], (uint32_t)i, &r->lookup[i].read);
}

// Sums in the order of the rays, so that they do not depend on the threads. Lookups that are not
// finite are dropped, as they are everywhere.
static struct gather_noise sum_lookups(const struct noise_lookup *lookup, size_t count) {
    double sum = 0.0, sampled = 0.0, stored = 0.0;
    struct gather_noise noise = {0};
    for (size_t i = 0; i < count; i++) {
        const double a = (double)lookup[i].L[0], b = (double)lookup[i].L[1];
        if (!lookup[i].hit || !isfinite(a + b + (double)lookup[i].variance)) continue;
        sum += 0.5 * (a + b);
        sampled += 0.5 * (a - b) * (a - b);
        stored += (double)lookup[i].variance;
        noise.read += lookup[i].read;
        noise.lookups++;
    }
    if (!(sum > 0.0)) return (struct gather_noise){0};
    const double scale = sqrt((double)noise.lookups) / sum;
    noise.sampled = scale * sqrt(sampled);
    noise.stored = scale * sqrt(stored);
    noise.read /= (double)noise.lookups;
    noise.error = hypot(noise.sampled, noise.stored);
    return noise;
}

satin_status gather_noise_measure(const struct gather *g, const struct ray *ray, size_t count,
                                  struct parallel *pool, struct gather_noise *out) {
    const int threads = parallel_threads(pool);
    struct noise_rays r = {g, ray, array_new(count, sizeof *r.lookup),
                           calloc((size_t)threads, sizeof *r.scratch),
                           calloc((size_t)threads, sizeof *r.cpu_s)};
    satin_status status = r.lookup && r.scratch && r.cpu_s ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (int i = 0; i < threads && status == SATIN_OK; i++) {
        r.scratch[i] = gather_scratch_new(NULL, 0);
        if (!r.scratch[i]) status = SATIN_ERROR_MEMORY;
    }
    if (status == SATIN_OK) {
        parallel_for_all(pool, count, LOOKUP_CHUNK, look_up_rays, &r);
        *out = sum_lookups(r.lookup, count);
        for (int i = 0; i < threads && count > 0; i++) out->cpu_s += r.cpu_s[i];
        out->cpu_s /= 2.0 * (double)(count > 0 ? count : 1);
    }
    for (int i = 0; r.scratch && i < threads; i++) gather_scratch_free(r.scratch[i]);
    free(r.lookup);
    free(r.scratch);
    free(r.cpu_s);
    return status;
}
