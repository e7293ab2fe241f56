// SPDX-License-Identifier: Apache-2.0
// Measures which lights are visible from which cells. The environment is visible through a window
// in a small fraction of all directions, and a lamp in the next room not at all, so that most
// samples of direct light would be occluded. Rays from the points of each cell measure in which
// bins of directions the environment is visible and which fraction of each light arrives. Direct
// light is sampled by both.
#include "guide/guide_visibility.h"

#include <limits.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"

enum {
    LIGHT_RAYS = 32,  // rays from a cell to each light
    BINS_CHUNK = 16   // bins or cells per chunk of the loops without rays
};

// The weight of a bin beside one where the environment is visible, as a fraction of that one's,
// because rays are few.
#define BESIDE 0.1f
// Fraction of the samples that is drawn by bins. Sampling by radiance is useless for a constant
// sky, and good for an image where all of it is visible. Samples by radiance that find light where
// the bins are dark are rare and bright: with .75 instead of .9, records on the ceiling of a room
// with windows deviate by 8.3 % instead of 7.2.
#define FRACTION 0.9f
// The rays of a cell are few, and a bin in which they find nothing may be visible from another
// point of the cell. So in each bin the mean of the cells around counts as this many rays more. 0,
// 1 and 4 of them leave a variance of light that BRDF samples find, in a room with windows, of
// .0035, .0014 and .0007; that of light samples does not change. By 16 more samples are hidden.
#define AROUND 4.0f
// The least fraction of a light, because a light that no ray has found may be visible.
#define UNFOUND 0.1f

struct learning {
    const struct satin_scene *scene;
    uint64_t seed;
    int rays;  // rays per bin
    struct guide_visibility *visibility;
    float *square;  // of cell c and bin b at c + cells b, see mean_squares
    size_t cells;
};

// ---- Environment -------------------------------------------------------------------------------

// What the rays of a cell find of the environment: sums of the root of luminance where it is
// visible, and of all that the points face.
struct sky_tally {
    float visible, facing;
};

static size_t cell_rays(const struct learning *l, const struct guide_cell *cell) {
    return cell->count < (size_t)l->rays ? cell->count : (size_t)l->rays;
}

// Returns the sum of the squares of what the bin contributes to E, radiance times cosine, at points
// of the cell.
static float trace_bin(const struct learning *l, const struct guide_cell *cell, int bin,
                       struct rng *rng, struct sky_tally *tally) {
    const size_t first = rng_u32(rng) % cell->count, rays = cell_rays(l, cell);
    float squares = 0.0f;
    for (size_t k = 0; k < rays; k++) {
        const struct guide_cell_point *p = &cell->point[(first + k) % cell->count];
        const float u = rng_float(rng), v = rng_float(rng);
        const vec3 w = light_histogram_direction(bin, u, v);
        if (!p->both && !(v3_dot(w, p->n) > 0.0f)) continue;
        const float L = rgb_luminance(light_environment(l->scene, w));
        if (!(L > 0.0f)) continue;
        tally->facing += sqrtf(L);
        struct light_sample sample = {.wi = w, .dist = INFINITY, .L = rgb_grey(1.0f)};
        if (!light_arrives(l->scene, p->p, p->ng, INT_MAX, &sample)) continue;
        tally->visible += sqrtf(L);
        squares += sqrf(L * v3_dot(w, p->n));
    }
    return squares;
}

// Rows end at the poles, columns wrap around.
static float brightest_beside(const float weight[LIGHT_HISTOGRAM_BINS], int bin) {
    const int row = bin / LIGHT_HISTOGRAM_SIDE, column = bin % LIGHT_HISTOGRAM_SIDE;
    float most = 0.0f;
    for (int y = row - 1; y <= row + 1; y++) {
        if (y < 0 || y >= LIGHT_HISTOGRAM_SIDE) continue;
        for (int x = column - 1; x <= column + 1; x++) {
            const int beside = (x + LIGHT_HISTOGRAM_SIDE) % LIGHT_HISTOGRAM_SIDE;
            most = fmaxf(most, weight[y * LIGHT_HISTOGRAM_SIDE + beside]);
        }
    }
    return most;
}

