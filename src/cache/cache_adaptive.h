// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the shading points of adaptive caching, and the criterion for shrinking
// records [K05 6.3].
#ifndef CACHE_ADAPTIVE_H
#define CACHE_ADAPTIVE_H

#include "cache/cache_records.h"

enum { CACHE_CONTRIBUTIONS = 6 };  // of one point; there are rarely more [K05 6.3.2]

// The light of one record at a point.
struct cache_contribution {
    uint32_t record;
    uint32_t change;  // `change` of the record when the error was computed
    float error;      // d / R + sqrt(1 - n . n_i)
    float Y;          // luminance that the point reflects of its light; negative: not computed yet
    float noise;      // standard deviation of Y
};

struct cache_point {
    struct cache_contribution with[CACHE_CONTRIBUTIONS];
    uint8_t count;      // number of contributions
    uint8_t queued;     // whether it is evaluated in this pass
    uint8_t bare;       // whether no record covers it at the accuracy of filling
    uint8_t shrinking;  // mask of the contributions whose records are to end before the point
};

// The adaptation of one kind of records. Arrays are by point or by record.
struct cache_adaptation {
    struct cache *cache;
    const struct cache_fill *fill;  // its sites are the shading points
    enum cache_kind kind;
    struct cache_tree *tree;
    float read_a;                    // accuracy at which the records will be read
    const struct cache_site **site;  // the sites that need records of the kind
    struct cache_point *point;
    size_t count;
    uint32_t *change;  // per record: how often it was shrunk
    float *R, *scale;  // per record: values at the beginning of the pass
    size_t records;    // number of records at the beginning of the pass
    size_t capacity[3];
    struct cache_tree added, shrunk;  // of the pass: discs of new records, and of shrunk ones
                                      // before shrinking
};

// Removes contributions of records that were shrunk and no longer cover the point, and sets `bare`.
void cache_update_point(const struct cache_adaptation *c, const struct cache_site *site,
                        struct cache_point *point);
// Selects by the criterion the contributions whose records are to end before the point.
void cache_evaluate_point(const struct cache_adaptation *c, const struct cache_site *site,
                          struct cache_point *point);

#endif
