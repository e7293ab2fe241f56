// SPDX-License-Identifier: Apache-2.0
// Private to photon/: the Morton order of the points of a scene, in which photons are sorted.
// Neighbours in that order are neighbours in space, and any range of it is split in two by a plane.
#ifndef PHOTON_MORTON_H
#define PHOTON_MORTON_H

#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"

enum { PHOTON_MORTON_BITS = 30 };  // bits of a key

struct photon_morton {
    vec3 lo;      // corner of the box of all points
    float scale;  // cells per length; there are 1024 along each axis
};

// The key of a point: bits 3 i, 3 i + 1 and 3 i + 2 are bit i of its cell along x, y and z.
uint32_t photon_morton_key(const struct photon_morton *morton, vec3 p);

struct photon_keyed {
    uint32_t key, item;
};

// Sorts by key; items of the same key keep their order. a and b have n entries each, and the one
// with the result is returned. NULL if there is no memory or the pool was cancelled. The order does
// not depend on the number of threads.
struct photon_keyed *photon_morton_sort(struct photon_keyed *a, struct photon_keyed *b, size_t n,
                                        struct parallel *pool);

// A kd-tree whose leaves are cells of few points, split at the planes between cells of the
// Morton order. A node is followed by the subtree of its first child, then by that of the second.
struct photon_morton_node {
    int column;         // axis along which the children are separated; -1: a cell
    uint32_t second;    // index of the second child
    size_t begin, end;  // range of points
};
struct photon_morton_tree {
    struct photon_morton_node *node;
    size_t count, cells;
};

// Splits `count` points, >= 1, in Morton order, until cells have at most `most` points or are cells
// of that order. Point i is at position[i * stride .. + 2]. False if there is no memory; in any
// case the caller frees out->node.
bool photon_morton_split(const struct photon_morton *morton, const float *position, size_t stride,
                         size_t count, size_t most, struct photon_morton_tree *out);

#endif
