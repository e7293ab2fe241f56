// SPDX-License-Identifier: Apache-2.0
// Vectors of directions and of values that belong to them, for the kernels that process many.
#ifndef RSH_DIRECTIONS_H
#define RSH_DIRECTIONS_H

#include <math.h>
#include <stddef.h>

#include "rsh/rsh_vector.h"

struct directions {
    vf x, y, z;
};

// Loads `keep` directions; the other lanes get the pole.
INLINE struct directions load_directions(const float *const d[3], size_t first, size_t keep) {
    float tail[3][W];
    if (keep >= W)
        return (struct directions){load(d[0] + first), load(d[1] + first), load(d[2] + first)};
    for (int i = 0; i < W; i++)
        for (int a = 0; a < 3; a++)
            tail[a][i] = (size_t)i < keep ? d[a][first + (size_t)i] : (float)(a == 2);
    return (struct directions){load(tail[0]), load(tail[1]), load(tail[2])};
}

// Loads `keep` values; the other lanes get 0.
INLINE vf load_values(const float *value, size_t first, size_t keep) {
    if (keep >= W) return load(value + first);
    float tail[W] = {0};
    memcpy(tail, value + first, keep * sizeof *tail);
    return load(tail);
}

// Clamps the height to [0, 1] and maps it to 2 z - 1. Returns 2 sqrt(z / (1 + z)), which scales the
// hemisphere's x and y to the sphere's, as in rsh_eval.
INLINE vf stretch_height(vf *height) {
    float z[W], s[W];
    store(z, *height);
    for (int i = 0; i < W; i++) {
        z[i] = z[i] > 0.0f ? z[i] : 0.0f;
        z[i] = z[i] < 1.0f ? z[i] : 1.0f;
        s[i] = 2.0f * sqrtf(z[i] / (1.0f + z[i]));
    }
    *height = load(z);
    return load(s);
}

// (x + i y)^m, a direction per lane.
struct azimuth {
    vf c, s;
};

INLINE struct azimuth azimuth_of(vf c, vf s) { return (struct azimuth){c, s}; }

INLINE struct azimuth azimuth_add(struct azimuth a, struct azimuth b) {
    return (struct azimuth){a.c * b.c - a.s * b.s, a.c * b.s + a.s * b.c};
}

// The difference of squares is more accurate than the product of sum and difference, and the
// functions show m times its error.
INLINE struct azimuth azimuth_double(struct azimuth a) {
    return (struct azimuth){a.c * a.c - a.s * a.s, (a.c + a.c) * a.s};
}

// Stores functions (l, -m) and (l, m): the Legendre function p times the components of the azimuth.
INLINE void put_pair(float *out, size_t shift, vf p, struct azimuth a) {
    if (shift) store(out - shift, p * a.s);
    store(out + shift, p * a.c);
}

#endif
