// SPDX-License-Identifier: Apache-2.0
// The region of the scene that is seen: a few paths from the eye give points, a tree divides these
// into cells of equal numbers, and the region is the box around the points of each cell.
#include <stdlib.h>

#include "guide/guide_cells.h"

// By how much of its size a box is larger than that of its points, on each side: of n points in an
// interval the outermost ones are 1 / (n + 1) of its length from its ends, and a cell has 16.
#define BOX_MARGIN 0.06f

struct guide_region {
    struct guide_cells cells;
    struct light_target box[GUIDE_CELLS_MAX];
};

static struct light_target box_of(const struct guide_cell *cell) {
    vec3 lo = v3(INFINITY, INFINITY, INFINITY), hi = v3_neg(lo);
    for (size_t i = 0; i < cell->count; i++) {
        lo = v3_min(lo, cell->point[i].p);
        hi = v3_max(hi, cell->point[i].p);
    }
    const vec3 size = v3_sub(hi, lo);
    const float margin = BOX_MARGIN * fmaxf(size.x, fmaxf(size.y, size.z));
    const vec3 more = v3(margin, margin, margin);
    return (struct light_target){v3_sub(lo, more), v3_add(hi, more)};
}

bool guide_region_make(const struct satin_scene *scene, uint64_t seed, int paths,
                       struct parallel *pool, struct guide_region **out) {
    struct guide_region *region = calloc(1, sizeof *region);
    if (!region || !guide_cells_make(scene, seed, paths, 0, pool, &region->cells)) {
        free(region);
        return false;
    }
    for (size_t i = 0; i < guide_cells_count(&region->cells); i++)
        region->box[i] = box_of(&region->cells.cell[i]);
    *out = region;
    return true;
}

void guide_region_free(struct guide_region *region) {
    if (!region) return;
    free(region->cells.point);
    free(region);
}

bool guide_region_holds(const struct guide_region *region, vec3 p) {
    const struct light_target *box = &region->box[guide_cells_find(&region->cells, p)];
    return v3_within(p, box->lo, box->hi);
}
