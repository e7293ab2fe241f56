// SPDX-License-Identifier: Apache-2.0
// Finds the box of the visible-environment histograms. Windows are openings of a room's walls: if
// the faces of the box are near them, each is in the same bins from all points of the room. Rays
// from points of the cells measure that. Of a bin that n rays meet, of which m arrive at the
// environment, samples contribute the second moment (sum of sqrt(n m))^2, if bins are drawn by the
// densities that are best for all points together. The faces are moved one by one to where it is
// least. In the open, where no box helps, it is large, so that bins are directions.
#include <limits.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "guide/guide_visibility.h"

enum {
    SWEEPS = 2,  // times that each face is moved
    MERGED = 2,  // rows and columns of bins that are taken together, as rays are few
    // Fewer rays that arrive do not show where the faces should be, and the box stays around the
    // points. Of 3 to 174 rays through slits and holes, boxes moved by them were wrong: where one
    // ray of 33,000 found a hole of 10 cm, a room had .47 of its light (docs/experiments/
    // direct-light.md). In rooms with windows it is 520 to 1,000.
    ARRIVING_LEAST = 256,
    QUANTILES = 6,
    FARTHER = 4,
    BOX_OFFSETS = QUANTILES + FARTHER
};
// The offsets of a face: fractions of the points that are beyond it, and distances from all of
// them, as fractions of the largest extent.
static const float BOX_BEYOND[QUANTILES] = {0.0f, 0.005f, 0.02f, 0.05f, 0.1f, 0.2f};
static const float DISTANCE[FARTHER] = {0.03f, 0.1f, 1.0f, 10.0f};
// The least extent, as a fraction of the largest.
static const float EXTENT_LEAST = 0.01f;

struct traced_ray {
    vec3 p, d;
    bool arrives;
};

struct box_search {
    const struct satin_scene *scene;
    const struct guide_cells *cells;
    uint64_t seed;
    size_t points, rays;
    struct traced_ray *ray;
    struct light_box box[BOX_OFFSETS];
    double moment[BOX_OFFSETS];
};

static void trace_rays(void *ctx, size_t begin, size_t end, int worker) {
    struct box_search *search = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(search->seed, RNG_BOX, i);
        const struct guide_cell_point *p = &search->cells->point[i * search->points / search->rays];
        const struct frame frame = frame_from_normal(p->n);
        const float u = rng_float(&rng), v = rng_float(&rng);
        const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(u, v));
        struct light_sample s = {.wi = d, .dist = INFINITY, .L = rgb_grey(1.0f)};
        search->ray[i] =
            (struct traced_ray){p->p, d, light_arrives(search->scene, p->p, p->ng, INT_MAX, &s)};
    }
}

static bool enough_arrive(const struct box_search *search) {
    size_t arriving = 0;
    for (size_t i = 0; i < search->rays; i++) arriving += search->ray[i].arrives;
    return arriving >= ARRIVING_LEAST;
}

static void measure_boxes(void *ctx, size_t begin, size_t end, int worker) {
    enum {
        MERGED_SIDE = LIGHT_HISTOGRAM_SIDE / MERGED,
        MERGED_BINS = LIGHT_HISTOGRAM_ROWS / MERGED * MERGED_SIDE
    };
    struct box_search *search = ctx;
    (void)worker;
    for (size_t k = begin; k < end; k++) {
        uint32_t rays[MERGED_BINS] = {0}, arriving[MERGED_BINS] = {0};
        for (size_t i = 0; i < search->rays; i++) {
            const struct traced_ray *ray = &search->ray[i];
            float density;
            const int bin = light_box_bin(&search->box[k], ray->p, ray->d, &density);
            const int row = bin / LIGHT_HISTOGRAM_SIDE, column = bin % LIGHT_HISTOGRAM_SIDE;
            const int at = row / MERGED * MERGED_SIDE + column / MERGED;
            rays[at]++;
            arriving[at] += ray->arrives;
        }
        search->moment[k] = 0.0;
        for (int i = 0; i < MERGED_BINS; i++)
            search->moment[k] += sqrt((double)rays[i] * (double)arriving[i]);
    }
}

