// SPDX-License-Identifier: Apache-2.0
// Measures in which bins of directions the environment is visible from the cells, by rays from
// their points: through a window it is visible in a small fraction of all directions, so that most
// samples of its light would be occluded. Ranges of consecutive cells find out which bins are open,
// and each cell how much comes in by these. Direct light is sampled by the bins of the cells, and
// photons start through those of all together.
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/sampling.h"
#include "guide/guide_visibility.h"

enum {
    // Ranges of consecutive cells, which find out which bins are open: one for so many paths.
    SKY_RANGES = 32,
    RANGE_PATHS = 128,
    // Further rays of each range through a bin that may be a part of a small opening, and through
    // all such bins.
    SMALL_RAYS = 64,
    SMALL_RAYS_ALL = 2048,
    // Paths of the lights that look for openings which no point sees, per path of the eye.
    UNSEEN_PATHS = 8,
    BINS_CHUNK = 16  // bins or cells per chunk of the loops without rays
};

// The weight of a bin beside one where the environment is visible, as a fraction of that one's,
// because rays are few. For photons through openings, .1, .25 and 1 leave a variance of .00034,
// .00042 and .00144 of means over 5x5 pixels of the indirect light of a room with a slit of 2 cm.
#define BESIDE 0.1f
// The rays of a cell are few, and a bin in which they find nothing may be visible from another
// point of the cell. So in each bin the mean of the cells around counts as this many rays more. 0,
// 1 and 4 of them leave a variance of light that BRDF samples find, in a room with windows, of
// .0035, .0014 and .0007; that of light samples does not change. By 16 more samples are hidden.
#define AROUND 4.0f

// How far beyond the box a ray goes that leaves it, over the largest extent of the box: less than
// the wall is thick in which a small opening is. With .03, .01 and .005, none of the bins of a hole
// of 10 cm were found by 2, 0 and 0 of 8 seeds, and of one of 4 by 8 cm by 3, 0 and 0.
#define BEYOND_LEAST 0.005f
// The least weight for photons of a bin of a small opening. Of some, rays find hardly any light, as
// they are at grazing angles; with .1 instead of .3, photons through them were so strong that one
// of six images of a room with a slit had 1.3 times the indirect light.
#define SMALL_LEAST 0.3f

struct sky_learning {
    const struct satin_scene *scene;
    uint64_t seed;
    struct guide_visibility_samples samples;
    struct guide_visibility *visibility;
    size_t cells, ranges;
    // The sum of what rays have found, later its mean, and their number: for cell c and bin b at b
    // + bins c, and for range g at cells + g instead of c.
    float *square;
    uint8_t *traced;
    // For range g and bin b, at b + bins g: to how many rays from points in the box the environment
    // is visible there; and, if openings are small, whether a ray has left the box there.
    uint8_t *entered, *left;
    // For each bin, whether cells trace rays through it; and whether those do that are in the box.
    bool *open, *open_within;
    // If openings are small, for each bin whether it may be a part of one; and their number.
    bool *maybe;
    size_t maybes;
    // For each cell the second moment of light that its bins leave, see guide_sky_fraction; 0: it
    // sees nothing of the environment.
    float moment[GUIDE_CELLS_MAX];
};

// In the open, where bins leave more than this of the moment of samples by radiance in the mean of
// the cells, the environment is sampled by radiance alone, and photons are not aimed: both gain
// little there, and take time. In gardens, around a house and below a pergola it is .80 to .94, and
// the error without bins .66 to .97 of that with them at equal time. In a court with bushes it is
// .57, in one that is all walls, whose image has .6 of the variance with bins, .44; in a hall whose
// front is open .28, and in rooms .01 to .14. Cells whose bins leave less than CELL_MOMENT keep
// them, as a room that is seen from outside does; the errors are the same.
#define OPEN_MOMENT 0.75f
#define CELL_MOMENT 0.5f

// How many times as bright as its mean the environment counts at most. A sun much smaller than a
// bin is left to samples by radiance, as few of the rays through its bins find it. In a court
// beneath an image of a sky with a sun, direct light has .18 of the variance that samples by
// radiance alone leave without this, and .07 to .08 with 4, 8 or 16; around a house 1.02 and .87 to
// .89.
#define BRIGHT 8.0f

// Relative to the light's strength, as its square has to be finite. Without an environment, as for
// a sun alone, the bins that are open to the outside are found as if there were a constant one:
// what the sun lights there may light the room.
static float environment_luminance(const struct sky_learning *l, vec3 w) {
    if (!l->visibility->sky) return 1.0f;
    const float L = rgb_luminance(light_environment(l->scene, w));
    if (!(L > 0.0f)) return 0.0f;
    // The strength is that of irradiance.
    return fminf(L / l->scene->light[l->scene->environment].strength, BRIGHT / PI_F);
}

