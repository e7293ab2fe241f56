// SPDX-License-Identifier: Apache-2.0
// Selects where caustic paths start. The first surface of a caustic path has a delta lobe and is
// not a pane. A pilot divides each light's unit hypercube of emission into cells, traces a few
// single rays from each and selects the cells where one hit such a surface, and their neighbours.
// The caustic pass starts most of its paths there, with uniform density, so that its photons have
// equal power. The other cells get some paths too, which keeps the estimate unbiased. Light from
// infinity is aimed at the box of the surfaces with delta lobes, which misses none of them. If that
// box is large, as with a pane of glass in front of everything that is seen, light is aimed at what
// is seen (guide_seen.c).
#include <stdlib.h>

#include "base/sampling.h"
#include "guide/guide.h"

enum {
    // Rays of the pilot per cell: a property of its strata, whose number must not be divisible by
    // 7, not
    // a budget. The number of cells is one, and the caller's.
    PILOT_RAYS = 16,
    CELLS_MAX = 1 << 18  // of all lights together; a bound of memory
};
// Fraction of a light's paths that start in cells in which the pilot hit nothing. The power of
// their photons is (1 - fraction) / fraction * (other cells / kept cells) times that of the others:
// with a much smaller fraction, a caustic that the pilot missed would be a few very bright dots.
#define BLIND_FRACTION 0.2f

// The cells of one light: a grid over the unit hypercube.
struct emission_cells {
    uint32_t split[4];  // number of cells along each random number
    uint32_t total, kept;
    uint32_t *cell;  // a permutation: first the `kept` cells, then the others, each in ascending
                     // order
    uint64_t paths;
};

struct guide_emission {
    uint32_t light_count;
    struct emission_cells *light;
    uint32_t *cells;  // cells of all lights
    struct light_aim aim;
};

// ---- The target box -----------------------------------------------------------------------------

// Whether a shape, or a shape of the group of which it is an instance, has a delta lobe.
static bool some_has_delta(const struct satin_scene *scene, uint32_t shape) {
    if (scene->shape[shape].kind != SHAPE_INSTANCE) return scene_shape_has_delta(scene, shape);
    const struct shape_group *group = &scene->group[scene->shape[shape].instance_of];
    for (uint32_t i = group->first; i < group->first + group->count; i++)
        if (scene_shape_has_delta(scene, i)) return true;
    return false;
}

// The box of all surfaces with delta lobes. False if there are none.
static bool find_target(const struct satin_scene *scene, struct light_target *out) {
    struct light_target box = {v3(INFINITY, INFINITY, INFINITY),
                               v3(-INFINITY, -INFINITY, -INFINITY)};
    bool found = false;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->group || !some_has_delta(scene, i)) continue;
        vec3 lo, hi;
        scene_shape_bounds(shape, &lo, &hi);
        box = (struct light_target){v3_min(box.lo, lo), v3_max(box.hi, hi)};
        found = true;
    }
    // No hit is outside of the scene's bounds, which come from the ray tracer.
    *out =
        (struct light_target){v3_max(box.lo, scene->bounds_lo), v3_min(box.hi, scene->bounds_hi)};
    return found;
}

// ---- Cells --------------------------------------------------------------------------------------

// Divides the emission of a light into at most `budget` cells, which are finer along the numbers
// that matter most.
static void split_light(const struct light *light, uint32_t budget, struct emission_cells *cells) {
    bool position =
        light->kind != LIGHT_POINT && light->kind != LIGHT_SPOT && light->kind != LIGHT_PROJECTOR;
    bool direction = light->kind != LIGHT_DIRECTIONAL && light->kind != LIGHT_BEAM;
    for (int k = 0; k < 4; k++) cells->split[k] = 1;
    cells->total = 1;
    // Doubles the numbers of cells in turn, beginning with the directions of an area light.
    for (int step = 0;; step = (step + 1) % 8) {
        static const int order[2][8] = {{2, 3, 2, 3, 0, 1, 2, 3}, {0, 1, 2, 3, 0, 1, 2, 3}};
        int k = order[light->kind != LIGHT_AREA][step];
        if (k < 2 ? !position : !direction) continue;
        if (cells->total * 2 > budget) return;
        cells->split[k] *= 2;
        cells->total *= 2;
    }
}

