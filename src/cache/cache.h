// SPDX-License-Identifier: Apache-2.0
// The caches of the second pass: irradiance records on diffuse surfaces [Ward 1988, Ward and
// Heckbert 1992], incident radiance records on glossy ones [K05 3]. First they are filled at sites,
// in deterministic batches on all threads; then they are frozen and read. Positions and radii are
// in scene units, directions are unit and in world space unless a comment says otherwise.
// Letters: a accuracy (the error that a record may have and still serve), R record radius (harmonic
// mean distance, clamped), E irradiance [W m^-2], L radiance [W m^-2 sr^-1], Lambda harmonic
// coefficients of incident radiance.
//
// Threads: cache_fill, cache_adapt, cache_limit_* and cache_load change the cache and are
// called by one thread at a time, while no other uses it; they use the pool themselves. All
// functions that take a const cache may be called by any number of threads at once.
#ifndef CACHE_CACHE_H
#define CACHE_CACHE_H

#include "base/log.h"
#include "base/stats.h"
#include "gather/gather.h"
#include "rsh/rsh.h"

struct cache;

// The two sides of the cache: each kind of record has its own options and its own octree.
enum cache_kind { CACHE_IRRADIANCE, CACHE_RADIANCE, CACHE_KINDS };

// The glossy lobes of a surface point as the eye sees them.
struct cache_view {
    struct brdf brdf;                // with a factor `specular` of 1
    const struct brdf_range *table;  // of its harmonics; NULL: nothing is glossy, or not cached
    int channels;                    // of the table: 1 or 3
    uint32_t name;                   // see cache_lobe; 0: no record keeps a residual of it
    vec3 wo;                         // towards the eye, in the site's frame
};

// A surface point where a record may be made, and what the surface reflects there. Bump and normal
// maps are left out, since they spend no records. 336 bytes.
struct cache_site {
    vec3 p;                  // where the record is made, off the edges of its triangle
    vec3 ng;                 // geometric normal on the side that is seen
    struct frame frame;      // shading frame; n on the same side
    float pixel;             // width of a projected pixel at p, across the line of sight; > 0
    uint64_t stream;         // random stream, unique to the site
    uint8_t wants;           // kinds of records that the surface reads: a mask of 1 << cache_kind
    struct cache_view view;  // all zero: the eye does not see the site
    // What only cache_adapt asks for:
    vec3 shading_p;  // the point that the eye sees; p is this one, moved off an edge
    rgb diffuse;     // BRDF of the diffuse lobe [sr^-1]
    rgb specular;    // factor of the glossy lobes
    float direct;    // luminance of the direct light that is reflected towards the eye
};

// Empty caches. `order` is the order of radiance records, at most RSH_MAX_ORDER; 0 if none will be
// made. The pool's size fixes the scratch. NULL without memory. What `g` points to must outlive the
// cache, and the pool too. The options of struct cache_options are copied.
struct cache *cache_new(const struct gather *g, int order, struct parallel *pool);
void cache_free(struct cache *cache);  // NULL is allowed

// Makes records of a kind until every site that wants them is covered with accuracy a. It takes
// uncovered sites in the order given, in batches whose members lie apart, gathers each batch on all
// threads against the frozen cache, and inserts the records in order: they depend on the sites and
// the options, not on the threads. Radiance records are made only if the cache's order is above 0.
// SATIN_CANCELLED if the pool's progress function stopped a loop, or SATIN_ERROR_MEMORY: then the
// records of the batches before are there.
struct cache_fill {
    const struct cache_site *site;  // read only; NULL if count is 0
    size_t count;
    float a;        // > 0
    float widest;   // records will be read at accuracies up to this times the options' a; >= 1
    float spacing;  // of sites, in pixels: members of a batch are farther apart than this
    bool adapted;   // new records take their scale from the nearest one [K05 6.3.2]
};
satin_status cache_fill(struct cache *cache, enum cache_kind kind, const struct cache_fill *fill);

// New records get this fraction, in (0, 1], of the gather rays that the options say.
// SATIN_ERROR_MEMORY: then a side may keep the rays that it had.
satin_status cache_limit_rays(struct cache *cache, float fraction);
// New records of a kind get this fraction, in (0, 1], of the least radius that the options say.
void cache_limit_radius(struct cache *cache, enum cache_kind kind, float fraction);

// ---- Reading (cache_read.c) ---------------------------------------------------------------------

// Where interpolated light is wanted.
struct cache_lookup {
    vec3 p, n;              // the surface's point and its normal without bump and normal maps
    struct frame frame;     // of the BRDF; its n is what those maps make of the normal
    float fallback_radius;  // where no record is accurate enough the nearest one that is no
                            // farther away serves; 0: none does
};

