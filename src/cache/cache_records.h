// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the records, and functions for both filling and reading.
#ifndef CACHE_RECORDS_H
#define CACHE_RECORDS_H

#include "cache/cache.h"
#include "cache/cache_tree.h"

// The value of a radiance record has the layout for products with a BRDF: CACHE_LANES floats for
// each coefficient k: Lambda r g b and its noise, d/dx r g b 0, d/dy r g b 0.
enum { CACHE_LANES = 12 };

// The number of different numbers of rays that records of one kind may have (cache_rays.c), and the
// largest number of rays.
enum { CACHE_LAYOUTS = 5, CACHE_RAYS_MAX = 1 << 20 };

// The radiance that the BRDF of a record's site reflects of the record's rays, minus that which it
// reflects of their harmonics.
struct cache_residual {
    uint32_t name;  // see cache_lobe; 0: there is no residual
    vec3 mirror;    // see cache_lobe
    rgb L;          // without the BRDF's factor `specular`
};

struct cache_radiance_record {
    struct frame frame;
    float *value;        // order^2 * CACHE_LANES, in the cache's arena
    float radius_ratio;  // see cache_extent
    uint32_t rays;
    struct cache_residual residual;
};

struct cache_irradiance_record {
    struct gather_irradiance value;
    float deviation;     // standard deviation of E over E
    float radius_ratio;  // see cache_extent
};

// The options of one kind of records. satin_options describes them as irradiance_a, radiance_a and
// so on.
struct cache_options {
    float a, widen;
    int rays;
    float noise;
    satin_basis basis;
    satin_gradients gradients;
    satin_radius radius;
    bool gradient_clamp, neighbour_clamp;
    float min_pixels, max_pixels;
    float max_radius;  // in scene units; 0: no limit
};
struct cache_options cache_options_of(const satin_options *options, enum cache_kind kind);

// The records of one kind: what both kinds have in common.
struct cache_store {
    struct cache_options options;
    int order;  // order of the harmonics of its records; 0: irradiance records, or there are none
    struct cache_tree tree;
    // Hemispheres of different numbers of rays; NULL if not used.
    struct gather_layout *layout[CACHE_LAYOUTS];
};

struct cache {
    const struct gather *g;
    struct parallel *pool;
    struct cache_store store[CACHE_KINDS];

    struct cache_irradiance_record *irradiance;
    size_t irradiance_capacity;

    struct cache_radiance_record *radiance;
    size_t radiance_capacity;
    struct arena radiance_arena;  // coefficient blocks
    float *cosine;                // the projection of cos(theta), so that E = Lambda . cosine
    int cosine_order;             // order of `cosine`; the cosine has two bands of HSH

    struct gather_layout *irradiance_whole;  // with all the rays of the options
    float rays_fraction;                     // fraction of the options' rays that new records get
    struct gather_worker *worker;            // one for each worker of the pool
    int worker_count;
    uint64_t rays;     // number of rays of all records
    uint64_t refused;  // number of records that were not finite or out of range
    struct {
        int passes;               // largest number of passes of the two caches
        uint64_t points, shrunk;  // numbers of points that were evaluated, and of times that a
                                  // scale was lowered
        double seconds;           // without the time for gathering
    } adapted;
};

// ---- The area of a new record (cache_extent.c) --------------------------------------------------

// The extent of a record before neighbour clamping: an ellipse in the tangent plane, or a circle if
// both radii are equal.
struct cache_extent {
    float R;             // the larger radius
    float across;        // the smaller one, along `axis`; at most R
    vec3 axis;           // unit, in world space; 0 for a circle
    float radius_ratio;  // R as it should be over R; below 1 where the least radius is larger
};
// The extent of a record from what its rays found around it [K05 3.3, 6.5.1]. Scales down the
// gradients of *value if R is larger than the distance for which they are valid.
struct cache_extent cache_extent_irradiance(const struct cache *cache,
                                            const struct cache_site *site,
                                            const struct gather_around *around,
                                            struct gather_irradiance *value);