// What rays find of the environment.
struct sky_tally {
    uint8_t entered;  // in the last bin: the number of rays from points in the box that find it
    bool left;        // whether one of the others has left the box; if true before, none is tested
};

static size_t learned_at(size_t i, size_t bin) { return LIGHT_HISTOGRAM_BINS * i + bin; }

// Whether a ray along w from a point in the box goes on beyond the box.
static bool leaves_box(const struct sky_learning *l, const struct guide_cell_point *p, vec3 w) {
    const struct light_box *box = &l->visibility->box;
    if (!v3_within(p->p, box->lo, box->hi)) return false;
    const float exit = guide_box_exit(box, p->p, w);
    const float beyond = BEYOND_LEAST * v3_max_abs(v3_sub(box->hi, box->lo));
    const struct ray ray = scene_spawn(l->scene, p->p, p->ng, w);
    return scene_distance(l->scene, &ray) > exit + beyond;
}

// Traces rays from the points through a bin, at most one per point. Adds the sum of the squares of
// the radiance that is visible to those points that face the bin, and their number.
static void trace_bin(struct sky_learning *l, size_t i, const struct guide_cell *cell, int bin,
                      int wanted, struct rng *rng, struct sky_tally *tally) {
    const size_t first = rng_u32(rng) % cell->count;
    const size_t rays = cell->count < (size_t)wanted ? cell->count : (size_t)wanted;
    float squares = 0.0f;
    int facing = 0;
    tally->entered = 0;
    for (size_t k = 0; k < rays; k++) {
        const struct guide_cell_point *p = &cell->point[(first + k) % cell->count];
        const float u = rng_float(rng), v = rng_float(rng);
        float density;
        const vec3 w = light_box_direction(&l->visibility->box, p->p, bin, u, v, &density);
        if (!p->both && !(v3_dot(w, p->n) > 0.0f)) continue;
        const float L = environment_luminance(l, w);
        facing++;
        if (!(L > 0.0f)) continue;
        struct light_sample sample = {.wi = w, .dist = INFINITY, .L = rgb_grey(1.0f)};
        if (!light_arrives(l->scene, p->p, p->ng, INT_MAX, &sample)) {
            tally->left = tally->left || leaves_box(l, p, w);
            continue;
        }
        tally->entered += v3_within(p->p, l->visibility->box.lo, l->visibility->box.hi);
        squares += sqrf(L);
    }
    l->square[learned_at(i, (size_t)bin)] += squares;
    l->traced[learned_at(i, (size_t)bin)] += (uint8_t)facing;
}

static void begin_bins(const struct sky_learning *l, size_t i) {
    memset(&l->square[learned_at(i, 0)], 0, LIGHT_HISTOGRAM_BINS * sizeof *l->square);
    memset(&l->traced[learned_at(i, 0)], 0, LIGHT_HISTOGRAM_BINS * sizeof *l->traced);
}

// The points of the cells of range g.
static struct guide_cell range_points(const struct sky_learning *l, size_t g) {
    const size_t each = l->cells / l->ranges;
    struct guide_cell all = {l->visibility->cells.cell[g * each].point, 0};
    for (size_t i = 0; i < each; i++) all.count += l->visibility->cells.cell[g * each + i].count;
    return all;
}

static void trace_range(struct sky_learning *l, size_t g, struct rng *rng) {
    const struct guide_cell points = range_points(l, g);
    struct sky_tally tally = {0};
    begin_bins(l, l->cells + g);
    for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
        tally.left = !l->visibility->small;
        trace_bin(l, l->cells + g, &points, bin, l->samples.bin_rays, rng, &tally);
        l->entered[learned_at(g, (size_t)bin)] = tally.entered;
        l->left[learned_at(g, (size_t)bin)] = tally.left || tally.entered > 0;
    }
}

// Finds the bins by which some range has left the box, and those beside them.
static void find_small_bins(struct sky_learning *l) {
    for (size_t bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
        int around[9];
        for (int i = light_box_around((int)bin, around); i-- > 0;)
            for (size_t g = 0; g < l->ranges; g++)
                l->maybe[bin] |= l->left[learned_at(g, (size_t)around[i])] > 0;
        l->maybes += l->maybe[bin];
    }
}

