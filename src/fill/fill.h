// SPDX-License-Identifier: Apache-2.0
// Makes the records of the caches: at sites, in deterministic batches on all threads, and adapts
// them to the points where they will be read. Folder cache keeps and reads the records. Units and
// symbols are those of cache/cache.h.
//
// Threads: the functions change the cache and must be called by one thread at a time, while no
// other uses it; they use the pool themselves.
#ifndef FILL_FILL_H
#define FILL_FILL_H

#include "cache/cache.h"
#include "gather/gather.h"

// The glossy lobes of a surface point for the direction to the eye.
struct fill_glossy {
    struct brdf brdf;                // from brdf_white
    const struct brdf_range *table;  // table of its harmonics; NULL: there is no glossy lobe, or it
                                     // is not cached
    int channels;                    // of the table: 1 or 3
    uint32_t lobe_number;            // see cache_lobe; 0: no record has a residual for it
    vec3 wo;                         // direction to the eye, in the site's frame
};

// A surface point at which a record may be made, and the reflection there. Bump and normal maps are
// left out, so that they need no additional records. 336 bytes.
struct fill_site {
    vec3 p;              // position of the record, away from the edges of its triangle
    vec3 ng;             // geometric normal on the side that is seen
    struct frame frame;  // shading frame; n on the same side
    float pixel;         // width of a projected pixel at p, across the line of sight; > 0
    uint64_t stream;     // random stream, unique to the site
    uint8_t kinds;       // kinds of records that the surface reads, a mask of 1 << cache_kind
    struct fill_glossy glossy;  // all zero: the site is not seen
    // Used by fill_adapt only:
    vec3 shading_p;  // the point that is seen; p is this point, moved off an edge
    rgb diffuse;     // BRDF of the diffuse lobe [sr^-1]
    rgb specular;    // factor of the glossy lobes
    float direct;    // luminance of the direct light that is reflected to the eye
};

// What makes the records of one cache.
struct fill;

// Makes one with memory for each worker of the pool. NULL if there is no memory. The cache, what
// `g` points to and the pool must outlive it; the scene and the options of `g` are those of the
// cache.
struct fill *fill_new(struct cache *cache, const struct gather *g, struct parallel *pool);
void fill_free(struct fill *fill);  // NULL is allowed; the cache keeps its records

// Sites, and how densely they are to be covered.
struct fill_sites {
    const struct fill_site *site;  // read only; NULL if count is 0
    size_t count;
    float a;           // > 0
    float factor_max;  // records will be read at accuracies up to this times a of the options; > 0
    float spacing;     // distance of sites in pixels; members of a batch are farther apart
    float rays_least;  // a record of less than this fraction of its rays covers nothing; 0: all do
    bool adapted;      // new records have the scale of the nearest one [K05 6.3.2]
};

// The number of sites that need a record of a kind and are not covered at accuracy a, estimated
// from the first ones, which must be in random order. It makes fewer records: one covers several.
double fill_uncovered(const struct fill *fill, enum cache_kind kind,
                      const struct fill_sites *sites);

// Makes records of a kind until every site that needs one is covered at accuracy a. It selects
// uncovered sites in the given order, in batches whose members are far apart, gathers each batch on
// all threads while the cache does not change, and inserts the records in order: they depend on the
// sites and the options, not on the threads. Radiance records are made only if the cache's order is
// above 0. SATIN_CANCELLED if the pool's progress function stopped a loop, or SATIN_ERROR_MEMORY:
// then the records of earlier batches are in the cache.
satin_status fill_records(struct fill *fill, enum cache_kind kind, const struct fill_sites *sites);

// Adapts the records of a kind to sites that are covered [K05 6.3] (fill_adaptive_cache.c): where
// records that are read at accuracy read_a disagree perceptibly, the scales of the farthest ones
// are lowered, and new records fill the gaps, until none disagree. Returns the status as
// fill_records.
satin_status fill_adapt(struct fill *fill, enum cache_kind kind, const struct fill_sites *sites,
                        float read_a);

// Removes noise from the irradiance records, which are read at accuracy a (fill_smooth.c). To be
// called once, when all are made. SATIN_CANCELLED or SATIN_ERROR_MEMORY: then they are unchanged.
satin_status fill_smooth(struct fill *fill, float a);
// As fill_smooth, but of the records of which single rays are a large part, and in one thread.
satin_status fill_spread_outliers(struct fill *fill, float a);

// Sets the fraction, in (0, 1], of the options' gather rays that new records get.
// SATIN_ERROR_MEMORY: then a kind of records may keep its number of rays.
satin_status fill_limit_rays(struct fill *fill, float fraction);
// Sets the fraction, in (0, 1], of the options' least radius for new records of a kind.
void fill_limit_radius(struct fill *fill, enum cache_kind kind, float fraction);

// Sets the statistics of the cache and of filling it.
void fill_statistics(const struct fill *fill, struct stats *stats);

#endif
