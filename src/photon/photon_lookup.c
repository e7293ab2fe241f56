// SPDX-License-Identifier: Apache-2.0
// Lookups of precomputed irradiance: which entry a point reads, and what of its light. An entry
// that faces away from the point or is hidden from it by a wall is replaced by another one near it,
// and light fades where no entry is as near as photons lie.
#include "photon/photon_map.h"

enum {
    IRRADIANCE_BATCH = PHOTON_VOXEL_LOOKUPS,  // lookups that are searched together
    // Entries that are searched if the nearest one has another orientation or is behind a wall.
    RETRIES = PHOTON_VOXEL_NEAR,
    RETRY_ENDS = 4  // number of those in caustics, where entries are mostly on other surfaces then
};
#define FACING 0.5f

static bool has_orientation(const struct photon_irradiance *r, int row, vec3 n) {
    const float *m = r->position.row + 6 * (size_t)row + 3;
    return m[0] * n.x + m[1] * n.y + m[2] * n.z >= FACING * r->position.scale;
}

// Makes the ray from p to position i, so high above the surface. False if they are equal.
static bool ray_above(const struct photon_positions *positions, size_t i, float lift,
                      const struct satin_scene *scene, vec3 p, vec3 n, struct ray *out) {
    const vec3 d = v3_sub(photon_entry_position(positions, i), p);
    const float distance = v3_len(d);
    if (!(distance > 0.0f)) return false;
    *out = scene_spawn(scene, p, n, n);
    out->o = v3_mad(out->o, lift, n);
    out->d = v3_mul(d, 1.0f / distance);
    out->tfar = distance;
    return true;
}

// Makes the ray from p to position i, a little above the surface, or where there is a step between
// them halfway up to the higher one. False if they are equal.
static bool ray_to_position(const struct photon_positions *positions, size_t i,
                            const struct satin_scene *scene, vec3 p, vec3 n, struct ray *out) {
    const vec3 position = photon_entry_position(positions, i);
    const float step = fabsf(photon_layer_step(p, n, position, photon_entry_normal(positions, i))),
                lift = SCENE_LIFT * sqrtf(v3_dist2(p, position));
    return ray_above(positions, i, fminf(lift, step > 0.0f ? 0.5f * step : INFINITY), scene, p, n,
                     out);
}

bool photon_irradiance_visible(const struct photon_irradiance *r, const struct satin_scene *scene,
                               int entry, vec3 p, vec3 n) {
    struct ray ray;
    return !(ray_to_position(&r->position, (size_t)entry, scene, p, n, &ray) &&
             scene_occluded(scene, &ray));
}

// Whether p is on the surface around entry i that no wall and no edge cuts: as near as that, and
// not on another surface above or beneath it, such as a floor over the ground outside.
static bool is_on_clear_surface(const struct photon_positions *positions, size_t i, vec3 p,
                                vec3 n) {
    const vec3 position = photon_entry_position(positions, i),
               m = photon_entry_normal(positions, i);
    const float clear = positions->clear[i], d2 = v3_dist2(position, p),
                height = v3_dot(v3_sub(p, position), m);
    return d2 <= clear * clear && height * height <= sqrf(SCENE_LIFT) * d2 &&
           photon_layer_step(p, n, position, m) == 0.0f;
}

// Makes the ray from p to position i. False if nothing can be between them.
static bool ray_to_entry(const struct photon_positions *positions, const struct satin_scene *scene,
                         size_t i, vec3 p, vec3 n, struct ray *out) {
    return !is_on_clear_surface(positions, i, p, n) &&
           ray_to_position(positions, i, scene, p, n, out);
}

bool photon_entry_position_hidden(const struct photon_positions *positions,
                                  const struct satin_scene *scene, size_t i, vec3 p, vec3 n) {
    struct ray ray;
    return ray_to_entry(positions, scene, i, p, n, &ray) && scene_occluded(scene, &ray);
}

bool photon_irradiance_sparse(const struct photon_irradiance *r, int entry) {
    return r->ends && r->radius[entry] >= r->radius_max;
}

// Whether p is far from the row, in comparison with the spacing of photons there.
static bool is_far(const struct photon_irradiance *r, int row, vec3 p) {
    const float d2 = v3_dist2(p, photon_entry_position(&r->position, (size_t)row));
    if (photon_irradiance_sparse(r, row)) return d2 >= sqrf(r->radius_max);
    const float fade2 = r->fade2 * sqrf(r->radius[row]);
    return fade2 > 0.0f && d2 > PHOTON_ENDS * fade2;
}

