// SPDX-License-Identifier: Apache-2.0
// Private to guide/: the visibility of the lights from cells of points (guide_visibility.c).
#ifndef GUIDE_VISIBILITY_H
#define GUIDE_VISIBILITY_H

#include "guide/guide_cells.h"

// ---- The box of the histograms (guide_box.c) ---------------------------------------------------

// Finds the box in whose bins the visibility of the environment is most alike from all points, by
// so many rays from them, or a few times as many. *arriving is set to the fraction of them that
// leave the scene. The result does not depend on the threads of the pool. SATIN_CANCELLED or
// SATIN_ERROR_MEMORY.
satin_status guide_box_find(const struct satin_scene *scene, uint64_t seed,
                            const struct guide_cells *cells, size_t rays, struct parallel *pool,
                            struct light_box *out, float *arriving);

// The distance from a point in the box along w to where that leaves the box.
float guide_box_exit(const struct light_box *box, vec3 p, vec3 w);

// ---- Openings (guide_openings.c) ----------------------------------------------------------------

// Makes the openings, which are bins of the box, and the aim at them. By weights, one bin gets more
// rays per area than another. aim->openings stays NULL if they are not small beside the scene.
void guide_openings_make(const struct satin_scene *scene, const struct light_box *box,
                         const float weight[LIGHT_HISTOGRAM_BINS], struct light_openings *openings,
                         struct light_aim *aim);

// Finds the bins by which light from infinitely far comes into the box (guide_openings_unseen.c),
// by `paths` paths that these lights start towards it, and sets their weights; those of the others
// are 0. The result does not depend on the threads of the pool. SATIN_CANCELLED or
// SATIN_ERROR_MEMORY.
satin_status guide_openings_unseen(const struct satin_scene *scene, uint64_t seed,
                                   const struct light_box *box, size_t paths, struct parallel *pool,
                                   float weight[LIGHT_HISTOGRAM_BINS]);

// ---- What is visible ---------------------------------------------------------------------------

// What was measured in each cell.
struct guide_visibility {
    struct guide_cells cells;
    int paths;         // from the eye, by which the cells were made
    bool small;        // whether openings are so small that hardly any ray from the cells leaves
    bool sky, choice;  // whether histograms, and whether fractions of the lights, were measured
    struct light_box box;
    struct light_openings openings;  // of this box
    struct light_aim aim;            // at them
    struct light_blocks blocks;
    struct light_histogram histogram[GUIDE_CELLS_MAX];
    float visible[GUIDE_CELLS_MAX][LIGHT_WEIGHTS_MAX];  // visible fraction of each light's
                                                        // estimate; > 0
};

// ---- The environment (guide_sky.c) --------------------------------------------------------------

// Measures what the cells see of the environment through the bins of the box, both of which must be
// known, and sets the histograms, the openings and the aim. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status guide_sky_learn(const struct satin_scene *scene, uint64_t seed,
                             struct guide_visibility_samples samples, struct parallel *pool,
                             struct guide_visibility *visibility);
// The fraction of the samples of the environment that the bins of a cell's histogram should draw,
// in [0, .9], by a few samples at its points (guide_sky_fraction.c). The histogram's own must be >
// 0. *left is set to the second moment of light with that, over that of samples by radiance
// alone, in [0, 1]; or to 0, if none of the samples arrived.
float guide_sky_fraction(const struct satin_scene *scene, const struct guide_cell *cell,
                         const struct light_histogram *histogram, struct rng *rng, float *left);
// The most bytes that guide_sky_learn takes.
double guide_sky_most(const struct satin_scene *scene);

#endif
