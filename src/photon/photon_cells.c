// SPDX-License-Identifier: Apache-2.0
// Cells of places that matter: points on paths from the eye, and on their bounces, parted by a tree
// into cells of about equal numbers. What is learned in a cell serves all points that fall into it.
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "photon/photon_seen.h"

enum {
    PATHS = 4 * PHOTON_VIEW_PATHS,
    BOUNCES = 2,  // of a path: gather rays sample direct light behind the first one
    POINTS = PATHS * (1 + BOUNCES),
    LEAST = 8,  // points of a cell, in the mean
    NEAR = 16   // the middle is so many parts of all to either side
};

static size_t add_path(const struct satin_scene *scene, uint64_t seed, uint32_t i,
                       struct photon_cell_point *out) {
    struct rng rng = rng_make(seed, RNG_CELL, i);
    struct surfel s;
    vec3 n;
    size_t count = 0;
    bool found = photon_view_eye(scene, i, &rng, &s, &n);
    while (found) {
        bool through = material_transmits(&scene->material[s.material], s.light >= 0);
        out[count] = (struct photon_cell_point){
            s.p, s.ng, n, through, 0.0f, (uint32_t)(i * (1 + BOUNCES) + count)};
        if (count++ == BOUNCES) break;
        const struct frame frame = frame_from_normal(n);
        const float u = rng_float(&rng), v = rng_float(&rng);
        struct ray ray =
            scene_spawn(scene, s.p, s.ng, frame_to_world(&frame, sample_cosine_hemisphere(u, v)));
        found = photon_view_follow(scene, &ray, &rng, &s, &n);
    }
    return count;
}

static int by_key(const void *a, const void *b) {
    const struct photon_cell_point *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

static int longest_axis(const struct photon_cell_point *point, size_t count) {
    vec3 lo = point[0].p, hi = lo;
    for (size_t i = 1; i < count; i++) {
        lo = v3_min(lo, point[i].p);
        hi = v3_max(hi, point[i].p);
    }
    const vec3 d = v3_sub(hi, lo);
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

// Where to cut sorted points: in the widest gap near their middle, so that rounding does not part
// those of a wall; if all there lie on one, in the widest of all.
static size_t gap(const struct photon_cell_point *point, size_t count) {
    const size_t middle = count / 2, near = count / NEAR;
    size_t first = middle - near > 1 ? middle - near : 1, last = middle + near, best = middle;
    float widest = 0.0f;
    for (int pass = 0; pass < 2 && !(widest > 0.0f); pass++) {
        for (size_t i = first; i <= last; i++) {
            const float width = point[i].key - point[i - 1].key;
            if (!(width > widest)) continue;
            widest = width;
            best = i;
        }
        first = 1;
        last = count - 1;
    }
    return best;
}

// Parts the points of a node into two, down to its cells.
static void cut(struct photon_cells *cells, struct photon_cell_point *point, size_t count,
                size_t node, int level) {
    if (level == cells->depth) {
        cells->cell[node + 1 - photon_cells_count(cells)] = (struct photon_cell){point, count};
        return;
    }
    if (count < 2) {  // a point of its own serves both sides
        cut(cells, point, count, 2 * node + 1, level + 1);
        cut(cells, point, count, 2 * node + 2, level + 1);
        return;
    }
    const int axis = longest_axis(point, count);
    for (size_t i = 0; i < count; i++) point[i].key = v3_along(point[i].p, axis);
    qsort(point, count, sizeof *point, by_key);
    const size_t left = gap(point, count);
    cells->split[node].axis = axis;
    cells->split[node].at = 0.5f * (point[left - 1].key + point[left].key);
    cut(cells, point, left, 2 * node + 1, level + 1);
    cut(cells, point + left, count - left, 2 * node + 2, level + 1);
}

bool photon_cells_make(const struct satin_scene *scene, uint64_t seed, struct photon_cells *out) {
    out->point = array_new(POINTS, sizeof *out->point);
    if (!out->point) return false;
    size_t count = 0;
    for (uint32_t i = 0; i < PATHS; i++) count += add_path(scene, seed, i, out->point + count);
    out->depth = 0;
    while (out->depth < PHOTON_CELLS_DEPTH && count >> (out->depth + 1) >= LEAST) out->depth++;
    if (count > 0) cut(out, out->point, count, 0, 0);
    return true;
}

size_t photon_cells_find(const struct photon_cells *cells, vec3 p) {
    size_t node = 0;
    for (int level = 0; level < cells->depth; level++)
        node = 2 * node + (v3_along(p, cells->split[node].axis) < cells->split[node].at ? 1 : 2);
    return node + 1 - photon_cells_count(cells);
}
