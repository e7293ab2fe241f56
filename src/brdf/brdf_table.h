// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: the nodes of a table of harmonics. brdf_table_build.c fills them, with
// brdf_table_stencil.c, and brdf_table.c reads them.
#ifndef BRDF_TABLE_H
#define BRDF_TABLE_H

#include "brdf/brdf.h"

enum { TABLE_ORDER_MAX = 14, TABLE_VALUES_MAX = 3 * TABLE_ORDER_MAX * TABLE_ORDER_MAX };

struct brdf_table {
    bool isotropic;
    rsh_basis basis;
    int max_order, channels;
    int side;        // nodes along the radius or a side of the quadrant
    size_t nodes;    // side or side^2
    size_t stride;   // coefficients of one channel of one node
    size_t values;   // coefficients of one node
    float *c;        // [nodes][channels][stride]
    uint8_t *order;  // [nodes]; 0: the error exceeds the bound
};

// The distance of nodes in the map. They begin at the centre, and the last one is half a step
// before the boundary, where some models are infinite.
static inline float brdf_table_step(const struct brdf_table *t) {
    return 1.0f / ((float)t->side - 0.5f);
}

// Where a node is in the map, in distances of nodes; j is 0 along the radius.
struct table_position {
    int i, j;
};

static inline struct table_position brdf_table_position(const struct brdf_table *t, size_t node) {
    return (struct table_position){(int)(node % (size_t)t->side), (int)(node / (size_t)t->side)};
}

// Whether a cell that touches the disk has this node as a corner.
static inline bool brdf_table_in_use(const struct brdf_table *t, struct table_position at) {
    const float p = at.i ? (float)(at.i - 1) : 0.0f, q = at.j ? (float)(at.j - 1) : 0.0f;
    return t->isotropic || sqrtf(p * p + q * q) * brdf_table_step(t) < 1.0f;
}

// Whether the node is within the disk. The others repeat its boundary.
static inline bool brdf_table_in_disk(const struct brdf_table *t, struct table_position at) {
    return at.i * at.i + at.j * at.j <= (t->side - 1) * (t->side - 1);
}

// ---- While a table is built ---------------------------------------------------------------------

// A table is built in grids: that of step s are the nodes at multiples of s that are not at
// multiples of 2 s.
struct table_nodes {
    const struct brdf_table *table;
    int step;        // of the current grid; nodes of the coarser ones are projected, interpolated
                     // or skipped
    float *norm;     // [nodes], squared norm of the lobe; 0: the coefficients are not known
    float *error;    // [nodes], of interpolation from the coarser grids, relative to the norm
    float *sign[4];  // [stride], factors of the coefficients of a lobe mirrored in x (bit 0) and in
                     // y (bit 1)
};

enum { TABLE_STENCIL_MAX = 16 };

// The nodes of coarser grids between which a node is interpolated, and their weights.
struct table_stencil {
    int count;      // those that are in use
    bool complete;  // whether the coefficients of all are known
    bool refused;   // whether none of them is represented within the error bound
    size_t node[TABLE_STENCIL_MAX];
    float weight[TABLE_STENCIL_MAX];
    int mirror[TABLE_STENCIL_MAX];  // index of table_nodes.sign
};

void brdf_table_signs(const struct table_nodes *nodes);
struct table_stencil brdf_table_stencil(const struct table_nodes *nodes, struct table_position at);
// Interpolates the coefficients [channels][stride], and returns the squared norm.
float brdf_table_interpolate(const struct table_nodes *nodes, const struct table_stencil *from,
                             float *c);
// The error that is expected of an interpolation, by those of the next coarser grid. INFINITY if
// it is not known.
float brdf_table_expected_error(const struct table_nodes *nodes, const struct table_stencil *from);

#endif
