// SPDX-License-Identifier: Apache-2.0
// Cells of points on paths from the eye and on their bounces, split by a tree into cells of equal
// numbers of points. What is measured in a cell is used at all points in it.
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "guide/guide_cells.h"

enum {
    POINTS_PATH = 1 + GUIDE_CELL_BOUNCES,
    CELL_LEAST = 8  // mean number of points of a cell
};

static size_t add_path(const struct satin_scene *scene, uint64_t seed, uint32_t i, size_t bounces,
                       struct guide_cell_point *out) {
    struct rng rng = rng_make(seed, RNG_CELL, i);
    struct interaction s;
    vec3 n;
    size_t count = 0;
    bool found = guide_seen_eye(scene, i, &rng, &s, &n);
    while (found) {
        bool through = scene_material_transmits(&scene->material[s.material], s.light >= 0);
        out[count] = (struct guide_cell_point){s.p, s.ng, n, through};
        if (count++ == bounces) break;
        const struct frame frame = frame_from_normal(n);
        const float u = rng_float(&rng), v = rng_float(&rng);
        struct ray ray =
            scene_spawn(scene, s.p, s.ng, frame_to_world(&frame, sample_cosine_hemisphere(u, v)));
        struct light_chain chain;
        found = guide_seen_follow(scene, &ray, &rng, &s, &n, &chain);
    }
    return count;
}

struct cell_paths {
    const struct satin_scene *scene;
    uint64_t seed;
    size_t bounces;
    struct guide_cell_point *point;  // those of path i begin at POINTS_PATH i
    size_t *count;                   // number of points of each path
};

static void trace_cells(void *ctx, size_t begin, size_t end, int worker) {
    struct cell_paths *paths = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        paths->count[i] = add_path(paths->scene, paths->seed, (uint32_t)i, paths->bounces,
                                   paths->point + i * POINTS_PATH);
}

// Stores the points of all paths at the front of traced->point, in the order of the paths. Returns
// their number.
static size_t find_points(struct cell_paths *traced, size_t paths, struct parallel *pool) {
    size_t points = 0;
    parallel_for_all(pool, paths, GUIDE_SEEN_CHUNK, trace_cells, traced);
    for (size_t i = 0; i < paths; i++)
        for (size_t k = 0; k < traced->count[i]; k++)
            traced->point[points++] = traced->point[i * POINTS_PATH + k];
    return points;
}

// Splits points [first, first + count) of a node down to its cells.
static void split_cells(struct guide_cells *cells, struct split_point *point, size_t first,
                        size_t count, size_t node, int depth) {
    if (depth == cells->depth) {
        cells->cell[node + 1 - guide_cells_count(cells)] =
            (struct guide_cell){cells->point + first, count};
        return;
    }
    const size_t left = count / 2;
    cells->split[node] = median_split(point + first, count);
    split_cells(cells, point, first, left, 2 * node + 1, depth + 1);
    split_cells(cells, point, first + left, count - left, 2 * node + 2, depth + 1);
}

bool guide_cells_make(const struct satin_scene *scene, uint64_t seed, int paths, int bounces,
                      struct parallel *pool, struct guide_cells *out) {
    const size_t points = (size_t)paths * POINTS_PATH;
    struct guide_cell_point *found = array_new(points, sizeof *found);
    struct split_point *point = array_new(points, sizeof *point);
    size_t *path_count = array_new((size_t)paths, sizeof *path_count);
    out->point = array_new(points, sizeof *out->point);
    const bool made = found && point && path_count && out->point;
    if (made) {
        struct cell_paths traced = {scene, seed, (size_t)bounces, found, path_count};
        const size_t count = find_points(&traced, (size_t)paths, pool);
        out->depth = 0;
        while (out->depth < GUIDE_CELLS_DEPTH && count >> (out->depth + 1) >= CELL_LEAST)
            out->depth++;
        for (size_t i = 0; i < count; i++)
            point[i] = (struct split_point){.p = found[i].p, .item = (uint32_t)i};
        if (count > 0) split_cells(out, point, 0, count, 0, 0);
        for (size_t i = 0; i < count; i++) out->point[i] = found[point[i].item];
    } else {
        free(out->point);
        out->point = NULL;
    }
    free(found);
    free(point);
    free(path_count);
    return made;
}

size_t guide_cells_find(const struct guide_cells *cells, vec3 p) {
    size_t node = 0;
    for (int depth = 0; depth < cells->depth; depth++) {
        const struct split_plane *border = &cells->split[node];
        node = 2 * node + (v3_dot(border->n, p) < border->at ? 1 : 2);
    }
    return node + 1 - guide_cells_count(cells);
}
