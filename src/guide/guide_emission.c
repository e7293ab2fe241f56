// SPDX-License-Identifier: Apache-2.0
// Learns where caustic paths start. The paths of a pilot start uniformly over each light's unit
// hypercube of emission, and show from where photons come that light visible caustics. A tree
// divides the hypercube by halves into cells, so that it is fine where that changes. The density
// of paths in a cell is that of the least variance for their time. A fraction of all paths is
// allocated by power, and each cell gets one, which keeps the estimate unbiased. Emission is aimed
// at the surfaces that can cause caustics (guide_aim.c).
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "guide/guide.h"

// Least number of the pilot's paths in a cell. With 8, 32 and 128, caustics of a glass ball at 2 s
// have a variance of .00044, .00041 and .00037.
enum { CELL_PATHS = 128 };

// Fraction of the paths that are allocated by power alone. Their photons may have many times the
// power of the others: with a much smaller fraction, a caustic that the pilot missed would be a few
// very bright dots.
#define BLIND_FRACTION 0.2f

// The time of storing a photon, which includes that of its estimate, over that of tracing a path,
// as measured in a bathroom with lamps in bulbs of glass.
static const double STORING = 4.0;

// A box in the unit hypercube of a light's emission.
struct emission_cell {
    float lo[4], hi[4];
    float volume;
    float density;  // of paths, relative to other cells
    double end;     // fraction of all paths that start in this cell or in one before
};

struct guide_emission {
    uint32_t light_count;
    size_t *first;  // light_count + 1: index of the first cell of each light
    struct emission_cell *cell;
    size_t cell_count, capacity;
    struct light_aim aim;
};

// ---- Cells --------------------------------------------------------------------------------------

// What the pilot has found in a box: the numbers of its paths and of those that stored photons that
// are seen, and the sum of the squared powers of these.
struct emission_found {
    size_t paths, seen;
    double squares;
};

static void count_sample(struct emission_found *found, const struct guide_emission_sample *sample) {
    found->paths++;
    found->seen += sample->power > 0.0f;
    found->squares += (double)sample->power * (double)sample->power;
}

static struct emission_found find_in(const struct guide_emission_sample *sample, size_t count) {
    struct emission_found found = {0};
    for (size_t i = 0; i < count; i++) count_sample(&found, &sample[i]);
    return found;
}

// The density of paths with the least variance for the time of tracing and storing, n paths of
// which take n (1 + STORING p): the root of the mean square over that of this time. A box gets one
// seen path more than was found, since where none was found there may be some.
static double density_of(struct emission_found found, double square) {
    const double paths = (double)found.paths + 1.0, p = ((double)found.seen + 1.0) / paths;
    return sqrt((found.squares + square) / paths / (1.0 + STORING * p));
}

// The error that the paths of a box leave per volume, if there are as many as by its density: their
// density times the time of each.
static double cost_of(struct emission_found found, double square) {
    const double p = ((double)found.seen + 1.0) / ((double)found.paths + 1.0);
    return density_of(found, square) * (1.0 + STORING * p);
}

// The cost of both halves along number k. INFINITY if a half is empty.
static double halves(const struct guide_emission_sample *sample, size_t count, int k, float middle,
                     double square) {
    struct emission_found found[2] = {{0}};
    for (size_t i = 0; i < count; i++) count_sample(&found[sample[i].u[k] >= middle], &sample[i]);
    if (!found[0].paths || !found[1].paths) return INFINITY;
    return 0.5 * (cost_of(found[0], square) + cost_of(found[1], square));
}

// Moves the samples below the middle to the front and returns their number.
static size_t partition_samples(struct guide_emission_sample *sample, size_t count, int k,
                                float middle) {
    size_t below = 0;
    for (size_t i = 0; i < count; i++) {
        if (sample[i].u[k] >= middle) continue;
        const struct guide_emission_sample moved = sample[i];
        sample[i] = sample[below];
        sample[below++] = moved;
    }
    return below;
}

static bool add_cell(struct guide_emission *emission, const struct emission_cell *cell) {
    void *items = emission->cell;
    if (!array_reserve(&items, &emission->capacity, emission->cell_count + 1, sizeof *cell))
        return false;
    emission->cell = items;
    emission->cell[emission->cell_count++] = *cell;
    return true;
}

// Divides a box with its samples down to cells, each along the number by which its halves differ
// most. `square` is the mean squared power of photons of the light that are seen.
static bool divide(struct guide_emission *emission, struct emission_cell box,
                   struct guide_emission_sample *sample, size_t count, double square) {
    const struct emission_found found = find_in(sample, count);
    box.density = (float)density_of(found, square);
    int best = 0;
    double least = INFINITY;
    for (int k = 0; k < 4 && count >= 2 * CELL_PATHS && found.seen > 0; k++) {
        const double cost = halves(sample, count, k, 0.5f * (box.lo[k] + box.hi[k]), square);
        if (cost < least) {
            least = cost;
            best = k;
        }
    }
    if (least == INFINITY) return add_cell(emission, &box);
    const float middle = 0.5f * (box.lo[best] + box.hi[best]);
    const size_t below = partition_samples(sample, count, best, middle);
    struct emission_cell half[2] = {box, box};
    half[0].hi[best] = half[1].lo[best] = middle;
    half[0].volume = half[1].volume = 0.5f * box.volume;
    return divide(emission, half[0], sample, below, square) &&
           divide(emission, half[1], sample + below, count - below, square);
}

