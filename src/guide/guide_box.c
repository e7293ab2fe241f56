// SPDX-License-Identifier: Apache-2.0
// Finds the box of the visible-environment histograms. Windows are openings of a room's walls: if
// the faces of the box are near them, each is in the same bins from all points of the room, and so
// it is for the box around the points. But points on the ground that the room's windows show make
// that as large as the ground, with bins as large as windows. Rays from the points measure whether
// a smaller box is better. Of a bin that n rays from points in the box meet, of which m arrive at
// the environment, samples contribute the second moment (sum of sqrt(n m))^2, if bins are drawn by
// the densities that are best for all these points together. The points outside the box have one
// bin for all directions. The faces are moved one by one to where the moment is least.
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "guide/guide_visibility.h"

enum {
    SWEEPS = 2,  // times that each face is moved
    // Fewer rays that arrive do not show where the faces should be, and the box stays around the
    // points. Of 3 to 174 rays through slits and holes, boxes moved by them were wrong: where one
    // ray of 33,000 found a hole of 10 cm, a room had .47 of its light (docs/experiments/
    // direct-light.md). In rooms with windows it is 440 to 1,000 of 33,000. Until so many arrive,
    // more rays are traced, up to BOX_BATCHES times as many.
    ARRIVING_LEAST = 256,
    BOX_BATCHES = 4,
    BOX_OFFSETS = 6,
    BOX_FEW = 1  // the index of the offset of a face that few points are beyond
};
// The offsets of a face: fractions of the points that are beyond it.
static const float BOX_BEYOND[BOX_OFFSETS] = {0.0f, 0.005f, 0.02f, 0.05f, 0.1f, 0.2f};
// The largest moment of a box that is used, as a fraction of that of the box around all points. It
// is .26 to .52 in rooms with a window on the ground, whose images then have a tenth to a half of
// the variance, and .88 to 1.0 in others and in the open, where a smaller box gains nothing.
#define BOX_SMALLER 0.8f
// That of a box whose area is less than this fraction of the area of the other one: it gains
// photons, which start through its openings. It is .92 to .95 in a loggia high above a ground,
// which has .7 times the error then, and .96 to 1.0 in the open, where a smaller box leaves .95
// to 1.2 times the error. A room with a slit, the box of which is about as large, has fewer samples
// through that.
#define BOX_MUCH_SMALLER 0.96f
#define AREA_MUCH_SMALLER 0.25f
// The least extent, as a fraction of the largest of the box around all points. As a fraction of the
// largest of the box itself it is the fraction of rays that arrive, .01 to .03 in rooms and .5 in
// the open. Above a flat ground, in a box that is hardly higher, one bin has most of the sky. With
// .01, .1, .3 and 1 direct light of a house beneath a sky has .88, .61, .46 and .44 of the variance
// of samples by radiance alone, and .45 with the fraction that arrives.
static const float EXTENT_LEAST = 0.01f;

struct traced_ray {
    vec3 p, d;
    uint32_t cell;  // that of p
    bool arrives;
};

struct box_search {
    const struct satin_scene *scene;
    const struct guide_cells *cells;
    uint64_t seed;
    size_t points, batch, rays;  // numbers of points, of rays of a batch and of those traced so far
    struct traced_ray *ray;
    float *sorted;                       // coordinates of points
    float extent;                        // the largest of the box around all points
    float open;                          // fraction of the rays that arrive
    uint32_t arriving[GUIDE_CELLS_MAX];  // number of rays of each cell that arrive
    struct light_box box[BOX_OFFSETS];
    double moment[BOX_OFFSETS];
};

// ---- Rays ---------------------------------------------------------------------------------------

static void trace_rays(void *ctx, size_t begin, size_t end, int worker) {
    struct box_search *search = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(search->seed, RNG_BOX, search->rays + i);
        const struct guide_cell_point *p =
            &search->cells->point[i * search->points / search->batch];
        const struct frame frame = frame_from_normal(p->n);
        const float u = rng_float(&rng), v = rng_float(&rng);
        const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(u, v));
        struct light_sample s = {.wi = d, .dist = INFINITY, .L = rgb_grey(1.0f)};
        search->ray[search->rays + i] =
            (struct traced_ray){p->p, d, (uint32_t)guide_cells_find(search->cells, p->p),
                                light_arrives(search->scene, p->p, p->ng, INT_MAX, &s)};
    }
}

// Traces rays until enough arrive. Sets *arriving to their number. False if the pool was stopped.
static bool trace_batches(struct box_search *search, struct parallel *pool, size_t *arriving) {
    *arriving = 0;
    for (int k = 0; k < BOX_BATCHES && *arriving < ARRIVING_LEAST; k++) {
        if (!parallel_for(pool, search->batch, 64, trace_rays, search)) return false;
        for (size_t i = 0; i < search->batch; i++) {
            const struct traced_ray *ray = &search->ray[search->rays + i];
            search->arriving[ray->cell] += ray->arrives;
            *arriving += ray->arrives;
        }
        search->rays += search->batch;
    }
    return true;
}

