// SPDX-License-Identifier: Apache-2.0
// Light leaks: a record behind a thin wall, or one whose rays have slipped through a gap, must not
// be used at a point from which its surroundings are not visible. Each record stores the sectors of
// its tangent plane in which there are surfaces within its search radius, as the ambient cache
// of Radiance does; for points in such a sector a ray is traced. What is close to such a surface is
// lit or darkened by it in a way that the record cannot know: it gets a record of its own.
#include "cache/cache_records.h"

// The sector of the direction d about n.
static int sector_of(const struct cache_head *h, vec3 d) {
    float x = v3_dot(d, h->u), y = v3_dot(d, v3_cross(h->n, h->u));
    int s = (int)floorf(azimuth_fraction(y, x) * CACHE_SECTORS);
    return s < CACHE_SECTORS ? s : 0;
}

bool cache_serves(const struct cache_head *h, vec3 p) {
    const vec3 d = v3_sub(p, h->p);
    const float length = v3_len(d);
    return !(length > h->clear) ||
           !(length > (float)h->sector[sector_of(h, d)] / UINT8_MAX * h->search_radius);
}

bool cache_leaks(const struct cache *cache, const struct cache_head *h, vec3 p) {
    if (!cache->options->leak_test) return false;
    vec3 d = v3_sub(p, h->p);
    float length = v3_len(d);
    if (!(length > h->clear)) return false;
    if (h->sector[sector_of(h, d)] == UINT8_MAX) return false;
    vec3 lift = v3_mul(h->n, SCENE_LIFT * length), from = v3_add(h->p, lift), to = v3_add(p, lift);
    struct ray ray = scene_spawn_to(cache->scene, from, h->n, to, v3(0, 0, 0));
    return scene_occluded(cache->scene, &ray);
}