// Traces further rays of a range through these bins: of a hole of 10 cm in a wall as thick, few see
// the environment.
static void trace_small_bins(struct sky_learning *l, size_t g, struct rng *rng) {
    const struct guide_cell points = range_points(l, g);
    const size_t all = SMALL_RAYS_ALL / l->maybes, rays = all < SMALL_RAYS ? all : SMALL_RAYS;
    struct sky_tally tally = {.left = true};
    for (int bin = 0; rays > 0 && bin < LIGHT_HISTOGRAM_BINS; bin++) {
        if (!l->maybe[bin]) continue;
        trace_bin(l, l->cells + g, &points, bin, (int)rays, rng, &tally);
        l->entered[learned_at(g, (size_t)bin)] += tally.entered;
    }
}

// Finds the bins in which some range has found the environment, from any point and from one in the
// box, and those beside them.
static void find_open_bins(void *ctx, size_t begin, size_t end, int worker) {
    struct sky_learning *l = ctx;
    (void)worker;
    for (size_t bin = begin; bin < end; bin++) {
        int around[9];
        for (int i = light_box_around((int)bin, around); i-- > 0;)
            for (size_t g = 0; g < l->ranges; g++) {
                l->open[bin] |= l->square[learned_at(l->cells + g, (size_t)around[i])] > 0.0f;
                l->open_within[bin] |= l->entered[learned_at(g, (size_t)around[i])] > 0;
            }
    }
}

// The fraction of the rays through a bin to which the environment is visible, from points in the
// box.
static float entered_fraction(const struct sky_learning *l, size_t bin) {
    float entered = 0.0f, rays = 0.0f;
    for (size_t g = 0; g < l->ranges; g++) {
        entered += (float)l->entered[learned_at(g, bin)];
        rays += (float)l->traced[learned_at(l->cells + g, bin)];
    }
    return rays > 0.0f ? entered / rays : 0.0f;
}

// The openings for photons are the bins in which some range has found the environment from points
// in the box: light that comes in there arrives at these. Bins that are open from points outside it
// alone, such as the ground before a window, count as those beside the open ones. Those of small
// openings have the weight that leaves the least variance, the root of the fraction of photons that
// come in: it is known, as rays are many.
static satin_status find_openings(const struct sky_learning *l, struct parallel *pool) {
    struct guide_visibility *visibility = l->visibility;
    float weight[LIGHT_HISTOGRAM_BINS], most = 0.0f;
    satin_status status = SATIN_OK;
    for (size_t bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
        weight[bin] = entered_fraction(l, bin);
        most = fmaxf(most, weight[bin]);
    }
    for (size_t bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
        if (weight[bin] > 0.0f)
            weight[bin] = visibility->small ? fmaxf(sqrtf(weight[bin] / most), SMALL_LEAST) : 1.0f;
        else
            weight[bin] = l->open[bin] ? BESIDE : 0.0f;
    }
    if (!(most > 0.0f))
        status = guide_openings_unseen(l->scene, l->seed, &visibility->box,
                                       UNSEEN_PATHS * (size_t)visibility->paths, pool, weight);
    guide_openings_make(l->scene, &visibility->box, weight, &visibility->openings,
                        &visibility->aim);
    return status;
}

// The bins through which a cell traces rays. From points in the box, light of the others is hidden.
static const bool *open_bins(const struct sky_learning *l, const struct guide_cell *cell) {
    const struct light_box *box = &l->visibility->box;
    for (size_t i = 0; i < cell->count; i++)
        if (!v3_within(cell->point[i].p, box->lo, box->hi)) return l->open;
    return l->open_within;
}

// A cell traces as many rays as if a certain number of bins had all rays.
static void trace_cell(struct sky_learning *l, size_t i, struct rng *rng) {
    begin_bins(l, i);
    const struct guide_cell *cell = &l->visibility->cells.cell[i];
    const bool *open = open_bins(l, cell);
    int bins = 0;
    for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) bins += open[bin];
    const float all = (float)l->samples.open_bins / (float)bins;
    const float rays = (float)l->samples.bin_rays * fminf(all, 1.0f);
    struct sky_tally unused = {.left = true};
    for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
        if (!open[bin]) continue;
        const int wanted = (int)(rays + rng_float(rng));
        if (wanted > 0) trace_bin(l, i, cell, bin, wanted, rng, &unused);
    }
}

