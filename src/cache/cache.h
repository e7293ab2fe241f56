// SPDX-License-Identifier: Apache-2.0
// The caches of the second pass: irradiance records on diffuse surfaces [Ward 1988, Ward and
// Heckbert 1992], incident radiance records on glossy ones [K05 3]. First they are filled at sites,
// in deterministic batches on all threads; then they are frozen and read. Letters: a accuracy, R
// record radius (harmonic mean distance, clamped), E irradiance, Lambda harmonic coefficients of
// incident radiance.
#ifndef CACHE_CACHE_H
#define CACHE_CACHE_H

#include "base/log.h"
#include "base/stats.h"
#include "gather/gather.h"
#include "rsh/rsh.h"

struct cache;

// The two sides of the cache.
enum cache_kind { CACHE_IRRADIANCE, CACHE_RADIANCE, CACHE_KINDS };

// The glossy lobes of a surface point as the eye sees them.
struct cache_view {
    struct brdf brdf;                // with a factor `specular` of 1
    const struct brdf_range *table;  // of its harmonics; NULL: it has none
    int channels;                    // of the table: 1 or 3
    uint32_t name;                   // see cache_lobe; 0: no record keeps a residual of it
    vec3 wo;                         // unit, towards the eye, in the site's frame
};

// A surface point where a record may be made, and what the surface reflects there. Maps that bend
// the normal are left out, since they spend no records. 336 bytes.
struct cache_site {
    vec3 p;              // where the record is made; may lie off an edge that `seen` is near to
    vec3 ng;             // geometric normal on the side that is seen
    struct frame frame;  // shading frame; n on the same side
    float pixel;      // width of a projected pixel at p, across the line of sight, in scene units
    uint64_t stream;  // random stream, unique to the site
    uint8_t wants;    // mask of 1 << cache_kind
    struct cache_view view;  // table NULL: nothing is known of the eye, or nothing is glossy
    // For cache_converge alone:
    vec3 seen;     // the surface point that the eye sees
    rgb diffuse;   // BRDF of the diffuse lobe [1 / sr]
    rgb specular;  // factor of the glossy lobes
    float direct;  // luminance of the direct light that is reflected towards the eye
};

// Caches with room for no record yet. `order` is the order of radiance records, 0 if none will be
// asked for. The pool's size fixes the scratch. NULL without memory. The scene and options in g
// must outlive the cache.
struct cache *cache_new(const struct gather *g, int order, struct parallel *pool);
void cache_free(struct cache *cache);  // NULL is allowed

// Makes records of a kind until every site that wants them is covered with accuracy a: takes
// uncovered sites in the order given, in batches whose members lie apart, gathers each batch on all
// threads against the frozen cache, inserts in order. SATIN_CANCELLED if the pool's progress
// function stopped it: then the records of all batches before are there. SATIN_ERROR_MEMORY.
struct cache_fill {
    const struct cache_site *site;
    size_t count;
    float a;
    float widest;   // records will be read at accuracies up to this times the options' a
    float spacing;  // of sites, in pixels: members of a batch are farther apart than this
    bool adapted;   // new records take their scale from the nearest one [K05 6.3.2]
};
satin_status cache_fill(struct cache *cache, enum cache_kind kind, const struct cache_fill *fill);

// New records get this fraction, in (0, 1], of the gather rays that the options say.
// SATIN_ERROR_MEMORY.
satin_status cache_limit_rays(struct cache *cache, float fraction);

// Where interpolated light is wanted.
struct cache_lookup {
    vec3 p, n;           // the surface's point and normal,
    struct frame frame;  // the BRDF's frame, of the same normal unless bumps turned it
    float reach;         // without a record of the accuracy asked for the nearest up to here serves
};

// The records that an interpolation used: sums over them. One that serves for want of a better one
// weighs 1.
struct cache_used {
    int count;
    float weight;
    float a, rays;  // the record's own accuracy and its gather rays, each times its weight
};
static inline struct cache_used cache_used_add(struct cache_used x, struct cache_used y) {
    return (struct cache_used){x.count + y.count, x.weight + y.weight, x.a + y.a, x.rays + y.rays};
}

// Interpolated irradiance on a facet of normal frame.n at accuracy a [K05 (2.2)]; count is 0 if no
// record is near enough: then *E is untouched.
struct cache_used cache_irradiance(const struct cache *cache, const struct cache_lookup *at,
                                   float a, rgb *E);

// What a glossy surface reflects of the interpolated radiance [K05 (3.2), (3.3)].
struct cache_lobe {
    const float *C;  // BRDF coefficients in `frame`: channels * order^2
    int order;       // at most the cache's
    int channels;    // 1 or 3
    // By these a record recognizes what it knows the residual of (cache_residual.c).
    uint32_t name;  // equal for equal BRDFs, but for their factor; 0: none
    vec3 mirror;    // see cache_mirror
};
// The direction in world space in which an ideal mirror would show what it reflects along wo, which
// is given in the frame.
static inline vec3 cache_mirror(const struct frame *frame, vec3 wo) {
    return frame_to_world(frame, v3(-wo.x, -wo.y, wo.z));
}
// lobe may be NULL: then *glossy is untouched. E, the irradiance from the same records, may be
// NULL.
struct cache_used cache_radiance(const struct cache *cache, const struct cache_lookup *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E);
// Whether a record of any kind stands within `reach` of p, on a surface that faces alike.
bool cache_stands(const struct cache *cache, vec3 p, vec3 n, float reach);

// ---- Adaptive caching [K05 6.3] (cache_converge.c) ---------------------------------------------

// Full convergence of a kind of records for the sites of a fill that is done: where records that
// are read at accuracy read_a disagree visibly, the farthest give way, and new ones fill the gaps,
// until none disagree. Status as of cache_fill.
satin_status cache_converge(struct cache *cache, enum cache_kind kind,
                            const struct cache_fill *fill, float read_a);

// ---- Files of records (cache_file.c, docs/formats.md) -------------------------------------------

// The first 8 bytes. Line breaks are among them, so that a transfer as text shows.
#define CACHE_FILE_MAGIC "\211satin\r\n"

// What records were made for.
struct cache_origin {
    uint64_t world;       // the scene's hash
    uint64_t view;        // of camera, film and seed, if all that they need is there; else 0
    const char *options;  // those that decide records: `name=value`, parted by blanks
};

// Writes all records, so that the file appears whole or not at all.
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
// Adds the records, of the same origin, to a cache that has none.
satin_status cache_load(struct cache *cache, const struct cache_file *file, const char *name,
                        struct log log);

// What a file holds. Texts belong to the file.
struct cache_summary {
    struct cache_origin origin;
    uint64_t rays;
    int order;                    // of radiance records
    size_t irradiance, radiance;  // records
};
struct cache_summary cache_file_summary(const struct cache_file *file);
// R and scale (a_i as a part of a) of record i.
void cache_file_record(const struct cache_file *file, enum cache_kind kind, size_t i, float *R,
                       float *scale);

// ---- Counts, for statistics and the density layer -----------------------------------------------

size_t cache_count(const struct cache *cache, enum cache_kind kind);
// Gather rays of all records.
uint64_t cache_rays(const struct cache *cache);
// Position, normal and radius a R = `a` times R of record i of a kind, in order of creation.
void cache_record(const struct cache *cache, enum cache_kind kind, size_t i, vec3 *p, vec3 *n,
                  float *R);
void cache_statistics(const struct cache *cache, struct stats *stats);

#endif
