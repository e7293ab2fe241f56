// SPDX-License-Identifier: Apache-2.0
// Private to photon/: nearest-neighbour search among rows of floats.
#ifndef PHOTON_INDEX_H
#define PHOTON_INDEX_H

#include <stddef.h>

struct parallel;
struct photon_morton;

struct photon_index;  // a kd-tree over a copy of rows of floats

// Builds an index of `rows` >= 1 rows of `columns` floats (3 or 6), all finite. If `morton` is
// not NULL, the first three columns are points in its order, and the tree is built on all threads.
// NULL if there is no memory or the pool was cancelled. The tree does not depend on the number of
// threads.
struct photon_index *photon_index_new(const float *data, size_t rows, int columns,
                                      const struct photon_morton *morton, struct parallel *pool);
void photon_index_free(struct photon_index *index);  // NULL is allowed
size_t photon_index_bytes(const struct photon_index *index);
// photon_index_search.cpp: finds the k nearest rows of `count` queries, among those with a squared
// distance below far2 (INFINITY: all): k row numbers and squared distances for each query, in no
// particular order. Missing ones have row -1 and distance INFINITY. A query that is not finite
// finds nothing. Allocates nothing and cannot fail. Thread-safe.
void photon_index_nearest(const struct photon_index *index, const float *query, size_t count, int k,
                          float far2, int *row, float *distance2);
// Finds all rows whose squared distance from a query is below r2, or the `most` nearest of them, in
// no particular order. Returns their number; otherwise as photon_index_nearest.
int photon_index_within(const struct photon_index *index, const float *query, int most, float r2,
                        int *row, float *distance2);

#endif
