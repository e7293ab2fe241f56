// SPDX-License-Identifier: Apache-2.0
// Median splits of points, for building trees over photons, cells and lights.
#ifndef BASE_MEDIAN_SPLIT_H
#define BASE_MEDIAN_SPLIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"

struct split_point {
    vec3 p;
    uint32_t item;  // the caller's index of the item at this point
    float key;      // overwritten by median_split
};

// A plane. Points with v3_dot(n, p) < at are below it.
struct split_plane {
    vec3 n;
    float at;
};

// A split is preferred to another only if it is better by this factor, which is more than rounding.
#define SPLIT_CLEARLY 1.001f

// Reorders points[0 .. count): the first count / 2 are below a plane through points[count / 2], and
// the others are above it or on it; apart from that one, points on the plane may be on either side.
// count >= 1. The order depends on the points alone. Threads may split different points at once.
struct split_plane median_split(struct split_point *points, size_t count);
// Reorders as median_split does, on all threads. `scratch` has 2 * count entries. False if the pool
// was cancelled: then the points are in any order, or lost.
bool median_split_parallel(struct split_point *points, size_t count, uint32_t *scratch,
                           struct parallel *pool);

#endif
