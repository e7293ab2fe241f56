// SPDX-License-Identifier: Apache-2.0
// Private to photon/: parting points into halves, again and again (photon_halve.c).
#ifndef PHOTON_HALVE_H
#define PHOTON_HALVE_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

struct photon_point {
    vec3 p;
    uint32_t item;  // whose place it is
    float key;      // scratch
};

// A plane; points with v3_dot(n, p) < at are below it.
struct photon_border {
    vec3 n;
    float at;
};

// Puts points[0 .. count / 2) below a border that goes through points[count / 2], and the others
// on it or above; those on it, but for the one, may be on either side. count >= 1.
struct photon_border photon_halve(struct photon_point *points, size_t count);

#endif