// Finds a few entries near a point and their squared distances. Those of other orientations are
// removed: -1.
static void find_near(const struct photon_irradiance *r, vec3 p, vec3 n, int row[RETRIES],
                      float distance2[RETRIES]) {
    float query[6];
    photon_entry_row_set(query, p, n, r->position.scale);
    if (r->ends) {
        for (int i = RETRY_ENDS; i < RETRIES; i++) row[i] = -1;
        photon_index_nearest(r->index, query, 1, RETRY_ENDS, r->far2, row, distance2);
    } else {
        photon_voxel_find_near(r, p, n, row);
    }
    for (int i = 0; i < RETRIES; i++)
        if (row[i] >= 0) __builtin_prefetch(r->position.row + 6 * (size_t)row[i]);
    for (int i = 0; i < RETRIES; i++) {
        if (row[i] < 0) continue;
        const float *at = r->position.row + 6 * (size_t)row[i];
        distance2[i] = 0.0f;
        for (int k = 0; k < 6; k++) distance2[i] += sqrf(at[k] - query[k]);
        if (!has_orientation(r, row[i], n)) row[i] = -1;
    }
}

// The nearest of a few entries that has the orientation of n and is not behind a wall; -1 if there
// is none. If `scene` is NULL, walls are ignored. Nearer ones are tested first, so that few rays
// are traced.
static int search_facing(const struct photon_irradiance *r, vec3 p, vec3 n,
                         const struct satin_scene *scene) {
    int row[RETRIES];
    float distance2[RETRIES];
    find_near(r, p, n, row, distance2);
    for (;;) {
        int best = -1;
        for (int i = 0; i < RETRIES; i++)
            if (row[i] >= 0 && (best < 0 || distance2[i] < distance2[best])) best = i;
        if (best < 0) return -1;
        if (!scene || !photon_entry_position_hidden(&r->position, scene, (size_t)row[best], p, n))
            return row[best];
        row[best] = -1;
    }
}

// Finds the entries near `count` points, at most IRRADIANCE_BATCH: those of their voxels or, for
// light that ends, the nearest ones; -1: there is none.
static void look_up_entries(const struct photon_irradiance *r, const vec3 *p, const vec3 *n,
                            size_t count, int *entry) {
    if (r->voxels.scale) {
        photon_voxel_find(r, p, n, count, entry);
        return;
    }
    float query[6 * IRRADIANCE_BATCH], distance2[IRRADIANCE_BATCH];
    for (size_t i = 0; i < count; i++) {
        entry[i] = -1;
        photon_entry_row_set(query + 6 * i, p[i], n[i], r->position.scale);
    }
    if (r->count > 0) photon_index_nearest(r->index, query, count, 1, r->far2, entry, distance2);
}

int photon_irradiance_entry(const struct photon_irradiance *r, vec3 p, vec3 n) {
    int row;
    look_up_entries(r, &p, &n, 1, &row);
    if (row >= 0 && r->ends && is_far(r, row, p)) return -1;
    return row >= 0 && !has_orientation(r, row, n) ? search_facing(r, p, n, NULL) : row;
}

rgb photon_irradiance_value(const struct photon_irradiance *r, int entry, vec3 p) {
    if (entry < 0) return rgb_grey(0.0f);
    float d2 = v3_dist2(p, photon_entry_position(&r->position, (size_t)entry)),
          radius = r->radius[entry];
    float fade2 = r->fade2 * radius * radius;
    if (d2 <= fade2) return r->E[entry];
    const float far = d2 / fade2,
                left = r->ends ? fmaxf(PHOTON_ENDS - far, 0.0f) / (PHOTON_ENDS - 1.0f) : 1.0f;
    return rgb_scale(r->E[entry], left / far);
}

// The squared distance up to which strict lookups read an entry, over that at which it fades. Where
// light is even, one point in 67 is farther from all entries; beyond a border of light most are,
// and a faded entry of the bright side is brighter than they are. A dark room beside a bright one,
// with a slit of 1 cm beside its door, had 1.5 to 2.7 times its light if all entries were read, 1.0
// to 1.7 times up to a factor of 1, and .8 to 1.0 up to .5 (docs/experiments/first-passes.md).
static const float REACHED = 0.7f;

// Whether light arrives at p: p is as near to the row as the photons around that are, with the
// largest squared distance over that at which it fades.
static bool is_reached(const struct photon_irradiance *r, int row, vec3 p, float far) {
    const float d2 = v3_dist2(p, photon_entry_position(&r->position, (size_t)row));
    return d2 <= far * r->fade2 * sqrf(r->radius[row]);
}

// Whether something that ends above the surface, such as a door above a gap, is between
// p and the row, up to a height of their distance: light of the row's side is stopped there. A
// floor beside a partition that ends 1 cm above it had 8 to 16 times its light
// (docs/experiments/first-passes.md).
static bool is_cut_off(const struct photon_irradiance *r, const struct satin_scene *scene, int row,
                       vec3 p, vec3 n) {
    const float distance2 = v3_dist2(p, photon_entry_position(&r->position, (size_t)row));
    struct ray ray;
    return ray_above(&r->position, (size_t)row, sqrtf(distance2), scene, p, n, &ray) &&
           scene_occluded(scene, &ray);
}