static void trace_sky(const struct learning *l, size_t i, struct rng *rng) {
    const struct light *light = &l->scene->light[l->scene->environment];
    struct sky_tally tally = {0.0f, 0.0f};
    for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
        l->square[i + l->cells * (size_t)bin] =
            trace_bin(l, &l->visibility->cells.cell[i], bin, rng, &tally);
    if (!(tally.visible > 0.0f)) return;  // the fraction stays 0
    const float hidden = 1.0f - tally.visible / tally.facing;
    l->visibility->histogram[i] = (struct light_histogram){
        light->kind == LIGHT_CONSTANT ? FRACTION : FRACTION * hidden, &l->visibility->bins[i]};
}

// Replaces the sums of the squares by their means, bin by bin: each node of the tree of cells adds
// the mean of its parent to its own rays.
static void mean_squares(void *ctx, size_t begin, size_t end, int worker) {
    const struct learning *l = ctx;
    const size_t cells = l->cells;
    // These are of the nodes of the tree, and the cells come last.
    float sum[2 * GUIDE_CELLS_MAX] = {0.0f}, rays[2 * GUIDE_CELLS_MAX] = {0.0f};
    (void)worker;
    for (size_t i = 0; i < cells; i++)
        rays[cells - 1 + i] = (float)cell_rays(l, &l->visibility->cells.cell[i]);
    for (size_t n = cells - 1; n-- > 0;) rays[n] = rays[2 * n + 1] + rays[2 * n + 2];
    for (size_t bin = begin; bin < end; bin++) {
        float *square = l->square + cells * bin;
        for (size_t i = 0; i < cells; i++) sum[cells - 1 + i] = square[i];
        for (size_t n = cells - 1; n-- > 0;) sum[n] = sum[2 * n + 1] + sum[2 * n + 2];
        sum[0] /= rays[0];
        for (size_t n = 1; n < 2 * cells - 1; n++)
            sum[n] = (sum[n] + AROUND * sum[(n - 1) / 2]) / (rays[n] + AROUND);
        for (size_t i = 0; i < cells; i++) square[i] = sum[cells - 1 + i];
    }
}

// The weight of a bin is the root mean square of what it contributes to E: by these densities the
// sum of the variances at all points of the cell is least.
static void build_bins(void *ctx, size_t begin, size_t end, int worker) {
    const struct learning *l = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        float found[LIGHT_HISTOGRAM_BINS], weight[LIGHT_HISTOGRAM_BINS];
        for (size_t bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
            found[bin] = sqrtf(l->square[i + l->cells * bin]);
        for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
            weight[bin] = fmaxf(found[bin], BESIDE * brightest_beside(found, bin));
        light_bins_build(weight, &l->visibility->bins[i]);
    }
}

// ---- Lights -----------------------------------------------------------------------------------

// The irradiance from one light at a point, by one sample.
static float sample_arriving(const struct satin_scene *scene, uint32_t light,
                             struct light_visibility visibility, const struct guide_cell_point *p,
                             struct rng *rng) {
    const float u = rng_float(rng), v = rng_float(rng);
    struct light_sample s;
    if (!light_sample_visible(scene, light, visibility, p->p, u, v, &s)) return 0.0f;
    float cosine = v3_dot(s.wi, p->n);
    if (p->both) cosine = fabsf(cosine);
    if (!(cosine > 0.0f)) return 0.0f;
    const bool arrives = light_arrives(scene, p->p, p->ng, INT_MAX, &s);
    return arrives ? cosine * rgb_luminance(s.L) / s.pdf_w : 0.0f;
}

static void learn_choice(const struct learning *l, size_t i, struct rng *rng) {
    const struct guide_cell *cell = &l->visibility->cells.cell[i];
    const struct light_histogram *histogram = &l->visibility->histogram[i];
    const struct light_visibility visibility = {histogram->fraction > 0.0f ? histogram : NULL,
                                                NULL};
    for (uint32_t light = 0; light < l->scene->light_count; light++) {
        float E = 0.0f, expected = 0.0f;
        for (size_t k = 0; k < LIGHT_RAYS; k++) {
            const struct guide_cell_point *p = &cell->point[k % cell->count];
            expected += light_estimate(l->scene, &l->scene->light[light], p->p);
            E += sample_arriving(l->scene, light, visibility, p, rng);
        }
        const float visible = E / expected;
        l->visibility->visible[i][light] = isfinite(visible) ? fmaxf(visible, UNFOUND) : 1.0f;
    }
}

// ---- The whole --------------------------------------------------------------------------------

