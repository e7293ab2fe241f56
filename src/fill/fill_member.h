// SPDX-License-Identifier: Apache-2.0
// Private to fill/: a record that is being made (fill_member.c), as a member of a batch
// (fill_batch.c).
#ifndef FILL_MEMBER_H
#define FILL_MEMBER_H

#include "fill/fill_record.h"

// What the records of a batch are made for, and from.
struct fill_making {
    struct fill *fill;
    struct cache *cache;        // of it
    struct cache_store *store;  // of the kind
    enum cache_kind kind;
    const struct fill_sites *sites;
};

// What gathering has found, and inserting the record reads.
struct fill_gathered {
    struct cache_irradiance_value irradiance;
    uint32_t radiance_rays;
    struct cache_residual residual;
    struct gather_surroundings around;
    float most;                 // R of a radiance record is at most this
    struct fill_extent extent;  // before it is limited by other records
    int refused;                // number of attempts that were not valid
    bool valid;                 // whether the last attempt was valid
};

// A record that is being made.
struct fill_member {
    const struct fill_site *site;
    struct gather_radiance radiance;
    struct fill_gathered found;
    float *value;  // of a radiance record, in the cache's arena
};

// Functions for one kind of records.
struct fill_functions {
    // Adds rays to a record that depends too much on a few of them, if it is of such a kind.
    void (*add_rays)(const struct fill_making *making, struct fill_member *member,
                     const struct gather_site *site, const struct gather_worker *worker);
    // Computes the record and its surroundings from a gathered hemisphere.
    void (*find)(const struct fill_making *making, struct fill_member *member,
                 const struct gather_hemisphere *hemisphere);
    // Sets the extent of the record that was found. False if the record is not valid.
    bool (*make)(const struct fill_making *making, struct fill_member *member);
    bool (*insert)(const struct fill_making *making,
                   struct fill_member *member);  // false if there is no memory
};

extern const struct fill_functions fill_functions_of[CACHE_KINDS];

#endif