// Replaces the sums of the squares of the cells by their means, bin by bin: each node of the tree
// of cells adds the mean of its parent to the rays in it.
static void mean_squares(void *ctx, size_t begin, size_t end, int worker) {
    const struct sky_learning *l = ctx;
    const size_t cells = l->cells;
    // These are of the nodes of the tree, and the cells come last.
    float sum[2 * GUIDE_CELLS_MAX], rays[2 * GUIDE_CELLS_MAX];
    (void)worker;
    for (size_t bin = begin; bin < end; bin++) {
        if (!l->open[bin]) continue;
        for (size_t i = 0; i < cells; i++) {
            sum[cells - 1 + i] = l->square[learned_at(i, bin)];
            rays[cells - 1 + i] = (float)l->traced[learned_at(i, bin)];
        }
        for (size_t n = cells - 1; n-- > 0;) {
            sum[n] = sum[2 * n + 1] + sum[2 * n + 2];
            rays[n] = rays[2 * n + 1] + rays[2 * n + 2];
            if (n + 1 < l->ranges || n + 1 >= 2 * l->ranges) continue;
            const size_t range = learned_at(cells + n + 1 - l->ranges, bin);
            sum[n] += l->square[range];
            rays[n] += (float)l->traced[range];
        }
        sum[0] = rays[0] > 0.0f ? sum[0] / rays[0] : 0.0f;
        for (size_t n = 1; n < 2 * cells - 1; n++)
            sum[n] = (sum[n] + AROUND * sum[(n - 1) / 2]) / (rays[n] + AROUND);
        for (size_t i = 0; i < cells; i++) l->square[learned_at(i, bin)] = sum[cells - 1 + i];
    }
}

// The weight of a bin is the root mean square of its visible radiance: by that times the cosine and
// the solid angle of each point (light_product.c), the sum of the variances at all points of the
// cell is least.
static void build_bins(void *ctx, size_t begin, size_t end, int worker) {
    struct sky_learning *l = ctx;
    struct guide_visibility *visibility = l->visibility;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const bool *open = open_bins(l, &visibility->cells.cell[i]);
        float found[LIGHT_HISTOGRAM_BINS], weight[LIGHT_HISTOGRAM_BINS], most = 0.0f;
        for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
            found[bin] = open[bin] ? sqrtf(l->square[learned_at(i, (size_t)bin)]) : 0.0f;
            most = fmaxf(most, found[bin]);
        }
        if (!(most > 0.0f)) continue;  // the fraction stays 0
        for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
            int around[9];
            float beside = 0.0f;
            weight[bin] = 0.0f;
            if (!open[bin]) continue;
            for (int k = light_box_around(bin, around); k-- > 0;)
                beside = fmaxf(beside, found[around[k]]);
            weight[bin] = fmaxf(found[bin], BESIDE * beside);
        }
        struct light_histogram *histogram = &visibility->histogram[i];
        struct rng rng = rng_make(l->seed, RNG_VISIBILITY, 2 * (l->cells + SKY_RANGES) + i);
        light_histogram_build(weight, 1.0f, &visibility->blocks, histogram);
        histogram->fraction = guide_sky_fraction(l->scene, &visibility->cells.cell[i], histogram,
                                                 &rng, &l->moment[i]);
    }
}

// ---- The whole --------------------------------------------------------------------------------

static void trace_range_bins(void *ctx, size_t begin, size_t end, int worker) {
    struct sky_learning *l = ctx;
    (void)worker;
    for (size_t g = begin; g < end; g++) {
        struct rng rng = rng_make(l->seed, RNG_VISIBILITY, 2 * l->cells + g);
        trace_range(l, g, &rng);
    }
}

static void trace_ranges_small(void *ctx, size_t begin, size_t end, int worker) {
    struct sky_learning *l = ctx;
    (void)worker;
    for (size_t g = begin; g < end; g++) {
        struct rng rng = rng_make(l->seed, RNG_VISIBILITY, 2 * l->cells + SKY_RANGES + g);
        trace_small_bins(l, g, &rng);
    }
}

static void trace_cell_bins(void *ctx, size_t begin, size_t end, int worker) {
    struct sky_learning *l = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(l->seed, RNG_VISIBILITY, l->cells + i);
        trace_cell(l, i, &rng);
    }
}

// Learns what the cells see of the sky. False if the pool was stopped.
static bool learn_sky(struct sky_learning *l, struct parallel *pool) {
    const struct parallel_results cells = {
        .slot = {{l->square, LIGHT_HISTOGRAM_BINS * sizeof *l->square},
                 {l->traced, LIGHT_HISTOGRAM_BINS * sizeof *l->traced}},
        .journaled = true};
    light_blocks_build(&l->visibility->box, l->open, &l->visibility->blocks);
    return parallel_for_results(pool, l->cells, 1, trace_cell_bins, l, &cells) &&
           parallel_for(pool, LIGHT_HISTOGRAM_BINS, BINS_CHUNK, mean_squares, l) &&
           parallel_for(pool, l->cells, BINS_CHUNK, build_bins, l);
}

