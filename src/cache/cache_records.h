// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the records and what is shared by filling and reading.
#ifndef CACHE_RECORDS_H
#define CACHE_RECORDS_H

#include "cache/cache.h"
#include "cache/cache_tree.h"

// A radiance record's value, laid out for products with a BRDF: for each coefficient k, CACHE_LANES
// floats: Lambda r g b and its noise, d/dx r g b 0, d/dy r g b 0.
enum { CACHE_LANES = 12 };

// Numbers of rays that records of a cache may have (cache_rays.c), and the most of them.
enum { CACHE_LAYOUTS = 5, CACHE_RAYS_MAX = 1 << 20 };

// Radiance that the BRDF of a record's site reflects of the record's rays, less that of their
// harmonics.
struct cache_residual {
    uint32_t name;  // of the BRDF; 0: nothing is known
    vec3 mirror;    // see cache_lobe
    rgb L;          // without the BRDF's factor `specular`
};

struct cache_radiance_record {
    struct frame frame;
    float *value;  // order^2 * CACHE_LANES
    float room;    // R that was wanted over R, below 1 where the least radius holds it up
    uint32_t rays;
    struct cache_residual residual;
};

struct cache_irradiance_record {
    struct gather_irradiance value;
    float deviation;  // standard deviation of E over E
    float room;       // as above
};

// The options of one kind of records; satin_options has them as irradiance_a, radiance_a and so on,
// and says what they mean.
struct cache_options {
    float a, widen;
    int rays;
    float noise;
    satin_basis basis;
    satin_gradients gradients;
    satin_radius radius;
    bool gradient_clamp, neighbours;
    float min_pixels, max_pixels;
    float max_radius;  // in scene units; 0: none
};
struct cache_options cache_options_of(const satin_options *options, enum cache_kind kind);

// What both kinds of records have.
struct cache_side {
    struct cache_options options;
    struct cache_tree tree;
    // Hemispheres of different numbers of rays; NULL where none is used.
    struct gather_layout *layout[CACHE_LAYOUTS];
};

struct cache {
    const struct gather *g;
    struct parallel *pool;
    int order;  // of radiance records; 0: none
    struct cache_side side[CACHE_KINDS];

    struct cache_irradiance_record *irradiance;
    size_t irradiance_capacity;

    struct cache_radiance_record *radiance;
    size_t radiance_capacity;
    struct arena radiance_arena;  // coefficient blocks
    float *cosine;                // the projection of cos(theta), so that E = Lambda . cosine
    int cosine_order;             // HSH hold the cosine in two bands

    struct gather_layout *irradiance_whole;  // all the rays that the options say
    float rays_part;                         // of them that new records get
    struct gather_scratch **scratch;         // one per worker
    int scratch_count;
    uint64_t rays;
    uint64_t refused;  // records that were not finite or out of range
    struct {
        int passes;               // of the cache that took more
        uint64_t points, shrunk;  // points judged, records whose scale was lowered
        double seconds;           // without gathering
    } converged;
};

// The area of a new record: R along the surface but `across` (at most R) along `axis`, a unit
// vector of the tangent plane, before neighbour clamping. Limits the value's gradient where R
// cannot follow it. From what its rays found around it [K05 3.3, 6.5.1].
struct cache_extent {
    float R, across;
    vec3 axis;
    float room;  // R that was wanted over R; at most 1
};
struct cache_extent cache_extent_irradiance(const struct cache *cache,
                                            const struct cache_site *site,
                                            const struct gather_around *around,
                                            struct gather_irradiance *value);
struct cache_extent cache_extent_radiance(const struct cache *cache, const struct cache_site *site,
                                          const struct gather_around *around,
                                          struct gather_radiance *value);
// Makes the layouts of a side anew: those that its options ask for, of a fraction of their rays.
// SATIN_ERROR_MEMORY: then it keeps those that it had.
satin_status cache_rays_prepare(struct cache *cache, enum cache_kind kind, float fraction);
// The layout of a new record, by the records that reach its site at accuracy a.
const struct gather_layout *cache_rays_layout(const struct cache *cache, enum cache_kind kind,
                                              const struct cache_site *site, float a);
// The least R that is made where a pixel is so wide: a R of the options' least radius in pixels.
float cache_least_radius(const struct cache_options *options, float pixel);
// Neighbour clamping [K05 6.5.2]: R of the new record, after limiting it by its neighbours and them
// by it.
float cache_clamp_neighbours(struct cache_tree *tree, vec3 p, vec3 n, float R);

// ---- Validity (cache_valid.c): finite, and E, distances, radii and scales in their ranges
bool cache_valid_numbers(const float *value, size_t count);
bool cache_valid_irradiance(const struct gather_irradiance *value,
                            const struct gather_around *around);
bool cache_valid_radiance(const struct gather_radiance *value, int order,
                          const struct gather_around *around);
bool cache_valid_head(const struct cache_head *head);

// What reflects at a point: L = specular * (lobe . Lambda) + diffuse * E. C of the lobe may point
// into `coefficients`; order 0: no glossy part.
struct cache_surface {
    rgb specular, diffuse;
    struct cache_lobe lobe;
    float coefficients[3 * RSH_MAX_COEFFICIENTS];
};

// Sectors in which something stands nearer than `reach`; *clear gets the least distance of all.
uint32_t cache_leak_walls(const struct gather_around *around, float reach, float *clear);
// The records to interpolate at a place, without those that do not see it.
int cache_find(const struct cache *cache, const struct cache_tree *tree, vec3 p, vec3 n, float a,
               struct cache_near near[CACHE_NEAR_MAX]);
// Luminance of what a surface reflects of one record; *noise gets its standard deviation, or for
// radiance one sample of it.
float cache_reflected(const struct cache *cache, enum cache_kind kind, uint32_t record,
                      const struct cache_lookup *at, float a, const struct cache_surface *surface,
                      float *noise);
// Whether a wall stands between the record and the point.
bool cache_leaks(const struct cache *cache, const struct cache_head *head, vec3 p);

// The residual of a record of frame `frame`; `whole` is what the BRDF reflects of its rays.
struct cache_residual cache_residual_make(const struct gather_radiance *radiance, int order,
                                          const struct frame *frame, const struct cache_view *view,
                                          rgb whole);
// What it adds to what a lobe reflects of the record's harmonics.
rgb cache_residual_read(const struct cache_residual *residual, const struct cache_lobe *lobe);

// Re-expresses a BRDF given in frame `from` for products with a record in frame `to`; *lobe then
// points into `turned` (3 * order^2).
void cache_turn(const struct cache *cache, const struct frame *from, const struct frame *to,
                struct cache_lobe *lobe, float *turned);

#endif
