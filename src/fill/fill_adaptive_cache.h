// SPDX-License-Identifier: Apache-2.0
// Private to fill/: the shading points of adaptive caching, and the criterion for shrinking
// records [K05 6.3].
#ifndef FILL_ADAPTIVE_CACHE_H
#define FILL_ADAPTIVE_CACHE_H

#include "fill/fill_record.h"

// Contributions of one point. Those beyond it would be read without a test: with 6, which the
// thesis has, the corner of a shadow was blurred over 15 pixels (docs/experiments/cache-errors.md).
// At preview a point has 8 in the mean, 99 % have at most 18.
enum { FILL_CONTRIBUTIONS = 24 };

// The light of one record at a point.
struct fill_contribution {
    uint32_t record;
    uint32_t change;  // `change` of the record when the error was computed
    float error;      // d / R + sqrt(1 - n . n_i)
    float Y;          // luminance that the point reflects of its light; negative: not computed yet
    float noise;      // standard deviation of Y
};

struct fill_point {
    struct fill_contribution with[FILL_CONTRIBUTIONS];
    uint8_t count;       // number of contributions
    uint8_t queued;      // whether it is evaluated in this pass
    uint8_t bare;        // whether no record covers it at the accuracy of filling
    uint32_t shrinking;  // mask of the contributions whose records are to end before the point
};

// The adaptation of one kind of records. Arrays are by point or by record.
struct fill_adaptation {
    struct fill *fill;
    const struct cache *cache;       // of it
    const struct fill_sites *sites;  // the shading points
    enum cache_kind kind;
    struct cache_tree *tree;
    float read_a;                   // accuracy at which the records will be read
    const struct fill_site **site;  // the sites that need records of the kind
    struct fill_point *point;
    size_t count;
    uint32_t *change;  // per record: how often it was shrunk
    float *R, *scale;  // per record: values at the beginning of the pass
    size_t records;    // number of records at the beginning of the pass
    size_t capacity[3];
    struct cache_tree added, shrunk;  // of the pass: discs of new records, and of shrunk ones
                                      // before shrinking
};

// ---- fill_evaluate.c
// Removes contributions of records that were shrunk and no longer cover the point, and sets `bare`.
void fill_update_point(const struct fill_adaptation *c, const struct fill_site *site,
                       struct fill_point *point);
// Selects by the criterion the contributions whose records are to end before the point.
void fill_evaluate_point(const struct fill_adaptation *c, const struct fill_site *site,
                         struct fill_point *point);

#endif
