// SPDX-License-Identifier: Apache-2.0
// The caches of the second pass: irradiance records on diffuse surfaces [Ward 1988, Ward and
// Heckbert 1992], and incident radiance records on glossy ones [K05 3]. This folder keeps records
// and reads them; folder fill makes them. Positions and radii are in scene units; directions are
// unit vectors in world space unless a comment says otherwise. Symbols: a accuracy (the largest
// error with which a record is used), R record radius (harmonic mean distance, clamped), E
// irradiance [W m^-2], L radiance [W m^-2 sr^-1], Lambda harmonic coefficients of incident
// radiance.
//
// Threads: cache_value_new, cache_insert_* and cache_load change the cache and must be called by
// one thread at a time, while no other uses it. All functions that take a const cache may be called
// by any number of threads at once.
#ifndef CACHE_CACHE_H
#define CACHE_CACHE_H

#include "base/log.h"
#include "base/stats.h"
#include "cache/cache_taylor.h"
#include "rsh/rsh.h"

// Makes empty caches. `order` is the order of radiance records, at most RSH_MAX_ORDER; 0 if there
// will be none. NULL if there is no memory. The scene and the options must outlive the cache; what
// struct cache_options has of them is copied.
struct cache *cache_new(const struct satin_scene *scene, const satin_options *options, int order);
void cache_free(struct cache *cache);  // NULL is allowed

// ---- Reading (cache_read.c) ---------------------------------------------------------------------

// Sums over the records of an interpolation.
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
    uint32_t number;  // equal for BRDFs that are equal up to their factor; 0: it has none
    vec3 mirror;      // see cache_mirror
};
// The direction, in world space, that an ideal mirror shows along wo, which is in the frame.
static inline vec3 cache_mirror(const struct frame *frame, vec3 wo) {
    return frame_to_world(frame, v3(-wo.x, -wo.y, wo.z));
}
// Sets *glossy to the radiance that the lobe reflects, without brdf_glossy_factor, and *E
// to the irradiance from the same records. If lobe is NULL, *glossy is unchanged and may be NULL; E
// may be NULL. If no record is near, count is 0 and both are unchanged.
struct cache_used cache_radiance(const struct cache *cache, const struct cache_lookup *at, float a,
                                 const struct cache_lobe *lobe, rgb *glossy, rgb *E);
// Whether a record of any kind is within `radius` of p, on a surface of the same orientation.
bool cache_has_record_near(const struct cache *cache, vec3 p, vec3 n, float radius);

// ---- The light of one record (cache_read.c) -----------------------------------------------------

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
// E on a facet of normal `facing` at a point of normal n that has this value: E cos t for a facet
// that is rotated by an angle t, plus a term of the rotation gradient in sin t.
rgb cache_rotate_irradiance(const struct cache_irradiance_value *value, vec3 n, vec3 facing);

// ---- The harmonics of glossy BRDFs (cache_tables.c) ---------------------------------------------

// The tables of a scene, by the index of a material_side; NULL if there are none.
struct cache_tables {
    size_t count;
    struct brdf_range **table;
    bool *owned;    // false: the table is that of an equal BRDF before it
    int *channels;  // of each table: 1 or 3
    int order;      // largest order of all tables; 0: no glossy lobe is cached
};
// Makes the tables on all threads of the pool. SATIN_ERROR_MEMORY, with one logged line, or
// SATIN_CANCELLED: then *out is unchanged.
satin_status cache_tables_build(const struct satin_scene *scene, const satin_options *options,
                                struct parallel *pool, struct log log, struct cache_tables *out);
void cache_tables_free(struct cache_tables *tables);
// The table for a material side, and its number of channels; or NULL.
const struct brdf_range *cache_table(const struct cache_tables *tables,
                                     const struct material_side *side, int *channels);
// Whether textures change more of a side's glossy lobe than its factor.
bool cache_shape_textured(const struct material_side *side);

// ---- Records at a shading point (cache_plan.c) --------------------------------------------------

// What is needed to read records at shading points. Plain data, shared by all threads.
struct cache_reader {
    const struct cache *cache;  // NULL: no records are read
    const struct cache_tables *tables;
    struct cache_options options[CACHE_KINDS];
    float a[CACHE_KINDS];  // accuracies at which records of each kind are read
};
// Reads records at the accuracies of the options.
struct cache_reader cache_reader_make(const struct cache *cache, const struct cache_tables *tables,
                                      const satin_options *options);

