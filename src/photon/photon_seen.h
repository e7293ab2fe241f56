// SPDX-License-Identifier: Apache-2.0
// Private to photon/: what is seen of the lights from cells of places (photon_seen.c), and the
// cells (photon_cells.c).
#ifndef PHOTON_SEEN_H
#define PHOTON_SEEN_H

#include "photon/photon_halve.h"
#include "photon/photon_map.h"

// ---- Cells ------------------------------------------------------------------------------------

enum { PHOTON_CELLS_DEPTH = 10, PHOTON_CELLS_MAX = 1 << PHOTON_CELLS_DEPTH };

struct photon_cell_point {
    vec3 p, ng, n;  // geometric and shading normal
    bool both;      // lit from behind as well
};

struct photon_cell {
    const struct photon_cell_point *point;
    size_t count;
};

struct photon_cells {
    int depth;                                     // of the tree; the cells are its leaves
    struct photon_border split[PHOTON_CELLS_MAX];  // of node i; 2 i + 1 is below it, 2 i + 2 above
    struct photon_cell cell[PHOTON_CELLS_MAX];
    struct photon_cell_point *point;  // by malloc
};

static inline size_t photon_cells_count(const struct photon_cells *cells) {
    return (size_t)1 << cells->depth;
}
// Cells without points if paths from the eye meet nothing. False without memory. The caller frees
// `point`.
bool photon_cells_make(const struct satin_scene *scene, uint64_t seed, struct photon_cells *out);
// The cell that p falls into.
size_t photon_cells_find(const struct photon_cells *cells, vec3 p);

// ---- What is seen -----------------------------------------------------------------------------

struct photon_seen {
    struct photon_cells cells;
    bool sky, choice;  // whether windows, or shares of the lights, were learned
    struct light_window window[PHOTON_CELLS_MAX];
    float cdf[PHOTON_CELLS_MAX][LIGHT_WINDOW_BINS + 1];
    float share[PHOTON_CELLS_MAX][LIGHT_WEIGHED_MAX];
};

#endif
