// SPDX-License-Identifier: Apache-2.0
// Leaks: a record behind a thin wall, or one whose rays have slipped through a gap, must not serve
// what it does not see. Each record remembers the directions along its plane in which something
// stands within its reach, as the ambient cache of Radiance does; there a ray decides.
#include "cache/cache_records.h"

// The ray runs so much of its length above both ends, so that it passes over the roundness of one
// surface.
static const float LIFT = 0.1f;

// Of the least distance that rays have found; they may have missed something nearer.
static const float CLEAR = 0.8f;

uint32_t cache_leak_walls(const struct gather_around *around, float reach, float *clear) {
    uint32_t walls = 0;
    *clear = reach;
    for (int s = 0; s < GATHER_SECTORS; s++)
        if (around->sector[s] < reach) {
            walls |= 1u << s;
            *clear = fminf(*clear, CLEAR * around->sector[s]);
        }
    return walls;
}

// The sector of the direction d about n.
static int sector_of(const struct cache_head *h, vec3 d) {
    float x = v3_dot(d, h->u), y = v3_dot(d, v3_cross(h->n, h->u));
    float turn = atan2f(y, x) * (0.5f / PI_F);
    int s = (int)floorf((turn < 0.0f ? turn + 1.0f : turn) * GATHER_SECTORS);
    return s < GATHER_SECTORS ? s : 0;
}

bool cache_leaks(const struct cache *cache, const struct cache_head *h, vec3 p) {
    if (!h->walls || !cache->g->options->leak_test) return false;
    vec3 d = v3_sub(p, h->p);
    float length = v3_len(d);
    if (!(length > h->clear) || !(h->walls >> sector_of(h, d) & 1u)) return false;
    vec3 lift = v3_mul(h->n, LIFT * length), from = v3_add(h->p, lift), to = v3_add(p, lift);
    struct ray ray = scene_spawn_to(cache->g->scene, from, h->n, to, v3(0, 0, 0));
    return scene_occluded(cache->g->scene, &ray);
}

int cache_find(const struct cache *cache, const struct cache_tree *tree, vec3 p, vec3 n, float a,
               struct cache_near near[CACHE_NEAR_MAX]) {
    int count = cache_tree_find(tree, p, n, a, near), seen = 0;
    for (int i = 0; i < count; i++)
        if (!cache_leaks(cache, &tree->head[near[i].record], p)) near[seen++] = near[i];
    return seen;
}
