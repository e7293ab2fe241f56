// SPDX-License-Identifier: Apache-2.0
// Measures which lights are visible from which cells. The environment is visible through a window
// in a small fraction of all directions, and a lamp in the next room not at all, so that most
// samples of direct light would be occluded. Rays from the points of each cell measure in which
// bins of directions the environment is visible and which fraction of each light arrives. Direct
// light is sampled by both.
#include "guide/guide_visibility.h"

#include <limits.h>
#include <stdlib.h>

#include "base/sampling.h"

enum { LIGHT_RAYS = 32 };  // rays from a cell to each light

// The weight of a bin beside one where the environment is visible, as a fraction of that one's,
// because rays are few.
#define BESIDE 0.1f
// Fraction of the samples that is drawn by bins. Sampling by radiance is useless for a constant
// sky, and good for an image where all of it is visible. Samples by radiance that find light where
// the bins are dark are rare and bright: with .75 instead of .9, records on the ceiling of a room
// with windows deviate by 8.3 % instead of 7.2.
#define FRACTION 0.9f
// The least fraction of a light, because a light that no ray has found may be visible.
#define UNFOUND 0.1f

struct learning {
    const struct satin_scene *scene;
    uint64_t seed;
    int rays;  // rays per bin
    struct guide_visibility *visibility;
};

// ---- Environment -------------------------------------------------------------------------------

// What the rays of a cell find of the environment. The weight of a bin is the root mean square of
// what it contributes to E, radiance times cosine where it is visible: by these densities the sum
// of the variances at all points of the cell is least.
struct sky_tally {
    float weight[LIGHT_HISTOGRAM_BINS];
    float visible, facing;  // sums of the root of luminance: where it is visible, and of all
};

static void trace_bin(const struct learning *l, const struct guide_cell *cell, int bin,
                      struct rng *rng, struct sky_tally *tally) {
    const size_t first = rng_u32(rng) % cell->count;
    float squares = 0.0f;
    int asked = 0;
    for (size_t k = 0; k < cell->count && asked < l->rays; k++) {
        const struct guide_cell_point *p = &cell->point[(first + k) % cell->count];
        const float u = rng_float(rng), v = rng_float(rng);
        const vec3 w = light_histogram_direction(bin, u, v);
        if (!p->both && !(v3_dot(w, p->n) > 0.0f)) continue;
        asked++;
        const float L = rgb_luminance(light_environment(l->scene, w));
        if (!(L > 0.0f)) continue;
        tally->facing += sqrtf(L);
        struct light_sample sample = {.wi = w, .dist = INFINITY, .L = rgb_grey(1.0f)};
        if (!light_arrives(l->scene, p->p, p->ng, INT_MAX, &sample)) continue;
        tally->visible += sqrtf(L);
        squares += sqrf(L * v3_dot(w, p->n));
    }
    tally->weight[bin] = asked ? sqrtf(squares / (float)asked) : 0.0f;
}

// Rows end at the poles, columns wrap around.
static float brightest_beside(const struct sky_tally *tally, int bin) {
    const int row = bin / LIGHT_HISTOGRAM_SIDE, column = bin % LIGHT_HISTOGRAM_SIDE;
    float most = 0.0f;
    for (int y = row - 1; y <= row + 1; y++) {
        if (y < 0 || y >= LIGHT_HISTOGRAM_SIDE) continue;
        for (int x = column - 1; x <= column + 1; x++) {
            const int beside = (x + LIGHT_HISTOGRAM_SIDE) % LIGHT_HISTOGRAM_SIDE;
            most = fmaxf(most, tally->weight[y * LIGHT_HISTOGRAM_SIDE + beside]);
        }
    }
    return most;
}

static void learn_histogram(const struct learning *l, size_t i, struct rng *rng) {
    const struct light *light = &l->scene->light[l->scene->environment];
    struct sky_tally tally = {.visible = 0.0f};
    float weight[LIGHT_HISTOGRAM_BINS];
    for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
        trace_bin(l, &l->visibility->cells.cell[i], bin, rng, &tally);
    if (!(tally.visible > 0.0f)) return;  // the fraction stays 0
    for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++)
        weight[bin] = fmaxf(tally.weight[bin], BESIDE * brightest_beside(&tally, bin));
    light_bins_build(weight, &l->visibility->bins[i]);
    const float hidden = 1.0f - tally.visible / tally.facing;
    l->visibility->histogram[i] = (struct light_histogram){
        light->kind == LIGHT_CONSTANT ? FRACTION : FRACTION * hidden, &l->visibility->bins[i]};
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

static void learn(void *ctx, size_t begin, size_t end, int worker) {
    const struct learning *l = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(l->seed, RNG_VISIBILITY, i);
        if (l->visibility->sky) learn_histogram(l, i, &rng);
        if (l->visibility->choice) learn_choice(l, i, &rng);
    }
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
    struct learning learning = {scene, seed, samples.bin_rays, visibility};
    const size_t cells =
        visibility->cells.cell[0].count > 0 ? guide_cells_count(&visibility->cells) : 0;
    const bool done = parallel_for(pool, cells, 1, learn, &learning);
    free(visibility->cells.point);
    visibility->cells.point = NULL;
    if (done && cells > 0)
        *out = visibility;
    else
        free(visibility);
    return done ? SATIN_OK : SATIN_CANCELLED;
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
