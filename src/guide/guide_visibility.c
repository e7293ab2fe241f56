// SPDX-License-Identifier: Apache-2.0
// Measures which lights are visible from which cells: a lamp in the next room is not, and of the
// environment only what windows show (guide_sky.c). Rays from the points of each cell measure which
// fraction of each light arrives. Direct light is sampled by both.
#include "guide/guide_visibility.h"

#include <limits.h>
#include <stdlib.h>

// Where less than this fraction of rays leave the scene, openings are small, which takes more paths
// to find: it is .0001 to .0016 through holes and slits of 10 and 5 cm, and .013 or more through
// windows.
#define SMALL_OPENINGS 0.004f
// The least fraction of a light, because a light that no ray has found may be visible.
#define UNFOUND 0.1f

struct learning {
    const struct satin_scene *scene;
    uint64_t seed;
    struct guide_visibility_samples samples;
    struct guide_visibility *visibility;
    size_t cells;
};

static bool has_far_light(const struct satin_scene *scene) {
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (light_is_far(&scene->light[i])) return true;
    return false;
}

// ---- Lights -----------------------------------------------------------------------------------

// Makes the product of a cell's histogram at a point of it. NULL if the cell has none.
static const struct light_product *product_at(const struct light_histogram *histogram,
                                              const struct light_receiver *at,
                                              struct light_product *product) {
    if (!(histogram->fraction > 0.0f)) return NULL;
    light_product_make(histogram, at, product);
    return product;
}

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
    for (uint32_t light = 0; light < l->scene->light_count; light++) {
        float E = 0.0f, expected = 0.0f;
        for (size_t k = 0; k < (size_t)l->samples.light_rays; k++) {
            const struct guide_cell_point *p = &cell->point[k % cell->count];
            const struct light_receiver at = {p->p, p->n, p->both};
            struct light_product product;
            const struct light_visibility visibility = {
                product_at(&l->visibility->histogram[i], &at, &product), NULL};
            expected += light_estimate(l->scene, &l->scene->light[light], p->p);
            E += sample_arriving(l->scene, light, visibility, p, rng);
        }
        const float visible = E / expected;
        l->visibility->visible[i][light] = isfinite(visible) ? fmaxf(visible, UNFOUND) : 1.0f;
    }
}

// ---- The whole --------------------------------------------------------------------------------

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
    if (has_far_light(l->scene)) {
        const satin_status status =
            guide_sky_learn(l->scene, l->seed, l->samples, pool, visibility);
        if (status != SATIN_OK) return status;
    }
    const struct parallel_results choices = {
        .slot = {{visibility->visible, sizeof *visibility->visible}}, .journaled = true};
    const bool done =
        !visibility->choice || parallel_for_results(pool, l->cells, 1, learn_choices, l, &choices);
    return done ? SATIN_OK : SATIN_CANCELLED;
}

static bool has_choice(const struct satin_scene *scene) {
    return scene->light_count > 1 && scene->light_count <= LIGHT_WEIGHTS_MAX;
}

// Makes the cells, none if the paths hit nothing, and finds the box of the histograms.
static satin_status find_cells_and_box(struct learning *l, struct parallel *pool) {
    struct guide_visibility *visibility = l->visibility;
    struct guide_cells *cells = &visibility->cells;
    const int paths = l->samples.paths;
    float arriving = 1.0f;
    if (!guide_cells_make(l->scene, l->seed, paths, GUIDE_CELL_BOUNCES, pool, cells))
        return SATIN_ERROR_MEMORY;
    l->cells = cells->cell[0].count > 0 ? guide_cells_count(cells) : 0;
    visibility->paths = paths;
    if (l->cells == 0 || !has_far_light(l->scene)) return SATIN_OK;
    const size_t rays = (size_t)paths * (size_t)l->samples.box_rays;
    const satin_status status =
        guide_box_find(l->scene, l->seed, cells, rays, pool, &visibility->box, &arriving);
    visibility->small = arriving < SMALL_OPENINGS;
    return status;
}

satin_status guide_visibility_build(const struct satin_scene *scene, uint64_t seed,
                                    struct guide_visibility_samples samples, struct parallel *pool,
                                    struct guide_visibility **out) {
    const bool sky = scene->environment >= 0;
    const bool choice = has_choice(scene);
    *out = NULL;
    if (!has_far_light(scene) && !choice) return SATIN_OK;
    struct guide_visibility *visibility = calloc(1, sizeof *visibility);
    if (!visibility) return SATIN_ERROR_MEMORY;
    visibility->sky = sky;
    visibility->choice = choice;
    struct learning learning = {
        .scene = scene, .seed = seed, .samples = samples, .visibility = visibility};
    satin_status status = find_cells_and_box(&learning, pool);
    if (status == SATIN_OK && learning.cells > 0) status = learn(&learning, pool);
    free(visibility->cells.point);
    visibility->cells.point = NULL;
    if (status == SATIN_OK && learning.cells > 0)
        *out = visibility;
    else
        free(visibility);
    return status;
}

bool guide_visibility_small(const struct guide_visibility *visibility) { return visibility->small; }

const struct light_aim *guide_visibility_aim(const struct guide_visibility *visibility) {
    return visibility && visibility->aim.openings ? &visibility->aim : NULL;
}

struct light_visibility guide_visibility_at(const struct guide_visibility *visibility,
                                            const struct light_receiver *at,
                                            struct light_product *product) {
    if (!visibility) return LIGHT_ALL_VISIBLE;
    const size_t i = guide_cells_find(&visibility->cells, at->p);
    return (struct light_visibility){product_at(&visibility->histogram[i], at, product),
                                     visibility->choice ? visibility->visible[i] : NULL};
}

double guide_visibility_most(const struct satin_scene *scene) {
    const struct guide_visibility *v = NULL;
    if (has_far_light(scene)) return sizeof *v + guide_sky_most(scene);
    return has_choice(scene) ? (double)(sizeof *v - sizeof v->histogram) : 0.0;
}

size_t guide_visibility_bytes(const struct guide_visibility *visibility) {
    return visibility ? sizeof *visibility : 0;
}

size_t guide_visibility_unused(const struct satin_scene *scene,
                               const struct guide_visibility *visibility) {
    if (!visibility || !has_far_light(scene)) return 0;
    const struct light_histogram *h = visibility->histogram;
    const struct light_blocks *blocks = &visibility->blocks;
    const size_t used = blocks->first[blocks->rows] * (sizeof *h->weight + sizeof *h->bin);
    return sizeof visibility->histogram - guide_cells_count(&visibility->cells) * used;
}

void guide_visibility_free(struct guide_visibility *visibility) { free(visibility); }
