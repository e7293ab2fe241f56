// SPDX-License-Identifier: Apache-2.0
// Private to fill/: the state of filling, and what is computed for one record.
#ifndef FILL_RECORD_H
#define FILL_RECORD_H

#include "fill/fill.h"

// The number of different numbers of rays that records of one kind may have (fill_rays.c), and the
// largest number of rays.
enum { FILL_LAYOUTS = 5, FILL_RAYS_MAX = 1 << 20 };

// How the records of one kind are made.
struct fill_side {
    // Hemispheres of different numbers of rays, and for records of which half of the rays are drawn
    // by the glossy lobes of their site those of the stratified half; NULL if not used.
    struct gather_layout *layout[FILL_LAYOUTS], *glossy[FILL_LAYOUTS];
    bool draws_glossy;            // whether there are such records
    struct gather_layout *whole;  // irradiance: with all the rays of the options
    float radius_fraction;        // of the options' least radius, for new records
};

struct fill {
    struct cache *cache;
    const struct gather *g;
    struct parallel *pool;
    struct fill_side side[CACHE_KINDS];
    float rays_fraction;           // fraction of the options' rays that new records get
    struct gather_worker *worker;  // one for each worker of the pool
    int worker_count;
    uint64_t refused;   // number of records that were not finite or out of range
    uint64_t outliers;  // number of irradiance records of which single rays are a large part
    struct {
        int passes;               // largest number of passes of the two caches
        uint64_t points, shrunk;  // numbers of points that were evaluated, and of times that a
                                  // scale was lowered
        double seconds;           // without the time for gathering
    } adapted;
};

// Whether records of a kind cover a site as `sites` want it (fill_coverage.c).
bool fill_is_covered(const struct fill *fill, enum cache_kind kind, const struct fill_sites *sites,
                     const struct fill_site *site);

// ---- The area of a new record (fill_extent.c) ---------------------------------------------------

// The extent of a record before neighbour clamping: an ellipse in the tangent plane, or a circle if
// both radii are equal.
struct fill_extent {
    float R;             // the larger radius
    float across;        // the smaller one, along `axis`; at most R
    vec3 axis;           // unit, in world space; 0 for a circle
    float radius_ratio;  // R as it should be over R; below 1 where the least radius is larger
};
// The extent of a record from what its rays found around it [K05 3.3, 6.5.1]. Scales down the
// gradients of *value if R is larger than the distance for which they are valid. R of a radiance
// record is at most `most`, unless the least radius is larger.
struct fill_extent fill_extent_irradiance(const struct fill *fill, const struct fill_site *site,
                                          const struct gather_surroundings *around,
                                          struct cache_irradiance_value *value);
struct fill_extent fill_extent_radiance(const struct fill *fill, const struct fill_site *site,
                                        const struct gather_surroundings *around, float most,
                                        struct gather_radiance *value);
// At most R: a radius within which the light that a record's lobes reflect to the eye is linear
// enough for its gradient at accuracy a (fill_curvature_clamp.c). R below `least` is not reduced
// further. The hemisphere is that of the record; its scratch is overwritten.
float fill_curvature_clamp_radius(const struct gather_hemisphere *hemisphere,
                                  const struct fill_glossy *glossy, float a, float R, float least);
// The least R of new records of a kind at a pixel width: the fraction of the options' least radius
// in pixels, over a.
float fill_least_radius(const struct fill *fill, enum cache_kind kind, float pixel);
// Neighbour clamping [K05 6.5.2] (fill_neighbour_clamp.c): returns R of a new record at (p, n),
// limited by its neighbours in the tree, and limits those of the neighbours by the new one.
float fill_neighbour_clamp(struct cache_tree *tree, vec3 p, vec3 n, float R);
// Finds how far a record of this search radius serves points in each sector (struct cache_head), at
// least as far as its least influence radius. Returns the distance within which no surface is.
float fill_find_sectors(const struct gather_surroundings *around, float radius, float least,
                        uint8_t sector[CACHE_SECTORS]);

// ---- Rays of a new record (fill_rays.c) ---------------------------------------------------------

// Makes new layouts for a kind of records: those that its options need, for a fraction of the rays.
// SATIN_ERROR_MEMORY: then it keeps its layouts.
satin_status fill_rays_prepare(struct fill *fill, enum cache_kind kind, float fraction);
// Whether half of the rays of a new record are drawn by the glossy lobes of its site.
bool fill_rays_glossy(const struct fill *fill, enum cache_kind kind, const struct fill_site *site);
// The layout of a new record, from the variance of the records that cover its site at accuracy a.
const struct gather_layout *fill_rays_layout(const struct fill *fill, enum cache_kind kind,
                                             const struct fill_site *site, float a);

// ---- Validity (fill_valid.c): finite, and E and distances in their ranges -----------------------

bool fill_valid_irradiance(const struct cache_irradiance_value *value,
                           const struct gather_surroundings *around);
bool fill_valid_radiance(const struct gather_radiance *value, int order,
                         const struct gather_surroundings *around);

// ---- Residuals (fill_residual.c) ----------------------------------------------------------------

// The residual of a record in frame `frame`. `whole` is the radiance that the BRDF reflects of its
// rays.
struct cache_residual fill_residual(const struct gather_radiance *radiance, int order,
                                    const struct frame *frame, const struct fill_glossy *glossy,
                                    rgb whole);

#endif