static void trace_skies(void *ctx, size_t begin, size_t end, int worker) {
    const struct learning *l = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(l->seed, RNG_VISIBILITY, l->cells + i);
        trace_sky(l, i, &rng);
    }
}

// The results of a cell: its mean squares, and how much of what it faces is hidden.
static void pack_sky(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct learning *l = ctx;
    for (size_t i = begin; i < end; i++) {
        for (size_t bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
            bytes_put(out, &l->square[i + l->cells * bin], sizeof *l->square);
        bytes_put(out, &l->visibility->histogram[i].fraction, sizeof(float));
    }
}

static bool unpack_sky(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct learning *l = ctx;
    for (size_t i = begin; i < end; i++) {
        for (size_t bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
            bytes_get(in, &l->square[i + l->cells * bin], sizeof *l->square);
        float fraction;
        bytes_get(in, &fraction, sizeof fraction);
        if (fraction > 0.0f)
            l->visibility->histogram[i] =
                (struct light_histogram){fraction, &l->visibility->bins[i]};
    }
    return true;
}

static void learn_choices(void *ctx, size_t begin, size_t end, int worker) {
    const struct learning *l = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(l->seed, RNG_VISIBILITY, i);
        learn_choice(l, i, &rng);
    }
}

// Lights are chosen by samples that go by what is visible of the environment.
static satin_status learn(struct learning *l, struct parallel *pool) {
    struct guide_visibility *visibility = l->visibility;
    bool done = true;
    if (visibility->sky) {
        l->square = array_new(l->cells * LIGHT_HISTOGRAM_BINS, sizeof *l->square);
        if (!l->square) return SATIN_ERROR_MEMORY;
        const struct parallel_results skies = {
            .pack = pack_sky, .unpack = unpack_sky, .journaled = true};
        done = parallel_for_results(pool, l->cells, 1, trace_skies, l, &skies) &&
               parallel_for(pool, LIGHT_HISTOGRAM_BINS, BINS_CHUNK, mean_squares, l) &&
               parallel_for(pool, l->cells, BINS_CHUNK, build_bins, l);
        free(l->square);
    }
    const struct parallel_results choices = {
        .slot = {{visibility->visible, sizeof *visibility->visible}}, .journaled = true};
    if (done && visibility->choice)
        done = parallel_for_results(pool, l->cells, 1, learn_choices, l, &choices);
    return done ? SATIN_OK : SATIN_CANCELLED;
}

satin_status guide_visibility_build(const struct satin_scene *scene, uint64_t seed,
                                    struct guide_visibility_samples samples, struct parallel *pool,
                                    struct guide_visibility **out) {
    const bool sky = scene->environment >= 0;
    const bool choice = scene->light_count > 1 && scene->light_count <= LIGHT_WEIGHTS_MAX;
    *out = NULL;
    if (!sky && !choice) return SATIN_OK;
    struct guide_visibility *visibility = calloc(1, sizeof *visibility);
    if (!visibility || !guide_cells_make(scene, seed, samples.paths, pool, &visibility->cells)) {
        free(visibility);
        return SATIN_ERROR_MEMORY;
    }
    visibility->sky = sky;
    visibility->choice = choice;
    const size_t cells =
        visibility->cells.cell[0].count > 0 ? guide_cells_count(&visibility->cells) : 0;
    struct learning learning = {scene, seed, samples.bin_rays, visibility, NULL, cells};
    const satin_status status = cells > 0 ? learn(&learning, pool) : SATIN_OK;
    free(visibility->cells.point);
    visibility->cells.point = NULL;
    if (status == SATIN_OK && cells > 0)
        *out = visibility;
    else
        free(visibility);
    return status;
}

struct light_visibility guide_visibility_at(const struct guide_visibility *visibility, vec3 p) {
    if (!visibility) return LIGHT_ALL_VISIBLE;
    const size_t i = guide_cells_find(&visibility->cells, p);
    return (struct light_visibility){
        visibility->histogram[i].fraction > 0.0f ? &visibility->histogram[i] : NULL,
        visibility->choice ? visibility->visible[i] : NULL};
}

size_t guide_visibility_bytes(const struct guide_visibility *visibility) {
    return visibility ? sizeof *visibility : 0;
}

void guide_visibility_free(struct guide_visibility *visibility) { free(visibility); }
