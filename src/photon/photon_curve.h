// SPDX-License-Identifier: Apache-2.0
// Private to photon/: the Morton curve through a scene, along which photons are sorted. Neighbours
// on the curve are neighbours in space, and any range of it falls into two at a plane.
#ifndef PHOTON_CURVE_H
#define PHOTON_CURVE_H

#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"

enum { PHOTON_CURVE_BITS = 30 };  // of a key

struct photon_curve {
    vec3 lo;      // corner of the box that the curve fills
    float scale;  // cells per length; 1024 along each axis
};

// The key of a point: bits 3 i, 3 i + 1 and 3 i + 2 are bit i of its cell along x, y and z.
uint32_t photon_curve_key(const struct photon_curve *curve, vec3 p);

struct photon_keyed {
    uint32_t key, item;
};

// Sorts by key, items of the same key in the order that they had, between the arrays a and b of n
// entries each; the result is in the one that is returned. NULL without memory or if the pool was
// cancelled. The order does not depend on the number of threads.
struct photon_keyed *photon_curve_sort(struct photon_keyed *a, struct photon_keyed *b, size_t n,
                                       struct parallel *pool);

// A kd-tree above cells of few points, by the planes that the curve has. Nodes stand before their
// first child with all below it, then comes the second.
struct photon_curve_node {
    int column;         // across which the children are apart; -1: a cell
    uint32_t second;    // node of the second child
    size_t begin, end;  // points
};
struct photon_curve_tree {
    struct photon_curve_node *node;
    size_t count, cells;
};

// Splits `count` points, >= 1, in the order of the curve, until cells have `most` points or are
// cells of the curve itself. Point i is at position[i * stride .. + 2]. False without memory; the
// caller frees out->node either way.
bool photon_curve_split(const struct photon_curve *curve, const float *position, size_t stride,
                        size_t count, size_t most, struct photon_curve_tree *out);

#endif