// The technique for each lobe at a point.
struct cache_plan {
    unsigned cached;                 // glossy and diffuse lobes from a radiance record
    unsigned diffuse;                // diffuse lobe from irradiance
    unsigned sampled;                // glossy lobes and transmission by importance sampling
    const struct brdf_range *table;  // of the glossy lobe, if it is cached
    int channels;
    float bump;  // fraction of the cached glossy light that bumps leave
};
void cache_plan_make(const struct cache_reader *reader, const struct shading_point *p,
                     struct cache_plan *plan);
// The kinds of records that the plan of a point uses, a mask of 1 << cache_kind; 0: none.
unsigned cache_plan_kinds(const struct cache_reader *reader, const struct shading_point *p);
// Reads from radiance records the light that the glossy lobes reflect, without the factor
// brdf_glossy_factor, and the irradiance, if the plan uses them. If count is 0, both are unchanged.
struct cache_used cache_plan_radiance(const struct cache_reader *reader,
                                      const struct cache_plan *plan, const struct shading_point *p,
                                      const struct cache_lookup *at, rgb *glossy, rgb *E);
// Adds to *L the indirect light that y reflects by the lobes that the records cover. Returns these
// lobes, which are smooth.
unsigned cache_add_reflected(const struct cache_reader *reader, const struct shading_point *y,
                             rgb *L);

// The variance of the luminance that cache_add_reflected adds, by the noise of the records' gather
// rays (cache_noise.c); 0 if no record is near.
float cache_reflected_variance(const struct cache_reader *reader, const struct shading_point *y);

// The point of a cache lookup.
static inline struct cache_lookup cache_lookup_at(const struct shading_point *p) {
    return (struct cache_lookup){p->interaction.p, p->base.n, p->frame, 0.0f};
}
// The number by which records identify a point's glossy lobes; 0 if textures change their shape.
static inline uint32_t cache_lobe_number(const struct shading_point *p) {
    return cache_shape_textured(p->side) ? 0 : (uint32_t)p->side->index + 1;
}
// The fraction of the irradiance that the diffuse lobe reflects, per solid angle.
rgb cache_diffuse_albedo(const struct shading_point *p);

// ---- Files of records (cache_file.c, docs/formats.md) -------------------------------------------

// The first 8 bytes of a file. They include line breaks, so that a transfer as text is detected.
#define CACHE_FILE_MAGIC "\211satin\r\n"

// The scene and options for which records were made.
struct cache_provenance {
    uint64_t world;  // hash of the scene
    // Hash of cameras, film and seed; 0 after a time limit, as more records would be made.
    uint64_t image;
    const char *options;  // those that affect records: `name=value`, separated by spaces
};

// Writes all records. The file appears whole or not at all. Returns the status of writing, with one
// logged line on failure.
satin_status cache_save(const struct cache *cache, const struct cache_provenance *provenance,
                        const char *path, struct log log);

// Checks and parses the bytes of a file; `name` is for messages. SATIN_ERROR_INPUT, with one logged
// line, if they are damaged. The caller frees *file; `data` must outlive it.
struct cache_file;
satin_status cache_file_parse(const void *data, size_t size, const char *name, struct log log,
                              struct cache_file **file);
void cache_file_free(struct cache_file *file);  // NULL is allowed
// SATIN_ERROR_INPUT, with one logged line, if the records are of another provenance. The image may
// differ.
satin_status cache_file_check(const struct cache_file *file,
                              const struct cache_provenance *provenance, const char *name,
                              struct log log);
// Adds the records, which must be of the same provenance, to an empty cache. SATIN_ERROR_INPUT,
// with one logged line, if they are of another order or far outside the scene; or
// SATIN_ERROR_MEMORY.
satin_status cache_load(struct cache *cache, const struct cache_file *file, const char *name,
                        struct log log);

// The contents of a file. Texts are owned by the file.
struct cache_summary {
    struct cache_provenance provenance;
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
size_t cache_count_all(const struct cache *cache);  // of both kinds
// The number of gather rays of all records.
uint64_t cache_rays(const struct cache *cache);
// Position, normal and R of record i of a kind, in the order in which records were made.
void cache_record(const struct cache *cache, enum cache_kind kind, size_t i, vec3 *p, vec3 *n,
                  float *R);
// Bytes of the records and of the octrees.
double cache_bytes(const struct cache *cache);
// Sets the number of bytes, > 0, from which on no more records are made; and whether that is so.
void cache_limit(struct cache *cache, double bytes);
bool cache_full(const struct cache *cache);
void cache_statistics(const struct cache *cache, struct stats *stats);

#endif