static void cell_indices(const struct emission_cells *cells, uint32_t cell, uint32_t at[4]) {
    for (int k = 0; k < 4; k++) {
        at[k] = cell % cells->split[k];
        cell /= cells->split[k];
    }
}

static void cell_point(const struct emission_cells *cells, uint32_t cell, float u[4]) {
    uint32_t at[4];
    cell_indices(cells, cell, at);
    for (int k = 0; k < 4; k++) u[k] = sample_stratum((int)at[k], u[k], (int)cells->split[k]);
}

struct emission_pilot {
    const struct satin_scene *scene;
    const struct guide_emission *emission;
    uint64_t seed;
    uint32_t light;
    uint8_t *met;
};

static bool meets_delta(const struct emission_pilot *pilot, const float u[4]) {
    struct light_ray start;
    if (!light_emit(pilot->scene, pilot->light, &pilot->emission->aim, u, &start)) return false;
    return light_makes_caustic(pilot->scene, start.ray);
}

static void trace_pilot_cells(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    const struct emission_pilot *pilot = ctx;
    const struct emission_cells *cells = &pilot->emission->light[pilot->light];
    for (size_t c = begin; c < end; c++) {
        struct rng rng = rng_make(pilot->seed, RNG_GUIDE, (uint64_t)pilot->light << 32 | c);
        for (int i = 0; i < PILOT_RAYS && !pilot->met[c]; i++) {
            // Latin hypercube strata along the first number of each pair.
            float u[4] = {sample_stratum(i, rng_float(&rng), PILOT_RAYS), rng_float(&rng),
                          sample_stratum(i * 7 % PILOT_RAYS, rng_float(&rng), PILOT_RAYS),
                          rng_float(&rng)};
            cell_point(cells, (uint32_t)c, u);
            pilot->met[c] = meets_delta(pilot, u);
        }
    }
}

static bool is_near_met(const struct emission_cells *cells, const uint8_t *met, uint32_t cell) {
    if (met[cell]) return true;
    uint32_t at[4], step = 1;
    cell_indices(cells, cell, at);
    for (int k = 0; k < 4; k++) {
        if (at[k] > 0 && met[cell - step]) return true;
        if (at[k] + 1 < cells->split[k] && met[cell + step]) return true;
        step *= cells->split[k];
    }
    return false;
}

static void sort_cells(struct emission_cells *cells, const uint8_t *met) {
    cells->kept = 0;
    for (uint32_t c = 0; c < cells->total; c++)
        if (is_near_met(cells, met, c)) cells->cell[cells->kept++] = c;
    uint32_t n = cells->kept;
    for (uint32_t c = 0; c < cells->total; c++)
        if (!is_near_met(cells, met, c)) cells->cell[n++] = c;
}

// The fraction of a light's paths that start in the kept cells.
static float kept_fraction(const struct emission_cells *cells) {
    if (cells->kept == 0) return 0.0f;
    return cells->kept == cells->total ? 1.0f : 1.0f - BLIND_FRACTION;
}

// Allocates the paths to the lights by the power that leaves their kept cells, and a tenth of them
// by power.
static void allocate_caustic_paths(const struct satin_scene *scene, uint64_t paths,
                                   struct guide_emission *emission) {
    double kept = 0.0, all = 0.0;
    for (uint32_t i = 0; i < emission->light_count; i++) {
        const struct emission_cells *cells = &emission->light[i];
        kept += (double)scene->light[i].power * cells->kept / cells->total;
        all += (double)scene->light[i].power;
    }
    for (uint32_t i = 0; i < emission->light_count; i++) {
        struct emission_cells *cells = &emission->light[i];
        double power = scene->light[i].power, fraction = power / all;
        if (kept > 0.0) fraction = 0.9 * power * cells->kept / cells->total / kept + 0.1 * fraction;
        uint64_t n = (uint64_t)llround(fraction * (double)paths);
        cells->paths = n > 16 ? n : 16;  // for cells that are kept and for others
    }
}

