// SPDX-License-Identifier: Apache-2.0
// Private to photon/: nearest neighbours among rows of floats.
#ifndef PHOTON_INDEX_H
#define PHOTON_INDEX_H

#include <stddef.h>

struct parallel;
struct photon_curve;

struct photon_index;  // a kd-tree over a copy of rows of floats

// `rows` rows of `columns` floats (3 or 6), all finite, rows >= 1. If a curve is given, the rows'
// first three columns are points in its order, and the tree is built on all threads. NULL without
// memory or if the pool was cancelled. The tree does not depend on the number of threads.
struct photon_index *photon_index_new(const float *data, size_t rows, int columns,
                                      const struct photon_curve *curve, struct parallel *pool);
void photon_index_free(struct photon_index *index);  // NULL is allowed
size_t photon_index_bytes(const struct photon_index *index);
// The k nearest rows of `count` queries, of those whose squared distance is less than far2
// (INFINITY: of all): k row numbers and squared distances for each, in no order. Beyond the rows
// there are, rows are -1 and distances INFINITY. A query that is not finite finds nothing.
// Allocates nothing and cannot fail. Safe from many threads.
void photon_index_nearest(const struct photon_index *index, const float *query, size_t count, int k,
                          float far2, int *row, float *distance2);

#endif
