// SPDX-License-Identifier: Apache-2.0
// Private to photon_index.cpp, which builds the kd-tree of photons, and photon_index_search.cpp,
// which searches it: the tree in memory.
#ifndef PHOTON_INDEX_TREE_H
#define PHOTON_INDEX_TREE_H

#include <stdint.h>

#include "photon/photon_index.h"

enum {
    PHOTON_INDEX_COLUMNS = 6,  // largest number of columns
    PHOTON_INDEX_LEAF = 16,    // largest number of rows of a leaf
    PHOTON_INDEX_LANES = 4     // rows of a leaf that are compared at once
};

// Nodes are in the order in which FLANN writes the tree: a node, the subtree of its first child,
// that of the second.
struct photon_index_node {
    int32_t column;   // axis that separates the children; -1: a leaf
    uint32_t second;  // index of the second child
    union {
        float low;      // upper limit of the first child
        int32_t begin;  // of a leaf: first row
    };
    union {
        float high;   // lower limit of the second child
        int32_t end;  // of a leaf: end of its rows
    };
};

struct photon_index {
    size_t columns;
    float low[PHOTON_INDEX_COLUMNS], high[PHOTON_INDEX_COLUMNS];  // bounds of the rows
    size_t nodes, rows;
    struct photon_index_node *node;
    int *row;     // in the tree's order
    float *data;  // the rows in the tree's order, those of each leaf column by column, and after
                  // them as many zeros as there are lanes
};

#endif
