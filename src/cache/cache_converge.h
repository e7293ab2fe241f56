// SPDX-License-Identifier: Apache-2.0
// Private to cache/: adaptive caching's points, and the criterion by which their records are judged
// [K05 6.3].
#ifndef CACHE_CONVERGE_H
#define CACHE_CONVERGE_H

#include "cache/cache_records.h"

enum { CACHE_CONTRIBUTIONS = 6 };  // of one point; more are hardly ever there [K05 6.3.2]

// What one record says of a point.
struct cache_contribution {
    uint32_t record;
    uint32_t change;  // of the record when it was last seen to be valid
    float error;      // d / R + sqrt(1 - n . n_i)
    float Y;          // luminance reflected; negative: not yet known
    float noise;      // its standard deviation
};

struct cache_point {
    struct cache_contribution with[CACHE_CONTRIBUTIONS];
    uint8_t count, queued, bare, gives_way;  // the last: mask of contributions
};

struct cache_convergence {
    struct cache *cache;
    const struct cache_fill *fill;  // its sites are the shading points
    enum cache_kind kind;
    struct cache_tree *tree;
    float read_a;
    const struct cache_site **site;  // those of the kind
    struct cache_point *point;
    size_t count;
    uint32_t *change;  // per record: how often its area has shrunk
    float *R, *scale;  // per record, when the pass began
    size_t records;    // then
    size_t capacity[3];
    struct cache_tree news, shrunk;  // areas of the pass: of new records, and of shrunk ones before
};

// Drops contributions whose records have shrunk away from the point, and notes whether it has none
// left at the accuracy of filling.
void cache_judge_revise(const struct cache_convergence *c, const struct cache_site *site,
                        struct cache_point *point);
// Decides which contributions give way.
void cache_judge(const struct cache_convergence *c, const struct cache_site *site,
                 struct cache_point *point);

#endif
