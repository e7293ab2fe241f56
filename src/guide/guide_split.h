// SPDX-License-Identifier: Apache-2.0
// Private to guide/: parting points into halves, again and again (guide_split.c).
#ifndef GUIDE_SPLIT_H
#define GUIDE_SPLIT_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

struct guide_point {
    vec3 p;
    uint32_t item;  // whose place it is
    float key;      // scratch
};

// A plane; points with v3_dot(n, p) < at are below it.
struct guide_plane {
    vec3 n;
    float at;
};

// Puts points[0 .. count / 2) below a border that goes through points[count / 2], and the others
// on it or above; those on it, but for the one, may be on either side. count >= 1.
struct guide_plane guide_split(struct guide_point *points, size_t count);

#endif