// Whether the cells are in the open.
static bool in_the_open(const struct sky_learning *l) {
    float sum = 0.0f, count = 0.0f;
    for (size_t i = 0; i < l->cells; i++) {
        sum += l->moment[i];
        count += l->moment[i] > 0.0f;
    }
    return count > 0.0f && sum > OPEN_MOMENT * count;
}

static void leave_to_radiance(struct sky_learning *l) {
    for (size_t i = 0; i < l->cells; i++)
        if (l->moment[i] > CELL_MOMENT) l->visibility->histogram[i].fraction = 0.0f;
}

// The number of ranges, a power of two as that of the cells.
static size_t range_count(size_t cells, int paths) {
    size_t ranges = 1;
    while (2 * ranges <= cells && 2 * ranges <= SKY_RANGES &&
           2 * ranges * RANGE_PATHS <= (size_t)paths)
        ranges *= 2;
    return ranges;
}

// Learns in which bins the environment is visible. False if the pool was stopped.
static bool learn_bins(struct sky_learning *l, struct parallel *pool) {
    const size_t first = l->cells * LIGHT_HISTOGRAM_BINS;
    const struct parallel_results ranges = {
        .slot = {{l->square + first, LIGHT_HISTOGRAM_BINS * sizeof *l->square},
                 {l->traced + first, LIGHT_HISTOGRAM_BINS * sizeof *l->traced},
                 {l->entered, LIGHT_HISTOGRAM_BINS * sizeof *l->entered},
                 {l->left, LIGHT_HISTOGRAM_BINS * sizeof *l->left}},
        .journaled = true};
    if (!parallel_for_results(pool, l->ranges, 1, trace_range_bins, l, &ranges)) return false;
    if (l->visibility->small) find_small_bins(l);
    return (l->maybes == 0 ||
            parallel_for_results(pool, l->ranges, 1, trace_ranges_small, l, &ranges)) &&
           parallel_for(pool, LIGHT_HISTOGRAM_BINS, BINS_CHUNK, find_open_bins, l);
}

satin_status guide_sky_learn(const struct satin_scene *scene, uint64_t seed,
                             struct guide_visibility_samples samples, struct parallel *pool,
                             struct guide_visibility *visibility) {
    struct sky_learning l = {
        .scene = scene, .seed = seed, .samples = samples, .visibility = visibility};
    l.cells = guide_cells_count(&visibility->cells);
    l.ranges = range_count(l.cells, visibility->paths);
    const size_t all = (l.cells + l.ranges) * LIGHT_HISTOGRAM_BINS;
    satin_status status = SATIN_ERROR_MEMORY;
    // The loops that trace rays set all of the first four.
    l.square = array_new_unset(all, sizeof *l.square);
    l.traced = array_new_unset(all, sizeof *l.traced);
    l.entered = array_new_unset(l.ranges * LIGHT_HISTOGRAM_BINS, sizeof *l.entered);
    l.left = array_new_unset(l.ranges * LIGHT_HISTOGRAM_BINS, sizeof *l.left);
    l.open = array_new(LIGHT_HISTOGRAM_BINS, sizeof *l.open);
    l.open_within = array_new(LIGHT_HISTOGRAM_BINS, sizeof *l.open_within);
    l.maybe = array_new(LIGHT_HISTOGRAM_BINS, sizeof *l.maybe);
    if (l.square && l.traced && l.entered && l.left && l.open && l.open_within && l.maybe) {
        const bool done = learn_bins(&l, pool) && (!visibility->sky || learn_sky(&l, pool));
        status = done ? SATIN_OK : SATIN_CANCELLED;
        if (done && in_the_open(&l))
            leave_to_radiance(&l);
        else if (done)
            status = find_openings(&l, pool);
    }
    free(l.square);
    free(l.traced);
    free(l.entered);
    free(l.left);
    free(l.open);
    free(l.open_within);
    free(l.maybe);
    return status;
}

// Pages that nothing writes take no memory.
double guide_sky_most(const struct satin_scene *scene) {
    const struct sky_learning *l = NULL;
    const size_t cells = scene->environment >= 0 ? GUIDE_CELLS_MAX : 0;
    const size_t measured = (cells + SKY_RANGES) * (sizeof *l->square + sizeof *l->traced),
                 ranges = SKY_RANGES * (sizeof *l->entered + sizeof *l->left);
    return (double)(LIGHT_HISTOGRAM_BINS * (measured + ranges));
}
