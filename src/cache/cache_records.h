// SPDX-License-Identifier: Apache-2.0
// The records of the caches, for the folders that read and make them. Which functions may be called
// at the same time is said in cache.h.
#ifndef CACHE_RECORDS_H
#define CACHE_RECORDS_H

#include "base/arena.h"
#include "cache/cache_tree.h"
#include "scene/scene.h"

// The two kinds of records, each with its own options and octree.
enum cache_kind { CACHE_IRRADIANCE, CACHE_RADIANCE, CACHE_KINDS };

// The value of an irradiance record: irradiance at a point, with gradients.
struct cache_irradiance_value {
    rgb E;
    vec3 grad_t[3];  // translation: dE/dp per channel, world, in the tangent plane
    vec3 grad_r[3];  // rotation: E changes by (n_i x n) . grad_r
    uint32_t rays;   // number of rays from which it was made
};

struct cache_irradiance_record {
    struct cache_irradiance_value value;
    float deviation;           // standard deviation of E over E
    float gradient_deviation;  // that of the translation gradient in any direction, over E
    float radius_ratio;        // R as it should be over R; below 1 where the least radius is larger
};

// The value of a radiance record has the layout for products with a BRDF: CACHE_LANES floats for
// each coefficient k: Lambda r g b and its noise, d/dx r g b 0, d/dy r g b 0.
enum { CACHE_LANES = 12 };

// The radiance that the BRDF of a record's site reflects of the record's rays, minus that which it
// reflects of their harmonics.
struct cache_residual {
    uint32_t lobe_number;  // see cache_lobe; 0: there is no residual
    vec3 mirror;           // see cache_lobe
    rgb L;                 // without the BRDF's factor `specular`
};

struct cache_radiance_record {
    struct frame frame;
    float *value;        // order^2 * CACHE_LANES, from cache_value_new
    float radius_ratio;  // as of an irradiance record
    uint32_t rays;
    struct cache_residual residual;
};

// The options of one kind of records. satin_options describes them as irradiance_a, radiance_a and
// so on.
struct cache_options {
    bool cache;    // whether surfaces read records of this kind
    bool diffuse;  // radiance: whether these serve diffuse lobes too; false for irradiance
    float a, widen;
    int rays;
    float noise;
    satin_basis basis;
    satin_gradients gradients;
    satin_radius radius;
    bool gradient_clamp, neighbour_clamp;
    bool curvature_clamp;  // of radiance records alone
    float min_pixels, max_pixels;
    float max_radius;  // in scene units; 0: no limit
};
void cache_options_of(const satin_options *options, struct cache_options out[CACHE_KINDS]);

// The records of one kind.
struct cache_store {
    struct cache_options options;
    bool widens;  // whether points near few records read them at a larger accuracy
    bool filled;  // whether records of this kind are made
    int order;    // order of the harmonics of its records; 0: irradiance records, or there are none
    struct cache_tree tree;
    union {  // the array of the records, in the order of the tree's heads
        void *record;
        struct cache_irradiance_record *irradiance;
        struct cache_radiance_record *radiance;
    };
    size_t record_bytes, capacity;  // size of a record, and number of those that fit
};

struct cache {
    const struct satin_scene *scene;
    const satin_options *options;
    struct cache_store store[CACHE_KINDS];
    struct arena radiance_arena;  // coefficient blocks
    float *cosine;                // the projection of cos(theta), so that E = Lambda . cosine
    int cosine_order;             // order of `cosine`; the cosine has two bands of HSH

    uint64_t rays;      // number of rays of all records
    double bytes_most;  // limit of its memory, after which no records are made; 0: none
};

// ---- New records (cache_insert.c) ---------------------------------------------------------------

// Memory in the cache for the value of a radiance record. NULL if there is none.
float *cache_value_new(struct cache *cache);
// Adds a record, whose head and values must be valid. False if there is no memory.
bool cache_insert_irradiance(struct cache *cache, const struct cache_head *head,
                             const struct cache_irradiance_record *record);
bool cache_insert_radiance(struct cache *cache, const struct cache_head *head,
                           const struct cache_radiance_record *record);
// Adds a copy of record i of a kind of another cache, whose radiance records are of the same order.
// False if there is no memory.
bool cache_insert_copy(struct cache *cache, const struct cache *from, enum cache_kind kind,
                       size_t i);

// ---- Leaks (cache_leak_test.c) ------------------------------------------------------------------

// Whether the record serves the point. If not, as the point is close to a surface that is near the
// record, the record still contributes to it, but the point gets a record of its own.
bool cache_serves(const struct cache_head *head, vec3 p);
// Whether a surface separates the record and the point. A ray is traced only in the sectors with
// near surfaces.
bool cache_leaks(const struct cache *cache, const struct cache_head *head, vec3 p);

// ---- Records for a point (cache_find.c) ---------------------------------------------------------

// The largest factor of an accuracy by which points near few records read them. Measured in
// docs/experiments/record-placement.md.
#define CACHE_WIDER 1.5f

// A record's number of rays over that of the options, in (0, 1]: 1 if it has more, as those that
// were gathered again, or if the options ask for a noise, by which numbers of rays are chosen.
float cache_rays_fraction(const struct cache *cache, enum cache_kind kind, size_t record);
// Does what cache_tree_find does for the records of a kind, without those that leak. Weights are
// multiplied by the fractions of rays, as variance is the inverse of their number.
int cache_find(const struct cache *cache, enum cache_kind kind, vec3 p, vec3 n, float a,
               struct cache_near near[CACHE_NEAR_MAX]);
// For reading: where records are dense, only those close by; where they are few and the store
// widens, also those farther away.
int cache_find_to_read(const struct cache *cache, enum cache_kind kind, vec3 p, vec3 n, float a,
                       struct cache_near near[CACHE_NEAR_MAX]);

// ---- Validity (cache_valid.c): finite, and distances, radii and scales in their ranges ----------

bool cache_valid_numbers(const float *value, size_t count);
bool cache_valid_head(const struct cache_head *head);
bool cache_valid_frame(const struct frame *frame);  // orthonormal

#endif
