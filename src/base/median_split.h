// SPDX-License-Identifier: Apache-2.0
// Median splits of points, of which trees over photons, cells and lights are built.
#ifndef BASE_MEDIAN_SPLIT_H
#define BASE_MEDIAN_SPLIT_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

struct split_point {
    vec3 p;
    uint32_t item;  // the caller's number of what is there
    float key;      // overwritten by median_split
};

// A plane; points with v3_dot(n, p) < at are below it.
struct split_plane {
    vec3 n;
    float at;
};

// One split is chosen over another where it is better by this factor: by more than rounding.
#define SPLIT_CLEARLY 1.001f

// Reorders points[0 .. count): the first count / 2 are below a plane through points[count / 2], and
// the others on it or above; those on it, but for that one, may be on either side. count >= 1. The
// order depends on the points alone. Safe for threads that split different points.
struct split_plane median_split(struct split_point *points, size_t count);

#endif
