// SPDX-License-Identifier: Apache-2.0
// Private to guide/: cells of points on paths from the eye (guide_cells.c).
#ifndef GUIDE_CELLS_H
#define GUIDE_CELLS_H

#include "base/median_split.h"
#include "guide/guide.h"

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
// The largest number of bounces of a path, after which gather rays sample direct light.
enum { GUIDE_CELL_BOUNCES = 2 };
// Makes the cells from the points of this many paths of so many bounces, without points if paths
// from the eye hit nothing. False if there is no memory. The caller frees `point`. Threads as for
// guide_seen_make.
bool guide_cells_make(const struct satin_scene *scene, uint64_t seed, int paths, int bounces,
                      struct parallel *pool, struct guide_cells *out);
// The index of the cell of p.
size_t guide_cells_find(const struct guide_cells *cells, vec3 p);

#endif