static bool divide_light(struct guide_emission *emission, struct guide_emission_sample *sample,
                         size_t count) {
    const struct emission_cell all = {.hi = {1.0f, 1.0f, 1.0f, 1.0f}, .volume = 1.0f};
    const struct emission_found found = find_in(sample, count);
    const double square = found.seen ? found.squares / (double)found.seen : 0.0;
    return divide(emission, all, sample, count, square);
}

// ---- Paths --------------------------------------------------------------------------------------

// Sets the ends of all cells.
static void allocate_caustic_paths(const struct satin_scene *scene,
                                   struct guide_emission *emission) {
    double learnt = 0.0, power = 0.0, end = 0.0;
    for (uint32_t i = 0; i < emission->light_count; i++) power += (double)scene->light[i].power;
    for (size_t j = 0; j < emission->cell_count; j++)
        learnt += (double)(emission->cell[j].volume * emission->cell[j].density);
    const double blind = learnt > 0.0 ? (double)BLIND_FRACTION : 1.0;
    for (uint32_t i = 0; i < emission->light_count; i++)
        for (size_t j = emission->first[i]; j < emission->first[i + 1]; j++) {
            struct emission_cell *cell = &emission->cell[j];
            const double fraction = power > 0.0 ? (double)scene->light[i].power / power
                                                : 1.0 / (double)emission->light_count;
            end += blind * (double)cell->volume * fraction;
            if (learnt > 0.0)
                end += (1.0 - blind) * (double)(cell->volume * cell->density) / learnt;
            cell->end = end;
        }
}

satin_status guide_emission_learn(const struct guide_emission_pilot *pilot, struct log log,
                                  struct guide_emission **out) {
    const struct satin_scene *scene = pilot->scene;
    struct guide_emission *emission = calloc(1, sizeof *emission);
    bool made = emission != NULL;
    if (made) {
        emission->aim = pilot->aim;
        emission->light_count = scene->light_count;
        emission->first = array_new((size_t)scene->light_count + 1, sizeof *emission->first);
        made = emission->first != NULL;
    }
    for (uint32_t i = 0; i < scene->light_count && made; i++) {
        made = divide_light(emission, pilot->sample + i * pilot->per_light, pilot->per_light);
        emission->first[i + 1] = emission->cell_count;
    }
    if (!made) {
        guide_emission_free(emission);
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for caustics");
    }
    allocate_caustic_paths(scene, emission);
    *out = emission;
    return SATIN_OK;
}

void guide_emission_free(struct guide_emission *emission) {
    if (!emission) return;
    free(emission->first);
    free(emission->cell);
    free(emission);
}

// The index of the first path after those of a number of cells: one for each cell, and the others
// by their fractions.
static uint64_t paths_before(const struct guide_emission *emission, uint64_t paths, size_t cells) {
    const uint64_t more = paths > emission->cell_count ? paths - emission->cell_count : 0;
    const double end = cells ? emission->cell[cells - 1].end : 0.0;
    return (uint64_t)cells + (uint64_t)llround(fmin(end, 1.0) * (double)more);
}

uint64_t guide_emission_paths(const struct guide_emission *emission, uint64_t paths,
                              uint32_t light) {
    return paths_before(emission, paths, emission->first[light + 1]) -
           paths_before(emission, paths, emission->first[light]);
}

const struct light_aim *guide_emission_aim(const struct guide_emission *emission) {
    return &emission->aim;
}

// The paths of a cell are consecutive, so their numbers, from a net, fill it evenly.
float guide_emission_warp(const struct guide_emission *emission, uint64_t paths, uint32_t light,
                          uint64_t index, float u[4]) {
    size_t lo = emission->first[light], hi = emission->first[light + 1];
    const uint64_t first = paths_before(emission, paths, lo),
                   count = paths_before(emission, paths, hi) - first;
    while (hi - lo > 1) {
        const size_t middle = lo + (hi - lo) / 2;
        if (paths_before(emission, paths, middle) <= first + index)
            lo = middle;
        else
            hi = middle;
    }
    const struct emission_cell *cell = &emission->cell[lo];
    for (int k = 0; k < 4; k++)
        u[k] = fminf(cell->lo[k] + u[k] * (cell->hi[k] - cell->lo[k]), SAMPLE_BELOW_ONE);
    const uint64_t own = paths_before(emission, paths, lo + 1) - paths_before(emission, paths, lo);
    return (float)((double)cell->volume * (double)count / (double)own);
}