// ---- Moments ------------------------------------------------------------------------------------

// What rays through a bin have found.
struct bin_count {
    float rays, arriving;
};

// Each cell counts about as much, as each has densities of its own: otherwise the few points
// outside, where most rays arrive, would decide.
static void count_ray(const struct box_search *search, const struct traced_ray *ray,
                      struct bin_count *count) {
    const float weight = 1.0f / (1.0f + (float)search->arriving[ray->cell]);
    count->rays += weight;
    if (ray->arrives) count->arriving += weight;
}

// The moment of means over a bin and those around it: the edges of windows may be anywhere in them.
// Without means, a box as large as the ground is best for one seed in six, as a window happens to
// be one bin of it.
static double mean_moment(const struct bin_count *count, int bin) {
    int around[9];
    const int bins = light_box_around(bin, around);
    double rays = 0.0, arriving = 0.0;
    for (int k = 0; k < bins; k++) {
        rays += (double)count[around[k]].rays;
        arriving += (double)count[around[k]].arriving;
    }
    return sqrt(rays * arriving) / bins;
}

static void measure_boxes(void *ctx, size_t begin, size_t end, int worker) {
    struct box_search *search = ctx;
    (void)worker;
    for (size_t k = begin; k < end; k++) {
        const struct light_box *box = &search->box[k];
        struct bin_count count[LIGHT_HISTOGRAM_BINS] = {{0}}, outside = {0};
        for (size_t i = 0; i < search->rays; i++) {
            const struct traced_ray *ray = &search->ray[i];
            float density;
            const bool within = v3_within(ray->p, box->lo, box->hi);
            count_ray(search, ray,
                      within ? &count[light_box_bin(box, ray->p, ray->d, &density)] : &outside);
        }
        search->moment[k] = sqrt((double)outside.rays * (double)outside.arriving);
        for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
            search->moment[k] += mean_moment(count, bin);
    }
}

// ---- Faces --------------------------------------------------------------------------------------

struct box_faces {
    float offset[6][BOX_OFFSETS];  // those that differ, beginning with one around all points
    int count[6], chosen[6];       // of these offsets
    int few[6];                    // that of BOX_FEW among them
};

static void find_offsets(const float *sorted, size_t points, bool upper, int face,
                         struct box_faces *faces) {
    float *offset = faces->offset[face];
    for (int i = 0; i < BOX_OFFSETS; i++) {
        const size_t beyond = (size_t)(BOX_BEYOND[i] * (float)points);
        const float at = sorted[upper ? points - 1 - beyond : beyond];
        const int last = faces->count[face] - 1;
        if (last < 0 || offset[last] != at) offset[faces->count[face]++] = at;
        if (i == BOX_FEW) faces->few[face] = faces->count[face] - 1;
    }
}

static vec3 corner(const struct box_faces *faces, int upper, int moved, int offset) {
    float at[3];
    for (int axis = 0; axis < 3; axis++) {
        const int face = 2 * axis + upper;
        at[axis] = faces->offset[face][face == moved ? offset : faces->chosen[face]];
    }
    return v3(at[0], at[1], at[2]);
}

// The box with one of its faces moved to another offset.
static struct light_box moved_box(const struct box_search *search, const struct box_faces *faces,
                                  int face, int offset) {
    const vec3 lo = corner(faces, 0, face, offset), hi = corner(faces, 1, face, offset);
    const float half =
        0.5f * fmaxf(EXTENT_LEAST * search->extent, search->open * v3_max_abs(v3_sub(hi, lo)));
    const vec3 middle = v3_mul(v3_add(lo, hi), 0.5f), all_sides = v3(half, half, half);
    return light_box_make(v3_min(lo, v3_sub(middle, all_sides)),
                          v3_max(hi, v3_add(middle, all_sides)));
}

// Finds the offsets of all faces, around the points of the cells in a box, and chooses the first.
// They stay as they are if there are none.
static void find_faces(const struct box_search *search, vec3 lo, vec3 hi, struct box_faces *faces) {
    const struct guide_cell_point *point = search->cells->point;
    for (int axis = 0; axis < 3; axis++) {
        size_t count = 0;
        for (size_t i = 0; i < search->points; i++)
            if (v3_within(point[i].p, lo, hi)) search->sorted[count++] = v3_along(point[i].p, axis);
        if (count == 0) return;
        if (axis == 0) *faces = (struct box_faces){0};
        qsort(search->sorted, count, sizeof *search->sorted, array_compare_floats);
        find_offsets(search->sorted, count, false, 2 * axis, faces);
        find_offsets(search->sorted, count, true, 2 * axis + 1, faces);
    }
}

