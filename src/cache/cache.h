// SPDX-License-Identifier: Apache-2.0
// The caches of the second pass: irradiance records on diffuse surfaces [Ward 1988, Ward and
// Heckbert 1992], and incident radiance records on glossy ones [K05 3]. They are first filled at
// sites, in deterministic batches on all threads, and then read without changes. Positions and
// radii are in scene units; directions are unit vectors in world space unless a comment says
// otherwise. Symbols: a accuracy (the largest error with which a record is used), R record radius
// (harmonic mean distance, clamped), E irradiance [W m^-2], L radiance [W m^-2 sr^-1], Lambda
// harmonic coefficients of incident radiance.
//
// Threads: cache_fill, cache_adapt, cache_limit_* and cache_load change the cache and must be
// called by one thread at a time, while no other uses it; they use the pool themselves. All
// functions that take a const cache may be called by any number of threads at once.
#ifndef CACHE_CACHE_H
#define CACHE_CACHE_H

#include "base/log.h"
#include "base/stats.h"
#include "gather/gather.h"
#include "rsh/rsh.h"

struct cache;

// The two kinds of records, each with its own options and octree.
enum cache_kind { CACHE_IRRADIANCE, CACHE_RADIANCE, CACHE_KINDS };

// The glossy lobes of a surface point for the direction to the eye.
struct cache_view {
    struct brdf brdf;                // for a factor `specular` of 1
    const struct brdf_range *table;  // table of its harmonics; NULL: there is no glossy lobe, or it
                                     // is not cached
    int channels;                    // of the table: 1 or 3
    uint32_t name;                   // see cache_lobe; 0: no record has a residual for it
    vec3 wo;                         // direction to the eye, in the site's frame
};

// A surface point at which a record may be made, and the reflection there. Bump and normal maps are
// left out, so that they need no additional records. 336 bytes.
struct cache_site {
    vec3 p;                  // position of the record, away from the edges of its triangle
    vec3 ng;                 // geometric normal on the side that is seen
    struct frame frame;      // shading frame; n on the same side
    float pixel;             // width of a projected pixel at p, across the line of sight; > 0
    uint64_t stream;         // random stream, unique to the site
    uint8_t wants;           // kinds of records that the surface reads, a mask of 1 << cache_kind
    struct cache_view view;  // all zero: the site is not seen
    // Used by cache_adapt only:
    vec3 shading_p;  // the point that is seen; p is this point, moved off an edge
    rgb diffuse;     // BRDF of the diffuse lobe [sr^-1]
    rgb specular;    // factor of the glossy lobes
    float direct;    // luminance of the direct light that is reflected to the eye
};

// Makes empty caches. `order` is the order of radiance records, at most RSH_MAX_ORDER; 0 if there
// will be none. There is memory for each worker of the pool. NULL if there is no memory. What `g`
// points to, and the pool, must outlive the cache. The options in struct cache_options are copied.
struct cache *cache_new(const struct gather *g, int order, struct parallel *pool);
void cache_free(struct cache *cache);  // NULL is allowed

// Makes records of a kind until every site that needs one is covered at accuracy a. It selects
// uncovered sites in the given order, in batches whose members are far apart, gathers each batch on
// all threads while the cache does not change, and inserts the records in order: they depend on the
// sites and the options, not on the threads. Radiance records are made only if the cache's order is
// above 0. SATIN_CANCELLED if the pool's progress function stopped a loop, or SATIN_ERROR_MEMORY:
// then the records of earlier batches are in the cache.
struct cache_fill {
    const struct cache_site *site;  // read only; NULL if count is 0
    size_t count;
    float a;        // > 0
    float widest;   // records will be read at accuracies up to this times a of the options; >= 1
    float spacing;  // distance of sites in pixels; members of a batch are farther apart
    bool adapted;   // new records have the scale of the nearest one [K05 6.3.2]
};
satin_status cache_fill(struct cache *cache, enum cache_kind kind, const struct cache_fill *fill);

// Sets the fraction, in (0, 1], of the options' gather rays that new records get.
// SATIN_ERROR_MEMORY: then a kind of records may keep its number of rays.
satin_status cache_limit_rays(struct cache *cache, float fraction);
// Sets the fraction, in (0, 1], of the options' least radius for new records of a kind.
void cache_limit_radius(struct cache *cache, enum cache_kind kind, float fraction);

// ---- Reading (cache_read.c) ---------------------------------------------------------------------

// A point at which interpolated light is needed.
struct cache_lookup {
    vec3 p, n;              // position, and normal without bump and normal maps
    struct frame frame;     // of the BRDF; its n is the normal with bump and normal maps
    float fallback_radius;  // where no record is accurate enough, the nearest one within this
                            // distance is used; 0: none is
};

