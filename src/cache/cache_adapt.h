// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the shading points of adaptive caching, and the criterion by which their
// records are evaluated [K05 6.3].
#ifndef CACHE_ADAPT_H
#define CACHE_ADAPT_H

#include "cache/cache_records.h"

enum { CACHE_CONTRIBUTIONS = 6 };  // of one point; more are hardly ever there [K05 6.3.2]

// What one record gives to a point.
struct cache_contribution {
    uint32_t record;
    uint32_t change;  // of the record, when the error was computed
    float error;      // d / R + sqrt(1 - n . n_i)
    float Y;          // luminance that the point reflects of it; negative: not yet known
    float noise;      // standard deviation of Y
};

struct cache_point {
    struct cache_contribution with[CACHE_CONTRIBUTIONS];
    uint8_t count;      // of contributions
    uint8_t queued;     // to be evaluated in this pass
    uint8_t bare;       // no record covers it at the accuracy of filling
    uint8_t gives_way;  // mask of the contributions that are to end before the point
};

// The work on one kind of records. Arrays by point or by record.
struct cache_adaptation {
    struct cache *cache;
    const struct cache_fill *fill;  // its sites are the shading points
    enum cache_kind kind;
    struct cache_tree *tree;
    float read_a;                    // accuracy at which the records will be read
    const struct cache_site **site;  // those that want records of the kind
    struct cache_point *point;
    size_t count;
    uint32_t *change;  // per record: how often its area has shrunk
    float *R, *scale;  // per record, when the pass began
    size_t records;    // how many there were then
    size_t capacity[3];
    struct cache_tree news, shrunk;  // areas of the pass: of new records, and of shrunk ones before
};

// Drops contributions of records that have shrunk and no longer serve at the point, and sets
// `bare`.
void cache_update_point(const struct cache_adaptation *c, const struct cache_site *site,
                        struct cache_point *point);
// Decides by the criterion which contributions give way.
void cache_evaluate_point(const struct cache_adaptation *c, const struct cache_site *site,
                          struct cache_point *point);

#endif