// Finds those around all points, and their largest extent.
static void begin_faces(struct box_search *search, struct box_faces *faces) {
    vec3 lo = search->cells->point[0].p, hi = lo;
    for (size_t i = 0; i < search->points; i++) {
        lo = v3_min(lo, search->cells->point[i].p);
        hi = v3_max(hi, search->cells->point[i].p);
    }
    const float widest = v3_max_abs(v3_sub(hi, lo));
    search->extent = widest > 0.0f ? widest : search->scene->radius;
    find_faces(search, lo, hi, faces);
}

// Moves a face to where the moment is least, which is set. False if the pool was stopped.
static bool move_face(struct box_search *search, struct box_faces *faces, int face,
                      struct parallel *pool, double *least) {
    const size_t count = (size_t)faces->count[face];
    for (int i = 0; i < faces->count[face]; i++) search->box[i] = moved_box(search, faces, face, i);
    if (!parallel_for(pool, count, 1, measure_boxes, search)) return false;
    int *chosen = &faces->chosen[face];
    for (int i = 0; i < faces->count[face]; i++)
        if (search->moment[i] < search->moment[*chosen]) *chosen = i;
    *least = search->moment[*chosen];
    return true;
}

static struct light_target box_of_faces(const struct box_faces *faces) {
    return (struct light_target){corner(faces, 0, 0, faces->chosen[0]),
                                 corner(faces, 1, 0, faces->chosen[0])};
}

// Moves all faces, if that is worth it. False if the pool was stopped.
static bool move_faces(struct box_search *search, struct box_faces *faces, struct parallel *pool) {
    const struct box_faces around = *faces;
    double least = 0.0;
    search->box[0] = moved_box(search, faces, 0, 0);
    if (!parallel_for(pool, 1, 1, measure_boxes, search)) return false;
    const double first = search->moment[0];
    for (int k = 0; k < SWEEPS; k++) {
        for (int face = 0; face < 6; face++)
            if (!move_face(search, faces, face, pool, &least)) return false;
        // Beyond one face, a hill outside may extend farther than the room in all other directions.
        find_faces(search, corner(faces, 0, 0, faces->chosen[0]),
                   corner(faces, 1, 0, faces->chosen[0]), faces);
    }
    const struct light_target all = box_of_faces(&around), some = box_of_faces(faces);
    const bool much = light_box_area(&some) < AREA_MUCH_SMALLER * light_box_area(&all);
    if (!(least < (much ? BOX_MUCH_SMALLER : BOX_SMALLER) * first)) *faces = around;
    return true;
}

// Moves the faces that are far outside because of few points. Where hardly any ray arrives, a
// single path from the eye through a hole has made the box 2.4 m longer than the room, and the bins
// of the hole were wrong. What lies within a bin of the face stays in the box.
static void leave_few(struct box_faces *faces) {
    for (int axis = 0; axis < 3; axis++) {
        const float *lower = faces->offset[2 * axis], *upper = faces->offset[2 * axis + 1];
        const float bin = (upper[0] - lower[0]) / LIGHT_HISTOGRAM_SIDE;
        for (int face = 2 * axis; face < 2 * axis + 2; face++) {
            const float *offset = faces->offset[face];
            if (fabsf(offset[faces->few[face]] - offset[0]) > bin)
                faces->chosen[face] = faces->few[face];
        }
    }
}

float guide_box_exit(const struct light_box *box, vec3 p, vec3 w) {
    float exit = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        const float d = v3_along(w, axis);
        if (d == 0.0f) continue;
        const float face = v3_along(d > 0.0f ? box->hi : box->lo, axis);
        exit = fminf(exit, (face - v3_along(p, axis)) / d);
    }
    return exit;
}

satin_status guide_box_find(const struct satin_scene *scene, uint64_t seed,
                            const struct guide_cells *cells, size_t rays, struct parallel *pool,
                            struct light_box *out, float *arriving) {
    struct box_search search = {.scene = scene, .cells = cells, .seed = seed, .batch = rays};
    for (size_t i = 0; i < guide_cells_count(cells); i++) search.points += cells->cell[i].count;
    search.sorted = array_new(search.points, sizeof *search.sorted);
    search.ray = array_new_unset(BOX_BATCHES * rays, sizeof *search.ray);
    size_t arrived = 0;
    satin_status status = search.sorted && search.ray ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK && !trace_batches(&search, pool, &arrived)) status = SATIN_CANCELLED;
    if (status == SATIN_OK) {
        struct box_faces faces;
        search.open = *arriving = (float)arrived / (float)search.rays;
        begin_faces(&search, &faces);
        if (arrived < ARRIVING_LEAST)
            leave_few(&faces);
        else if (!move_faces(&search, &faces, pool))
            status = SATIN_CANCELLED;
        *out = moved_box(&search, &faces, 0, faces.chosen[0]);
    }
    free(search.ray);
    free(search.sorted);
    return status;
}