// The width of what a lookup at p, of normal n, reads; INFINITY: nothing that may be read.
static float width_at(const struct photon_irradiance *r, const struct satin_scene *scene, int row,
                      vec3 p, vec3 n, bool strict) {
    if (row < 0 || r->ring[row] == INFINITY) return INFINITY;
    if (strict && (!is_reached(r, row, p, REACHED) || is_cut_off(r, scene, row, p, n)))
        return INFINITY;
    return r->ring[row];
}

// The fraction of an entry's light, by colour, whose photons may bounce once more for each of the
// segments.
static rgb fraction_within(const struct photon_irradiance *r, int row, int segments) {
    rgb fraction = rgb_grey(1.0f);
    if (!r->last || row < 0) return fraction;
    const rgb E = r->E[row], last = r->last[row];
    for (int i = 0; i < segments; i++)
        fraction = rgb_make(E.r > 0.0f ? fraction.r * fmaxf(1.0f - last.r / E.r, 0.0f) : 0.0f,
                            E.g > 0.0f ? fraction.g * fmaxf(1.0f - last.g / E.g, 0.0f) : 0.0f,
                            E.b > 0.0f ? fraction.b * fmaxf(1.0f - last.b / E.b, 0.0f) : 0.0f);
    return fraction;
}

// Lookups before the one of an entry that its data is fetched: these take as long as memory does.
enum { AHEAD = 8 };

static void prefetch_entry(const struct photon_irradiance *r, int row) {
    if (row < 0) return;
    __builtin_prefetch(r->position.row + 6 * (size_t)row);
    __builtin_prefetch(r->position.clear + row);
    __builtin_prefetch(r->E + row);
    __builtin_prefetch(r->radius + row);
    __builtin_prefetch(r->ring + row);
}

void photon_irradiance_many(const struct photon_maps *maps, const struct satin_scene *scene,
                            const struct photon_lookups *lookups) {
    const struct photon_irradiance *r = &maps->irradiance;
    const size_t count = lookups->count;
    const vec3 *p = lookups->p, *n = lookups->n;
    struct ray ray;
    int row[IRRADIANCE_BATCH];
    for (size_t at = 0; at < count; at += IRRADIANCE_BATCH) {
        size_t batch = count - at < IRRADIANCE_BATCH ? count - at : IRRADIANCE_BATCH;
        look_up_entries(r, p + at, n + at, batch, row);
        for (size_t i = 0; i < batch; i++) {
            size_t j = at + i;
            if (i + AHEAD < batch) prefetch_entry(r, row[i + AHEAD]);
            if (row[i] >= 0 &&
                (!has_orientation(r, row[i], n[j]) ||
                 (ray_to_entry(&r->position, scene, (size_t)row[i], p[j], n[j], &ray) &&
                  scene_occluded(scene, &ray))))
                // If that entry is far, continuing paths is faster than a longer search.
                row[i] = is_far(r, row[i], p[j]) ? -1 : search_facing(r, p[j], n[j], scene);
            lookups->E[j] =
                rgb_mul(photon_irradiance_value(r, row[i], p[j]),
                        lookups->segments ? fraction_within(r, row[i], lookups->segments[j])
                                          : rgb_grey(1.0f));
            lookups->radius[j] = width_at(r, scene, row[i], p[j], n[j], lookups->strict);
            if (lookups->entry)
                lookups->entry[j] = row[i] >= 0 && is_reached(r, row[i], p[j], 1.0f) ? row[i] : -1;
        }
    }
}

size_t photon_irradiance_count(const struct photon_maps *maps) { return maps->irradiance.count; }

void photon_irradiance_position(const struct photon_maps *maps, size_t entry, vec3 *p, vec3 *n) {
    const struct photon_positions *at = &maps->irradiance.position;
    *p = photon_entry_position(at, entry);
    *n = v3_unit(photon_entry_normal(at, entry));
}

rgb photon_irradiance_of_entry(const struct photon_maps *maps, size_t entry) {
    return maps->irradiance.E[entry];
}

float photon_irradiance_area(const struct photon_maps *maps, size_t entry) {
    return photon_irradiance_entry_area(&maps->irradiance, entry);
}

void photon_irradiance_around(const struct photon_maps *maps, size_t entry,
                              int around[PHOTON_AROUND]) {
    const struct photon_irradiance *r = &maps->irradiance;
    float distance2[PHOTON_AROUND];
    photon_index_nearest(r->index, r->position.row + 6 * entry, 1, PHOTON_AROUND, r->far2, around,
                         distance2);
}

rgb photon_irradiance_at(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p,
                         vec3 n, float *radius, int *entry) {
    rgb E;
    const struct photon_lookups one = {1, &p, &n, NULL, &E, radius, entry, false};
    photon_irradiance_many(maps, scene, &one);
    return E;
}