struct cache_extent cache_extent_radiance(const struct cache *cache, const struct cache_site *site,
                                          const struct gather_around *around,
                                          struct gather_radiance *value);
// The least R of records at a pixel width: the options' least radius in pixels, over a.
float cache_least_radius(const struct cache_options *options, float pixel);
// Neighbour clamping [K05 6.5.2] (cache_neighbour_clamp.c): returns R of a new record at (p, n),
// limited by its neighbours in the tree, and limits those of the neighbours by the new one.
float cache_neighbour_clamp(struct cache_tree *tree, vec3 p, vec3 n, float R);

// ---- Rays of a new record (cache_rays.c) --------------------------------------------------------

// Makes new layouts for a kind of records: those that its options need, for a fraction of the rays.
// SATIN_ERROR_MEMORY: then it keeps its layouts.
satin_status cache_rays_prepare(struct cache *cache, enum cache_kind kind, float fraction);
// The layout of a new record, from the variance of the records that cover its site at accuracy a.
const struct gather_layout *cache_rays_layout(const struct cache *cache, enum cache_kind kind,
                                              const struct cache_site *site, float a);

// ---- Validity (cache_valid.c): finite, and E, distances, radii and scales in their ranges -------

bool cache_valid_numbers(const float *value, size_t count);
bool cache_valid_irradiance(const struct gather_irradiance *value,
                            const struct gather_around *around);
bool cache_valid_radiance(const struct gather_radiance *value, int order,
                          const struct gather_around *around);
bool cache_valid_head(const struct cache_head *head);

// ---- Leaks (cache_leak.c) -----------------------------------------------------------------------

// The mask of the sectors with surfaces nearer than `radius`. *clear is set to a distance within
// which there are none.
uint32_t cache_leak_sectors(const struct gather_around *around, float radius, float *clear);
// Whether a surface separates the record and the point. A ray is traced only in the sectors with
// near surfaces.
bool cache_leaks(const struct cache *cache, const struct cache_head *head, vec3 p);
// Does what cache_tree_find does, without the records that leak.
int cache_find(const struct cache *cache, const struct cache_tree *tree, vec3 p, vec3 n, float a,
               struct cache_near near[CACHE_NEAR_MAX]);

// ---- One record's value (cache_read.c) ----------------------------------------------------------

// The lobes at a point: L = specular * (lobe . Lambda) + diffuse * E. C of the lobe may point to
// `coefficients`; order 0: there is no glossy lobe.
struct cache_surface {
    rgb specular, diffuse;
    struct cache_lobe lobe;
    float coefficients[3 * RSH_MAX_COEFFICIENTS];
};
// The luminance of one record's light that a surface reflects. *noise is set to its standard
// deviation, or for radiance to one sample of the noise.
typedef float cache_reflected_fn(const struct cache *cache, uint32_t record,
                                 const struct cache_lookup *at, float a,
                                 const struct cache_surface *surface, float *noise);
cache_reflected_fn cache_irradiance_reflected, cache_radiance_reflected;
// Transforms a lobe from frame `from` to frame `to`, for products with a record in that frame
// (cache_rotate.c). lobe->C then points to `rotated`, of 3 * order^2.
void cache_rotate(const struct cache *cache, const struct frame *from, const struct frame *to,
                  struct cache_lobe *lobe, float *rotated);

// ---- Residuals (cache_residual.c) ---------------------------------------------------------------

// The residual of a record in frame `frame`. `whole` is the radiance that the BRDF reflects of its
// rays.
struct cache_residual cache_residual_make(const struct gather_radiance *radiance, int order,
                                          const struct frame *frame, const struct cache_view *view,
                                          rgb whole);
// The correction of the radiance that a lobe reflects of the record's harmonics; may be negative.
rgb cache_residual_read(const struct cache_residual *residual, const struct cache_lobe *lobe);

#endif