// Sums over the records that an interpolation used. A fallback record has weight 1.
struct cache_used {
    int count;
    float weight;
    float a, rays;  // the record's own accuracy and its gather rays, each times its weight
};
static inline struct cache_used cache_used_add(struct cache_used x, struct cache_used y) {
    return (struct cache_used){x.count + y.count, x.weight + y.weight, x.a + y.a, x.rays + y.rays};
}

// Interpolated irradiance on a facet of normal frame.n at accuracy a [K05 (2.2)]. If no record
// serves, count is 0 and *E is untouched.
struct cache_used cache_irradiance(const struct cache *cache, const struct cache_lookup *at,
                                   float a, rgb *E);

// What a glossy surface reflects of the interpolated radiance [K05 (3.2), (3.3)].
struct cache_lobe {
    const float *C;  // BRDF coefficients in the lookup's frame: channels * order^2
    int order;       // at most the cache's; 0: nothing is glossy
    int channels;    // 1 or 3
    // By these a record recognizes what it knows the residual of (cache_residual.c).
    uint32_t name;  // equal for equal BRDFs, but for their factor; 0: it has none
    vec3 mirror;    // see cache_mirror
};
// The direction, in world space, that an ideal mirror would show along wo, which is given in the
// frame.
static inline vec3 cache_mirror(const struct frame *frame, vec3 wo) {
    return frame_to_world(frame, v3(-wo.x, -wo.y, wo.z));
}
// Radiance that the lobe reflects, without the BRDF's factor `specular`; and E, the irradiance from
// the same records. Where lobe is NULL *glossy is untouched, and may be NULL; E may be NULL. If no
// record serves, count is 0 and both are untouched.
struct cache_used cache_radiance(const struct cache *cache, const struct cache_lookup *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E);
// Whether the position of a record of any kind is within `radius` of p, on a surface that faces
// alike.
bool cache_has_record_near(const struct cache *cache, vec3 p, vec3 n, float radius);

// ---- Adaptive caching [K05 6.3] (cache_adapt.c) ----------------------------------------------

// Adapts the records of a kind to the sites of a fill that is done: where records that are read at
// accuracy read_a disagree visibly, the scales of the farthest are lowered, and new ones fill the
// gaps, until none disagree. Status as of cache_fill.
satin_status cache_adapt(struct cache *cache, enum cache_kind kind, const struct cache_fill *fill,
                         float read_a);

// ---- Files of records (cache_file.c, docs/formats.md) -------------------------------------------

// The first 8 bytes. Line breaks are among them, so that a transfer as text shows.
#define CACHE_FILE_MAGIC "\211satin\r\n"

// What records were made for.
struct cache_origin {
    uint64_t world;  // hash of the scene
    uint64_t
        view;  // hash of camera, film and seed; 0 after a time limit, as more records would serve
    const char *options;  // those that decide records: `name=value`, separated by spaces
};

// Writes all records, so that the file appears whole or not at all. The status of writing, with one
// logged line.
satin_status cache_save(const struct cache *cache, const struct cache_origin *origin,
                        const char *path, struct log log);

// The bytes of a file, checked; `name` is for messages. SATIN_ERROR_INPUT with one logged line if
// they are damaged. The caller frees *file; `data` must outlive it.
struct cache_file;
satin_status cache_file_parse(const void *data, size_t size, const char *name, struct log log,
                              struct cache_file **file);
void cache_file_free(struct cache_file *file);  // NULL is allowed
// SATIN_ERROR_INPUT, with one logged line, if the records are of another origin, but for the view.
satin_status cache_file_check(const struct cache_file *file, const struct cache_origin *origin,
                              const char *name, struct log log);
// Adds the records, of the same origin, to a cache that has none. SATIN_ERROR_INPUT, with one
// logged line, if they are of another order or lie far outside the scene; SATIN_ERROR_MEMORY.
satin_status cache_load(struct cache *cache, const struct cache_file *file, const char *name,
                        struct log log);

// What a file holds. Texts belong to the file.
struct cache_summary {
    struct cache_origin origin;
    uint64_t rays;                // gather rays of all records
    int order;                    // of radiance records
    size_t irradiance, radiance;  // records
};
struct cache_summary cache_file_summary(const struct cache_file *file);
// R of record i, and its scale: its own accuracy over the options' a, in (0, 1].
void cache_file_record(const struct cache_file *file, enum cache_kind kind, size_t i, float *R,
                       float *scale);

// ---- Counts, for statistics and the density layer -----------------------------------------------

size_t cache_count(const struct cache *cache, enum cache_kind kind);
// Gather rays of all records.
uint64_t cache_rays(const struct cache *cache);
// Position, normal and R of record i of a kind, in order of creation.
void cache_record(const struct cache *cache, enum cache_kind kind, size_t i, vec3 *p, vec3 *n,
                  float *R);
void cache_statistics(const struct cache *cache, struct stats *stats);

#endif