static struct guide_emission *emission_new(const struct satin_scene *scene, uint32_t most) {
    struct guide_emission *emission = calloc(1, sizeof *emission);
    if (!emission) return NULL;
    uint32_t lights = scene->light_count, budget = CELLS_MAX / lights;
    if (budget > most) budget = most;
    emission->light_count = lights;
    emission->light = calloc(lights, sizeof *emission->light);
    size_t total = 0;
    for (uint32_t i = 0; emission->light && i < lights; i++) {
        split_light(&scene->light[i], budget, &emission->light[i]);
        total += emission->light[i].total;
    }
    emission->cells = malloc((total ? total : 1) * sizeof *emission->cells);
    if (!emission->light || !emission->cells) {
        guide_emission_free(emission);
        return NULL;
    }
    total = 0;
    for (uint32_t i = 0; i < lights; i++) {
        emission->light[i].cell = emission->cells + total;
        total += emission->light[i].total;
    }
    return emission;
}

satin_status guide_emission_build(const struct guide_emission_request *request,
                                  struct parallel *pool, struct log log,
                                  struct guide_emission **out) {
    const struct satin_scene *scene = request->scene;
    struct light_target target;
    if (scene->light_count == 0 || !find_target(scene, &target)) {
        *out = NULL;
        return SATIN_OK;
    }
    satin_status status = SATIN_OK;
    struct guide_emission *emission = emission_new(scene, (uint32_t)request->cells);
    uint8_t *met = malloc(EMISSION_CELLS_MAX);
    if (!emission || !met) status = SATIN_ERROR_MEMORY;
    if (emission) guide_seen_aim(request->seen, target, &emission->aim);
    for (uint32_t i = 0; i < scene->light_count && status == SATIN_OK; i++) {
        struct emission_pilot pilot = {scene, emission, request->seed, i, met};
        for (int c = 0; c < EMISSION_CELLS_MAX; c++) met[c] = 0;
        if (!parallel_for(pool, emission->light[i].total, 64, trace_pilot_cells, &pilot))
            status = SATIN_CANCELLED;
        else
            sort_cells(&emission->light[i], met);
    }
    free(met);
    if (status != SATIN_OK) {
        guide_emission_free(emission);
        if (status == SATIN_ERROR_MEMORY) log_fail(log, status, "not enough memory for caustics");
        return status;
    }
    allocate_caustic_paths(scene, request->paths, emission);
    *out = emission;
    return SATIN_OK;
}

void guide_emission_free(struct guide_emission *emission) {
    if (!emission) return;
    free(emission->light);
    free(emission->cells);
    free(emission);
}

uint64_t guide_emission_paths(const struct guide_emission *emission, uint32_t light) {
    return emission->light[light].paths;
}

const struct light_aim *guide_emission_aim(const struct guide_emission *emission) {
    return &emission->aim;
}

// The first paths go to the kept cells and the others to the rest, in the order of the cells. x
// runs uniformly over them: its integer part is the cell and its fraction the position along the
// cell's first number. Together with the other numbers of the sequence, a net fills each cell.
float guide_emission_warp(const struct guide_emission *emission, uint32_t light, uint64_t index,
                          float u[4]) {
    const struct emission_cells *cells = &emission->light[light];
    uint64_t to_kept = (uint64_t)llround((double)kept_fraction(cells) * (double)cells->paths);
    bool kept = index < to_kept;
    uint64_t n = kept ? to_kept : cells->paths - to_kept, j = kept ? index : index - to_kept;
    uint32_t first = kept ? 0 : cells->kept,
             count = kept ? cells->kept : cells->total - cells->kept;
    double x = ((double)j + (double)u[0]) * (double)count / (double)n;
    uint32_t i = x < (double)count ? (uint32_t)x : count - 1;
    u[0] = (float)(x - (double)i);
    cell_point(cells, cells->cell[first + i], u);
    return (float)((double)count / cells->total * (double)cells->paths / (double)n);
}
