// SPDX-License-Identifier: Apache-2.0
// Private to guide/: the visibility of the lights from cells of points (guide_visibility.c), and
// the cells (guide_cells.c).
#ifndef GUIDE_VISIBILITY_H
#define GUIDE_VISIBILITY_H

#include "base/median_split.h"
#include "guide/guide.h"

// ---- Cells ------------------------------------------------------------------------------------

enum { GUIDE_CELLS_DEPTH = 10, GUIDE_CELLS_MAX = 1 << GUIDE_CELLS_DEPTH };

// A point on a path from the eye.
struct guide_cell_point {
    vec3 p, ng, n;  // geometric and shading normal
    bool both;      // whether it is also lit from behind
};

// The points of one cell.
struct guide_cell {
    const struct guide_cell_point *point;
    size_t count;
};

// The tree of cells; its leaves are the cells.
struct guide_cells {
    int depth;                                  // depth of the tree
    struct split_plane split[GUIDE_CELLS_MAX];  // of node i, whose children are 2 i + 1 below and 2
                                                // i + 2 above it
    struct guide_cell cell[GUIDE_CELLS_MAX];
    struct guide_cell_point *point;  // from malloc
};

static inline size_t guide_cells_count(const struct guide_cells *cells) {
    return (size_t)1 << cells->depth;
}
// Makes the cells from this many paths, without points if paths from the eye hit nothing. False if
// there is no memory. The caller frees `point`. Threads as for guide_seen_make.
bool guide_cells_make(const struct satin_scene *scene, uint64_t seed, int paths,
                      struct parallel *pool, struct guide_cells *out);
// The index of the cell of p.
size_t guide_cells_find(const struct guide_cells *cells, vec3 p);

// ---- The box of the histograms (guide_box.c) ---------------------------------------------------

// Finds the box in whose bins the visibility of the environment, which must exist, is most alike
// from all points, by so many rays from them. The result does not depend on the threads of the
// pool. False if there is no memory or the pool was stopped.
bool guide_box_find(const struct satin_scene *scene, uint64_t seed, const struct guide_cells *cells,
                    size_t rays, struct parallel *pool, struct light_box *out);

// ---- What is visible ---------------------------------------------------------------------------

// What was measured in each cell.
struct guide_visibility {
    struct guide_cells cells;
    bool sky, choice;  // whether histograms, and whether fractions of the lights, were measured
    struct light_box box;
    struct light_histogram histogram[GUIDE_CELLS_MAX];
    struct light_bins bins[GUIDE_CELLS_MAX];
    float visible[GUIDE_CELLS_MAX][LIGHT_WEIGHTS_MAX];  // visible fraction of each light's
                                                        // estimate; > 0
};

#endif