// The offsets of the face at the end of an axis, beginning with one around all points.
static void find_offsets(const float *sorted, size_t points, bool upper, float extent,
                         float offset[BOX_OFFSETS]) {
    for (int i = 0; i < QUANTILES; i++) {
        const size_t beyond = (size_t)(BOX_BEYOND[i] * (float)points);
        offset[i] = sorted[upper ? points - 1 - beyond : beyond];
    }
    for (int i = 0; i < FARTHER; i++)
        offset[QUANTILES + i] = offset[0] + (upper ? extent : -extent) * DISTANCE[i];
}

struct box_faces {
    float offset[6][BOX_OFFSETS];
    int chosen[6];
};

static vec3 corner(const struct box_faces *faces, int upper, int moved, int offset) {
    float at[3];
    for (int axis = 0; axis < 3; axis++) {
        const int face = 2 * axis + upper;
        at[axis] = faces->offset[face][face == moved ? offset : faces->chosen[face]];
    }
    return v3(at[0], at[1], at[2]);
}

// The box with one of its faces moved to another offset.
static struct light_box moved_box(const struct box_faces *faces, int face, int offset,
                                  float extent) {
    const vec3 lo = corner(faces, 0, face, offset), hi = corner(faces, 1, face, offset);
    const float least = EXTENT_LEAST * extent;
    return light_box_make(lo, v3_max(hi, v3_add(lo, v3(least, least, least))));
}

// Finds the offsets of all faces, around the points of the cells. Returns the largest extent.
static float begin_faces(const struct guide_cells *cells, size_t points, float *sorted,
                         float scene_radius, struct box_faces *faces) {
    vec3 lo = cells->point[0].p, hi = lo;
    for (size_t i = 0; i < points; i++) {
        lo = v3_min(lo, cells->point[i].p);
        hi = v3_max(hi, cells->point[i].p);
    }
    const float widest = v3_max_abs(v3_sub(hi, lo)), extent = widest > 0.0f ? widest : scene_radius;
    *faces = (struct box_faces){0};
    for (int axis = 0; axis < 3; axis++) {
        for (size_t i = 0; i < points; i++) sorted[i] = v3_along(cells->point[i].p, axis);
        qsort(sorted, points, sizeof *sorted, array_compare_floats);
        find_offsets(sorted, points, false, extent, faces->offset[2 * axis]);
        find_offsets(sorted, points, true, extent, faces->offset[2 * axis + 1]);
    }
    return extent;
}

bool guide_box_find(const struct satin_scene *scene, uint64_t seed, const struct guide_cells *cells,
                    size_t rays, struct parallel *pool, struct light_box *out) {
    struct box_search search = {.scene = scene, .cells = cells, .seed = seed, .rays = rays};
    for (size_t i = 0; i < guide_cells_count(cells); i++) search.points += cells->cell[i].count;
    float *sorted = array_new(search.points, sizeof *sorted);
    search.ray = array_new(search.rays, sizeof *search.ray);
    bool done = sorted && search.ray && parallel_for(pool, search.rays, 64, trace_rays, &search);
    if (done) {
        struct box_faces faces;
        const float extent = begin_faces(cells, search.points, sorted, scene->radius, &faces);
        const int moves = enough_arrive(&search) ? 6 * SWEEPS : 0;
        for (int k = 0; k < moves && done; k++) {
            const int face = k % 6;
            for (int i = 0; i < BOX_OFFSETS; i++)
                search.box[i] = moved_box(&faces, face, i, extent);
            done = parallel_for(pool, BOX_OFFSETS, 1, measure_boxes, &search);
            for (int i = 0; i < BOX_OFFSETS; i++)
                if (search.moment[i] < search.moment[faces.chosen[face]]) faces.chosen[face] = i;
        }
        *out = moved_box(&faces, 0, faces.chosen[0], extent);
    }
    free(search.ray);
    free(sorted);
    return done;
}
