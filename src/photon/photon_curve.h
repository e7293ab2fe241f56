// SPDX-License-Identifier: Apache-2.0
// Private to photon/: the Morton curve through a scene, along which photons are sorted. Neighbours
// on the curve are neighbours in space, and any range of it is split in two by a plane.
#ifndef PHOTON_CURVE_H
#define PHOTON_CURVE_H

#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"

enum { PHOTON_CURVE_BITS = 30 };  // bits of a key

struct photon_curve {
    vec3 lo;      // corner of the box that the curve fills
    float scale;  // cells per length; there are 1024 along each axis
};

// The key of a point: bits 3 i, 3 i + 1 and 3 i + 2 are bit i of its cell along x, y and z.
uint32_t photon_curve_key(const struct photon_curve *curve, vec3 p);

struct photon_keyed {
    uint32_t key, item;
};

// Sorts by key; items of the same key keep their order. a and b have n entries each, and the one
// with the result is returned. NULL if there is no memory or the pool was cancelled. The order does
// not depend on the number of threads.
struct photon_keyed *photon_curve_sort(struct photon_keyed *a, struct photon_keyed *b, size_t n,
                                       struct parallel *pool);

// A kd-tree whose leaves are cells of few points, split at the planes of the curve. A node is
// followed by the subtree of its first child, then by that of the second.
struct photon_curve_node {
    int column;         // axis along which the children are separated; -1: a cell
    uint32_t second;    // index of the second child
    size_t begin, end;  // range of points
};
struct photon_curve_tree {
    struct photon_curve_node *node;
    size_t count, cells;
};

// Splits `count` points, >= 1, in the order of the curve, until cells have at most `most` points or
// are cells of the curve. Point i is at position[i * stride .. + 2]. False if there is no memory;
// in any case the caller frees out->node.
bool photon_curve_split(const struct photon_curve *curve, const float *position, size_t stride,
                        size_t count, size_t most, struct photon_curve_tree *out);

#endif
