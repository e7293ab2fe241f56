// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the records, and the functions that filling and reading have in common.
#ifndef CACHE_RECORDS_H
#define CACHE_RECORDS_H

#include "cache/cache.h"
#include "cache/cache_tree.h"

// A radiance record's value is laid out for products with a BRDF. It has CACHE_LANES floats for
// each coefficient k: Lambda r g b and its noise, d/dx r g b 0, d/dy r g b 0.
enum { CACHE_LANES = 12 };

// How many different numbers of rays the records of a side may have (cache_rays.c), and the
// largest.
enum { CACHE_LAYOUTS = 5, CACHE_RAYS_MAX = 1 << 20 };

// The radiance that the BRDF of a record's site reflects of the record's rays, less what it
// reflects of their harmonics.
struct cache_residual {
    uint32_t name;  // see cache_lobe; 0: nothing is known
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

// The options of one kind of records; satin_options has them as irradiance_a, radiance_a and so on,
// and says what they mean.
struct cache_options {
    float a, widen;
    int rays;
    float noise;
    satin_basis basis;
    satin_gradients gradients;
    satin_radius radius;
    bool gradient_clamp, neighbour_clamp;
    float min_pixels, max_pixels;
    float max_radius;  // in scene units; 0: none
};
struct cache_options cache_options_of(const satin_options *options, enum cache_kind kind);

// What both kinds of records have.
struct cache_side {
    struct cache_options options;
    int order;  // of the harmonics that its records hold; 0: of irradiance, or there are none
    struct cache_tree tree;
    // Hemispheres of different numbers of rays; NULL where none is used.
    struct gather_layout *layout[CACHE_LAYOUTS];
};

struct cache {
    const struct gather *g;
    struct parallel *pool;
    struct cache_side side[CACHE_KINDS];

    struct cache_irradiance_record *irradiance;
    size_t irradiance_capacity;

    struct cache_radiance_record *radiance;
    size_t radiance_capacity;
    struct arena radiance_arena;  // coefficient blocks
    float *cosine;                // the projection of cos(theta), so that E = Lambda . cosine
    int cosine_order;             // HSH hold the cosine in two bands

    struct gather_layout *irradiance_whole;  // all the rays that the options say
    float rays_fraction;                     // of the options' rays that new records get
    struct gather_scratch **scratch;         // one per worker
    int scratch_count;
    uint64_t rays;     // of all records
    uint64_t refused;  // records that were not finite or out of range
    struct {
        int passes;               // of the cache that took more
        uint64_t points, shrunk;  // points that were evaluated, records whose scale was lowered
        double seconds;           // without gathering
    } adapted;
};

// ---- The area of a new record (cache_extent.c) --------------------------------------------------

// An ellipse in the tangent plane, before neighbour clamping; a circle if both radii are equal.
struct cache_extent {
    float R;             // the larger radius
    float across;        // the smaller one, along `axis`; at most R
    vec3 axis;           // unit, in world space; 0 for a circle
    float radius_ratio;  // R that was wanted over R; below 1 where the least radius is larger
};
// The area by what the record's rays found around it [K05 3.3, 6.5.1]. Scales the gradients of
// *value down where R is larger than they can carry.
struct cache_extent cache_extent_irradiance(const struct cache *cache,
                                            const struct cache_site *site,
                                            const struct gather_around *around,
                                            struct gather_irradiance *value);
struct cache_extent cache_extent_radiance(const struct cache *cache, const struct cache_site *site,
                                          const struct gather_around *around,
                                          struct gather_radiance *value);
// The least R of records where a pixel is so wide: the options' least radius in pixels, over a.
float cache_least_radius(const struct cache_options *options, float pixel);
// Neighbour clamping [K05 6.5.2] (cache_neighbour_clamp.c): limits R of a new record at (p, n) by
// its neighbours in the tree and returns it, and limits theirs by the new one.
float cache_neighbour_clamp(struct cache_tree *tree, vec3 p, vec3 n, float R);

// ---- Rays of a new record (cache_rays.c) --------------------------------------------------------

// Makes the layouts of a side anew: those that its options ask for, of a fraction of their rays.
// SATIN_ERROR_MEMORY: then it keeps those that it had.
satin_status cache_rays_prepare(struct cache *cache, enum cache_kind kind, float fraction);
// The layout of a new record, by the variance of the records that serve its site at accuracy a.
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

// The mask of the sectors in which something stands nearer than `radius`; *clear gets a distance
// within which nothing does.
uint32_t cache_leak_walls(const struct gather_around *around, float radius, float *clear);
// Whether a ray is occluded between the record and the point, which is traced only where the record
// keeps a wall.
bool cache_leaks(const struct cache *cache, const struct cache_head *head, vec3 p);
// cache_tree_find, without the records that leak.
int cache_find(const struct cache *cache, const struct cache_tree *tree, vec3 p, vec3 n, float a,
               struct cache_near near[CACHE_NEAR_MAX]);

// ---- One record's value (cache_read.c) ----------------------------------------------------------

// What reflects at a point: L = specular * (lobe . Lambda) + diffuse * E. C of the lobe may point
// into `coefficients`; order 0: no glossy lobe.
struct cache_surface {
    rgb specular, diffuse;
    struct cache_lobe lobe;
    float coefficients[3 * RSH_MAX_COEFFICIENTS];
};
// Luminance of what a surface reflects of one record; *noise gets its standard deviation, or for
// radiance one sample of it.
typedef float cache_reflected_fn(const struct cache *cache, uint32_t record,
                                 const struct cache_lookup *at, float a,
                                 const struct cache_surface *surface, float *noise);
cache_reflected_fn cache_irradiance_reflected, cache_radiance_reflected;
// Expresses a lobe that is given in frame `from` in frame `to`, for products with a record in that
// frame (cache_rotate.c): lobe->C then points into `rotated`, of 3 * order^2.
void cache_rotate(const struct cache *cache, const struct frame *from, const struct frame *to,
                  struct cache_lobe *lobe, float *rotated);

// ---- Residuals (cache_residual.c) ---------------------------------------------------------------

// The residual of a record of frame `frame`; `whole` is what the BRDF reflects of its rays.
struct cache_residual cache_residual_make(const struct gather_radiance *radiance, int order,
                                          const struct frame *frame, const struct cache_view *view,
                                          rgb whole);
// What a residual adds to what a lobe reflects of the record's harmonics; may be negative.
rgb cache_residual_read(const struct cache_residual *residual, const struct cache_lobe *lobe);

#endif
