// SPDX-License-Identifier: Apache-2.0
// The photon map. Photons are sorted along a Morton curve first, so that neighbours are neighbours
// in memory too, and every 8th of them is an even choice.
#include "photon/photon_map.h"

#include <stdlib.h>

#include "base/array.h"

// ---- Morton order -----------------------------------------------------------------------------

struct keyed {
    uint32_t key, item;
};

static uint32_t spread_bits(uint32_t x) {  // 10 bits to every third of 30
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

static uint32_t morton_key(vec3 p, vec3 lo, float scale) {
    vec3 q = v3_mul(v3_sub(p, lo), scale);
    return spread_bits((uint32_t)clampf(q.x, 0.0f, 1023.0f)) |
           spread_bits((uint32_t)clampf(q.y, 0.0f, 1023.0f)) << 1 |
           spread_bits((uint32_t)clampf(q.z, 0.0f, 1023.0f)) << 2;
}

// Stable radix sort by key, 10 bits at a time; an even or odd number of passes ends in `a` or `b`.
static struct keyed *sort_keyed(struct keyed *a, struct keyed *b, size_t n) {
    for (int shift = 0; shift < 30; shift += 10) {
        size_t start[1025] = {0};
        for (size_t i = 0; i < n; i++) start[(a[i].key >> shift & 1023u) + 1]++;
        for (int d = 0; d < 1024; d++) start[d + 1] += start[d];
        for (size_t i = 0; i < n; i++) b[start[a[i].key >> shift & 1023u]++] = a[i];
        struct keyed *swap = a;
        a = b;
        b = swap;
    }
    return a;
}

// ---- The map ----------------------------------------------------------------------------------

static void fill_photons(struct photon_map *map, const struct photon_hit *hit,
                         const struct keyed *order) {
    for (size_t i = 0; i < map->count; i++) {
        const struct photon_hit *h = &hit[order[i].item];
        float *p = map->position + 3 * i;
        p[0] = h->p.x;
        p[1] = h->p.y;
        p[2] = h->p.z;
        map->photon[i] = (struct photon){h->power, h->wi, h->n};
    }
}

satin_status photon_map_build(const struct satin_scene *scene, const struct photon_hit *hit,
                              size_t count, struct log log, struct photon_map *out) {
    struct photon_map map = {.count = count, .radius_max = 0.1f * scene->radius};
    if (count == 0) {
        *out = map;
        return SATIN_OK;
    }
    struct keyed *key = array_new(2 * count, sizeof *key);
    map.position = array_new(3 * count, sizeof *map.position);
    map.photon = array_new(count, sizeof *map.photon);
    if (key && map.position && map.photon) {
        float scale = 512.0f / scene->radius;
        for (size_t i = 0; i < count; i++)
            key[i] = (struct keyed){morton_key(hit[i].p, scene->bounds_lo, scale), (uint32_t)i};
        fill_photons(&map, hit, sort_keyed(key, key + count, count));
        map.index = photon_index_new(map.position, count, 3);
    }
    free(key);
    if (!map.index) {
        photon_map_free(&map);
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the photon map");
    }
    *out = map;
    return SATIN_OK;
}

void photon_map_free(struct photon_map *map) {
    photon_index_free(map->index);
    free(map->position);
    free(map->photon);
    free(map->open);
    *map = (struct photon_map){0};
}

size_t photon_map_bytes(const struct photon_map *map) {
    size_t bytes = map->count * (3 * sizeof *map->position + sizeof *map->photon);
    return bytes + (map->open ? map->count / map->stride : 0) + photon_index_bytes(map->index);
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
