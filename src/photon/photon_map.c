// SPDX-License-Identifier: Apache-2.0
// The photon map. Photons are sorted in Morton order, so that neighbours are neighbours in
// memory too, and every 8th of them is a uniform selection.
#include "photon/photon_cover.h"

#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_own_area.h"

enum { MAP_CHUNK = 4096 };  // photons per chunk

struct map_building {
    struct photon_map *map;
    const struct photon_hit *hit;
    struct photon_morton morton;
    struct photon_keyed *key;
};

static void find_keys(void *ctx, size_t begin, size_t end, int worker) {
    const struct map_building *b = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        b->key[i] = (struct photon_keyed){photon_morton_key(&b->morton, b->hit[i].p), (uint32_t)i};
}

static void copy_photons(void *ctx, size_t begin, size_t end, int worker) {
    const struct map_building *b = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct photon_hit *h = &b->hit[b->key[i].item];
        float *p = b->map->position + 3 * i;
        p[0] = h->p.x;
        p[1] = h->p.y;
        p[2] = h->p.z;
        b->map->photon[i] = (struct photon){h->power,    h->wi,   h->n,    h->bounces, h->last,
                                            h->indirect, h->path, h->tilt, h->copies};
    }
}

// Copies the hits to the map's arrays in Morton order. False if there is no memory or the pool was
// cancelled.
static bool sort_photons(struct map_building *b, struct parallel *pool) {
    const size_t count = b->map->count;
    struct photon_keyed *key = array_new_unset(2 * count, sizeof *key);
    b->key = key;
    bool sorted = key && parallel_for(pool, count, MAP_CHUNK, find_keys, b);
    if (sorted) b->key = photon_morton_sort(key, key + count, count, pool);
    sorted = sorted && b->key && parallel_for(pool, count, MAP_CHUNK, copy_photons, b);
    free(key);
    return sorted;
}

satin_status photon_map_build(const struct satin_scene *scene, const struct photon_hit *hit,
                              size_t count, struct parallel *pool, struct log log,
                              struct photon_map *out) {
    struct photon_map map = {.count = count,
                             .radius_max = 0.1f * scene->radius,
                             .morton = {scene->bounds_lo, 512.0f / scene->radius}};
    if (count == 0) {
        *out = map;
        return SATIN_OK;
    }
    map.position = array_new_unset(3 * count, sizeof *map.position);
    map.photon = array_new_unset(count, sizeof *map.photon);
    struct map_building b = {.map = &map, .hit = hit, .morton = map.morton};
    if (map.position && map.photon && sort_photons(&b, pool)) {
        parallel_begin_part(pool, "index");
        map.index = photon_index_new(map.position, count, 3, &map.morton, pool);
    }
    if (!map.index) {
        photon_map_free(&map);
        if (parallel_stopped(pool)) return SATIN_CANCELLED;
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the photon map");
    }
    *out = map;
    return SATIN_OK;
}

satin_status photon_map_trace(const struct photon_tracing *tracing, struct parallel *pool,
                              struct log log, struct stats *stats, struct photon_map *map,
                              struct photon_trace trace[PHOTON_CONSUMERS]) {
    const double start = stats_wall();
    parallel_begin_part(pool, "trace");
    satin_status status = photon_trace_run(tracing, pool, log, trace);
    if (status != SATIN_OK) return status;
    const double traced = stats_wall();
    parallel_begin_part(pool, "sort");
    status = photon_map_build(tracing->scene, trace->hit, trace->count, pool, log, map);
    photon_trace_count(trace, stats);
    stats_add(stats, "photons.trace_s", traced - start);
    stats_add(stats, "photons.build_s", stats_wall() - traced);
    photon_trace_free(trace);
    return status;
}

void photon_map_free(struct photon_map *map) {
    photon_index_free(map->index);
    free(map->position);
    free(map->photon);
    free(map->whole_disc);
    free(map->radius2);
    free(map->own);
    free(map->cover);
    *map = (struct photon_map){0};
}

size_t photon_map_bytes(const struct photon_map *map) {
    size_t bytes = map->count * (3 * sizeof *map->position + sizeof *map->photon);
    if (map->radius2) bytes += map->count * sizeof *map->radius2;
    if (map->own) bytes += map->count * sizeof *map->own;
    return bytes + (map->whole_disc ? map->count / map->stride : 0) +
           photon_index_bytes(map->index) + photon_cover_bytes(map);
}

// ---- Packed directions ------------------------------------------------------------------------

uint32_t photon_pack(vec3 w) {
    float s = 1.0f / (fabsf(w.x) + fabsf(w.y) + fabsf(w.z));
    float x = w.x * s, y = w.y * s;
    if (w.z < 0.0f) {
        float fold = (1.0f - fabsf(y)) * copysignf(1.0f, x);
        y = (1.0f - fabsf(x)) * copysignf(1.0f, y);
        x = fold;
    }
    int32_t a = (int32_t)lrintf(clampf(x, -1.0f, 1.0f) * 32767.0f),
            b = (int32_t)lrintf(clampf(y, -1.0f, 1.0f) * 32767.0f);
    return (uint32_t)(a & 0xffff) | (uint32_t)b << 16;
}

// Steps of the logarithm per octave; -128 is 0.
#define TILT_STEPS 42.0f

int8_t photon_pack_tilt(float factor) {
    if (!(factor > 0.0615f)) return INT8_MIN;
    const float octaves = log2f(minf(factor, PHOTON_TILT_MOST));
    return (int8_t)lrintf(maxf(TILT_STEPS * octaves, -127.0f));
}

float photon_unpack_tilt(int8_t packed) {
    if (packed == 0) return 1.0f;
    return packed == INT8_MIN ? 0.0f : exp2f((float)packed / TILT_STEPS);
}

vec3 photon_unpack(uint32_t packed) {
    float x = (float)(int16_t)(packed & 0xffffu) * (1.0f / 32767.0f),
          y = (float)(int16_t)(packed >> 16) * (1.0f / 32767.0f);
    float z = 1.0f - fabsf(x) - fabsf(y);
    if (z < 0.0f) {
        float fold = (1.0f - fabsf(y)) * copysignf(1.0f, x);
        y = (1.0f - fabsf(x)) * copysignf(1.0f, y);
        x = fold;
    }
    return v3_unit(v3(x, y, z));
}
