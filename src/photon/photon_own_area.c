// SPDX-License-Identifier: Apache-2.0
// The area of the surface in the own disc of each photon (photon_radii.c), measured once when the
// map is built. A photon's power divided by this area, on the part of its disc that walls and edges
// leave, is all of its power, wherever the estimates are made that count it: an estimate needs no
// rays. Before, each estimate measured the area of its own disc by 33 or more rays, which took a
// fifth of the time of a render where caustics are most of the light
// (docs/experiments/gather-time.md).
#include "photon/photon_own_area.h"

#include <math.h>
#include <stdlib.h>

#include "base/array.h"

enum { OWN_CHUNK = 256 };            // photons of a chunk
#define EXTENT_STEP (1.5f / 255.0f)  // the largest extent is 1.5 radii
// In the narrowest cracks the area is nearly 0, and a single photon would be very bright.
#define FRACTION_LEAST 0.02f

struct own_loop {
    struct photon_map *map;
    const struct satin_scene *scene;
    enum photon_kernel kernel;
    bool measure;
    struct photon_own_area *own;
    float *clear;
};

static vec3 own_normal(const struct photon_map *map, size_t i) {
    return photon_unpack(map->photon[i].n);
}

static struct photon_clearing own_clearing(const struct own_loop *loop, size_t i) {
    const struct photon_map *map = loop->map;
    const float radius = loop->measure ? sqrtf(map->radius2[i]) : 0.0f;
    return photon_clearing_find(loop->scene, photon_position(map, i), own_normal(map, i), radius);
}

// Rounds the extents of an area to what is stored.
static void store_extents(struct photon_area *area, uint8_t extent[AREA_SECTORS]) {
    for (int i = 0; i < AREA_SECTORS; i++) {
        const float steps = roundf(1.0f / (area->inverse[i] * EXTENT_STEP));
        extent[i] = (uint8_t)clampf(steps, 1.0f, 255.0f);
        area->inverse[i] = 1.0f / ((float)extent[i] * EXTENT_STEP);
    }
}

static void find_area(const struct own_loop *loop, size_t i,
                      const struct photon_clearing *clearing) {
    struct photon_map *map = loop->map;
    struct photon_own_area *own = &loop->own[i];
    const vec3 p = photon_position(map, i), n = own_normal(map, i);
    const float r2 = map->radius2[i], r = sqrtf(r2);
    *own = (struct photon_own_area){.scale = 1.0f / (PI_F * r2), .clear2 = r2};
    loop->clear[i] = r;
    map->whole_disc[i] = true;
    if (!loop->measure || !(r > 0.0f) || photon_clearing_has(clearing, p, n, r)) return;
    struct photon_area area;
    photon_area_make(loop->scene, p, n, r, AREA_POINTS, &area);
    if (area.whole_disc) return;
    map->whole_disc[i] = false;
    store_extents(&area, own->extent);
    own->scale /= fmaxf(photon_area_fraction(&area, loop->kernel), FRACTION_LEAST);
    loop->clear[i] = r / photon_area_inverse(&area);
    own->clear2 = sqrf(loop->clear[i]);
}

static void find_areas(void *ctx, size_t begin, size_t end, int worker) {
    const struct own_loop *loop = ctx;
    (void)worker;
    for (size_t at = begin; at < end; at += PHOTON_CLEARING_DISCS) {
        const size_t n = end - at < PHOTON_CLEARING_DISCS ? end - at : PHOTON_CLEARING_DISCS;
        const struct photon_clearing clearing = own_clearing(loop, at + n / 2);
        for (size_t i = at; i < at + n; i++) find_area(loop, i, &clearing);
    }
}

satin_status photon_own_areas_find(struct photon_map *map, const struct satin_scene *scene,
                                   enum photon_kernel kernel, bool measure, struct parallel *pool,
                                   float *clear) {
    struct own_loop loop = {map, scene, kernel, measure, NULL, clear};
    loop.own = array_new_unset(map->count, sizeof *loop.own);
    if (!loop.own) return SATIN_ERROR_MEMORY;
    const struct parallel_results areas = {.slot = {{loop.own, sizeof *loop.own},
                                                    {map->whole_disc, sizeof *map->whole_disc},
                                                    {clear, sizeof *clear}},
                                           .journaled = true};
    if (!parallel_for_results(pool, map->count, OWN_CHUNK, find_areas, &loop, &areas)) {
        free(loop.own);
        return SATIN_CANCELLED;
    }
    map->own = loop.own;
    return SATIN_OK;
}

// Whether p is on the part of photon i's disc that walls and edges leave.
static bool is_in_own_area(const struct photon_map *map, size_t i, vec3 n, vec3 p) {
    const uint8_t *extent = map->own[i].extent;
    const vec3 at = photon_position(map, i), d = v3_sub(p, at);
    const struct frame frame = frame_from_normal(n);
    const float x = v3_dot(d, frame.u), y = v3_dot(d, frame.v);
    const float sector = photon_area_sector(x, y, photon_area_rotation(at));
    const int k = (int)sector;
    // Between sectors the inverse of the extent is linear, as along a straight wall.
    const float a = (float)extent[k % AREA_SECTORS], b = (float)extent[(k + 1) % AREA_SECTORS];
    const float inverse = lerpf(1.0f / a, 1.0f / b, sector - (float)k) / EXTENT_STEP;
    return (x * x + y * y) * sqrf(inverse) <= map->radius2[i];
}

float photon_own_weight(const struct photon_map *map, size_t i, vec3 n, vec3 p, float d2,
                        enum photon_kernel kernel) {
    const struct photon_own_area *own = &map->own[i];
    if (d2 > own->clear2 && !is_in_own_area(map, i, n, p)) return 0.0f;
    return own->scale * photon_kernel_weight(kernel, d2 / map->radius2[i]);
}