// Sums over the records of an interpolation. A fallback record has weight 1.
struct cache_used {
    int count;
    float weight;
    float a, rays;  // accuracies of the records and numbers of their rays, times their weights
};
static inline struct cache_used cache_used_add(struct cache_used x, struct cache_used y) {
    return (struct cache_used){x.count + y.count, x.weight + y.weight, x.a + y.a, x.rays + y.rays};
}

// Interpolates irradiance on a facet of normal frame.n at accuracy a [K05 (2.2)]. If no record is
// near, count is 0 and *E is unchanged.
struct cache_used cache_irradiance(const struct cache *cache, const struct cache_lookup *at,
                                   float a, rgb *E);

// A glossy lobe that reflects the interpolated radiance [K05 (3.2), (3.3)].
struct cache_lobe {
    const float *C;  // its coefficients in the lookup's frame: channels * order^2
    int order;       // at most the cache's; 0: there is no glossy lobe
    int channels;    // 1 or 3
    // By these a record finds out whether its residual is of this lobe (cache_residual.c).
    uint32_t name;  // equal for BRDFs that are equal up to their factor; 0: it has none
    vec3 mirror;    // see cache_mirror
};
// The direction, in world space, that an ideal mirror shows along wo, which is in the frame.
static inline vec3 cache_mirror(const struct frame *frame, vec3 wo) {
    return frame_to_world(frame, v3(-wo.x, -wo.y, wo.z));
}
// Sets *glossy to the radiance that the lobe reflects, without the BRDF's factor `specular`, and *E
// to the irradiance from the same records. If lobe is NULL, *glossy is unchanged and may be NULL; E
// may be NULL. If no record is near, count is 0 and both are unchanged.
struct cache_used cache_radiance(const struct cache *cache, const struct cache_lookup *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E);
// Whether a record of any kind is within `radius` of p, on a surface of the same orientation.
bool cache_has_record_near(const struct cache *cache, vec3 p, vec3 n, float radius);

// ---- Adaptive caching [K05 6.3] (cache_adaptive.c) ----------------------------------------------

// Adapts the records of a kind to the sites of a completed fill: where records that are read at
// accuracy read_a disagree visibly, the scales of the farthest ones are lowered, and new records
// fill the gaps, until none disagree. Returns the status as cache_fill.
satin_status cache_adapt(struct cache *cache, enum cache_kind kind, const struct cache_fill *fill,
                         float read_a);

// ---- Files of records (cache_file.c, docs/formats.md) -------------------------------------------

// The first 8 bytes of a file. They include line breaks, so that a transfer as text is detected.
#define CACHE_FILE_MAGIC "\211satin\r\n"

// The scene and options for which records were made.
struct cache_origin {
    uint64_t world;  // hash of the scene
    uint64_t
        view;  // hash of camera, film and seed; 0 after a time limit, as more records would be made
    const char *options;  // those that affect records: `name=value`, separated by spaces
};

// Writes all records. The file appears whole or not at all. Returns the status of writing, with one
// logged line on failure.
satin_status cache_save(const struct cache *cache, const struct cache_origin *origin,
                        const char *path, struct log log);

// Checks and parses the bytes of a file; `name` is for messages. SATIN_ERROR_INPUT, with one logged
// line, if they are damaged. The caller frees *file; `data` must outlive it.
struct cache_file;
satin_status cache_file_parse(const void *data, size_t size, const char *name, struct log log,
                              struct cache_file **file);
void cache_file_free(struct cache_file *file);  // NULL is allowed
// SATIN_ERROR_INPUT, with one logged line, if the records are of another origin. The view may
// differ.
satin_status cache_file_check(const struct cache_file *file, const struct cache_origin *origin,
                              const char *name, struct log log);
// Adds the records, which must be of the same origin, to an empty cache. SATIN_ERROR_INPUT, with
// one logged line, if they are of another order or far outside the scene; or SATIN_ERROR_MEMORY.
satin_status cache_load(struct cache *cache, const struct cache_file *file, const char *name,
                        struct log log);

// The contents of a file. Texts are owned by the file.
struct cache_summary {
    struct cache_origin origin;
    uint64_t rays;                // gather rays of all records
    int order;                    // of radiance records
    size_t irradiance, radiance;  // numbers of records
};
struct cache_summary cache_file_summary(const struct cache_file *file);
// R of record i, and its scale: its own accuracy over a of the options, in (0, 1].
void cache_file_record(const struct cache_file *file, enum cache_kind kind, size_t i, float *R,
                       float *scale);

// ---- Counts, for statistics and the density layer -----------------------------------------------

size_t cache_count(const struct cache *cache, enum cache_kind kind);
// The number of gather rays of all records.
uint64_t cache_rays(const struct cache *cache);
// Position, normal and R of record i of a kind, in the order in which records were made.
void cache_record(const struct cache *cache, enum cache_kind kind, size_t i, vec3 *p, vec3 *n,
                  float *R);
void cache_statistics(const struct cache *cache, struct stats *stats);

#endif
