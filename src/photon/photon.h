// SPDX-License-Identifier: Apache-2.0
// The first pass: photons from the lights, and the first-pass radiance estimate that is read from
// them.
#ifndef PHOTON_PHOTON_H
#define PHOTON_PHOTON_H

#include "base/parallel.h"
#include "base/stats.h"
#include "guide/guide.h"
#include "light/light.h"
#include "satin/options.h"
#include "scene/scene.h"

// What has happened to a photon before it was stored: nothing (direct), only ideal specular bounces
// (caustic), or anything else (indirect).
enum photon_class { PHOTON_DIRECT = 0, PHOTON_CAUSTIC, PHOTON_INDIRECT, PHOTON_CLASSES };

// The global and the caustic map, immutable after they are built. Every function below except those
// that build and free may be called from any thread. Irradiance is in W m^-2, radiance in W m^-2
// sr^-1, radii in the scene's unit of length; p is a point, n and ng are unit vectors.
struct photon_maps;

// The numbers of light paths by what their photons are for, and of paths from the eye that show
// what is seen and how to allocate the others (render_budget.h).
struct photon_paths {
    int seen;           // at least 1 and at most GUIDE_SEEN_PATHS_MAX
    uint64_t global;    // the global map
    uint64_t batch;     // of these, the most that are traced at a time
    uint64_t clusters;  // the search for photon clusters; 0: there are no clusters
    uint64_t direct;    // direct photons, which show lit patches between the entries of irradiance
    uint64_t caustic;   // the caustic map
    int emission;       // from each light, a pilot that finds where caustic paths start
    uint64_t emission_most;  // of that pilot from all lights
    int region;              // from the eye, which show where caustics are visible
};

// What the photon maps are made from. Of the options, the numbers of photons are not used.
struct photon_request {
    const struct satin_scene *scene;
    const satin_options *options;
    struct photon_paths paths;
    // Where caustic paths start, from photon_emission_build; NULL: there is no caustic map.
    const struct guide_emission *emission;
    // Where light from infinitely far comes in, for the paths of the global map; NULL: everywhere.
    const struct light_aim *aim;
    // Whether the global map shall be traced again, by other paths, which are set; called with the
    // statistics of its first trace, or of its first batch. NULL: it never is.
    bool (*grow)(void *ctx, struct photon_paths *paths);
    void *grow_ctx;
};

// Finds where caustic paths start by a pilot of them (photon_emission.c). The result is for any
// number of paths. *out is NULL if there are none; the caller frees it by guide_emission_free.
// SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_emission_build(const struct photon_request *request, struct parallel *pool,
                                   struct log log, struct guide_emission **out);

// Traces photons, builds both maps and sets the statistics photons.*. SATIN_CANCELLED if the pool
// was cancelled, or SATIN_ERROR_MEMORY. A scene without lights gives empty maps. The caller frees
// *out.
satin_status photon_maps_build(const struct photon_request *request, struct parallel *pool,
                               struct log log, struct stats *stats, struct photon_maps **out);
void photon_maps_free(struct photon_maps *maps);  // NULL is allowed

// ---- What paths store (photon_stored.c) ---------------------------------------------------------

// The number of photons that a path of the global map stores, in the mean over a few; within a
// tenth. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_count_stored(const struct photon_request *request, struct parallel *pool,
                                 struct log log, double *per_path);

// The most bytes that making the maps needs at any time, per path of each kind.
struct photon_memory {
    double global, clusters, direct, caustic;
};
// Measures it by the photons of a few paths. It depends on the scene and the options, not on the
// threads. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_memory_measure(const struct photon_request *request, struct parallel *pool,
                                   struct log log, struct photon_memory *out);
// The most bytes of so many paths.
double photon_memory_bytes(const struct photon_memory *memory, const struct photon_paths *paths);

// The first-pass estimate at a surface point: the incident irradiance on the side of n (unit) at
// the nearest entry of that side. *radius is set to that of a density estimate from the photons
// around those of the entry's own estimate: it does not depend on the estimate's noise, so
// decisions by it cause no bias. E includes direct light unless options->gather_direct was set when
// the maps were built. E is black and the radius INFINITY if no entry is near that has the
// orientation of n and is not behind a wall.
rgb photon_irradiance_at(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p,
                         vec3 n, float *radius, int *entry);
// The points of many lookups, and their results: arrays of `count`, the caller's.
struct photon_lookups {
    size_t count;
    const vec3 *p, *n;
    // By point: how many segments more than to the hit of a gather ray the path from the eye to it
    // has. Photons that have bounced so often that the whole path would be longer than max_depth
    // are left out. For more than one, their fraction of the light is assumed to be the same for
    // each bounce. NULL: none.
    const int *segments;
    rgb *E;         // as photon_irradiance_at returns it
    float *radius;  // likewise
    int *entry;     // that of the point's surroundings, or -1 if none is as near as the spacing of
                    // the photons; may be NULL
    // Whether the radius is INFINITY where the entry is farther than photons lie, or something that
    // hangs above the surface is between: of light that falls off or ends, E may be much too
    // bright.
    bool strict;
};
// Looks up photon_irradiance_at for many points.
void photon_irradiance_many(const struct photon_maps *maps, const struct satin_scene *scene,
                            const struct photon_lookups *lookups);
// The precomputed entries of irradiance: their number, and the position and unit normal of one.
size_t photon_irradiance_count(const struct photon_maps *maps);
void photon_irradiance_position(const struct photon_maps *maps, size_t entry, vec3 *p, vec3 *n);
rgb photon_irradiance_of_entry(const struct photon_maps *maps, size_t entry);
// The mean area in which an entry is the nearest one, from the distances of the entries around it
// [square of the unit of length].
float photon_irradiance_area(const struct photon_maps *maps, size_t entry);
// The radius of the disc of the photons from which an entry was estimated.
float photon_irradiance_radius(const struct photon_maps *maps, size_t entry);
// Finds entries around one, of a similar normal and nearer than `distance`, among them itself: the
// PHOTON_NEAR nearest. Returns their number.
enum { PHOTON_NEAR = 64 };
size_t photon_irradiance_near(const struct photon_maps *maps, size_t entry, float distance,
                              int row[PHOTON_NEAR], float distance2[PHOTON_NEAR]);
// Sets the irradiance of an entry, which no other thread may read meanwhile. The fraction of its
// light that has bounced as often as max_depth allows stays.
void photon_irradiance_replace(struct photon_maps *maps, size_t entry, rgb E);
// Whether gather rays read the entries of irradiance.
static inline bool photon_precomputes(const satin_options *o) {
    return o->integrator == SATIN_TWO_PASS &&
           (o->first_pass == SATIN_FIRST_PRECOMPUTED || o->first_pass == SATIN_FIRST_REVERSE);
}
// Whether photons are traced in batches, of which each is added to the entries.
static inline bool photon_streams(const satin_options *o) {
    return o->integrator == SATIN_TWO_PASS && o->first_pass == SATIN_FIRST_REVERSE;
}
// Whether gather rays read direct light that was precomputed at the entries.
static inline bool photon_precomputes_direct(const satin_options *o) {
    return photon_precomputes(o) && o->gather_direct;
}
// The direct photons in that area: the sum of their power [W] in luminance, and the sum of its
// squares. There are none unless options->gather_direct was set when the maps were built.
struct photon_direct {
    float power, power2;
};
struct photon_direct photon_direct_at(const struct photon_maps *maps, size_t entry);
// The PHOTON_AROUND entries nearest to an entry, including itself. Missing ones are -1.
enum { PHOTON_AROUND = 9 };
void photon_irradiance_around(const struct photon_maps *maps, size_t entry,
                              int around[PHOTON_AROUND]);

// The variance of an irradiance estimate from the global map, over its square: the mean over a few
// entries. It is the noise of the photons alone, without the bias of a lookup's width. 0: there are
// no photons, or integrator photons shows them.
float photon_noise2(const struct photon_maps *maps);

// The fraction of the power of all photons that is of caustics, in [0, 1].
double photon_caustic_fraction(const struct photon_maps *maps);

// The maximum lookup radius. An estimate of a larger radius blurs a large part of the visible
// scene, and is not reliable.
float photon_lookup_max(const struct photon_maps *maps);

// The radiance that the smooth `lobes` of a point reflect to its viewer, by a k-nearest density
// estimate from the global map (of the classes it holds) or the caustic map. *radius is set to that
// of the estimate. It is INFINITY, and the radiance is black, if the map has fewer photons than an
// estimate needs. Photons that have bounced more often than `bounces` are left out; negative: none.
rgb photon_radiance(const struct photon_maps *maps, const struct satin_scene *scene,
                    const struct shading_point *point, unsigned lobes, int bounces, float *radius);
// Other light beside a caustic: the luminance L that the point reflects of it, and a random number
// u in [0, 1) for skipping the lookup of caustics that are faint beside it. L 0: never skip it.
struct photon_other_light {
    float L, u;
};
#define PHOTON_ALONE ((struct photon_other_light){0.0f, 0.0f})
// What of the light of caustic photons is asked for.
struct photon_caustic_limits {
    unsigned lobes;  // the smooth lobes that reflect it
    float pdf_most;  // the glossy lobe is left out in directions that it draws with a larger
                     // density [sr^-1]; INFINITY: in none
    int bounces;     // photons that have bounced more often are left out; negative: none
};
// The radiance of it that a point reflects to its viewer.
rgb photon_caustic(const struct photon_maps *maps, const struct satin_scene *scene,
                   const struct shading_point *point, const struct photon_caustic_limits *limits,
                   struct photon_other_light other);
// As photon_caustic at the hit of a gather ray, where a few photons give the directions of light.
rgb photon_caustic_at_hit(const struct photon_maps *maps, const struct satin_scene *scene,
                          const struct shading_point *point,
                          const struct photon_caustic_limits *limits,
                          struct photon_other_light other);

// A narrow cone of directions in which much of the indirect light arrives at a point.
struct photon_beam {
    vec3 axis;
    float versine;   // 1 - cosine of its half angle
    float fraction;  // of the power of the photons around the point
};
enum { PHOTON_BEAMS = 4 };
// The number of segments from the eye to the first surface where photons are read: the hit of a
// gather ray, or what is seen if nothing is gathered there.
static inline int photon_hit_depth(const satin_options *o) {
    return o->integrator == SATIN_TWO_PASS && o->final_gather ? 2 : 1;
}
// Finds the beams at p on the side of n, and returns their number.
int photon_beams(const struct photon_maps *maps, vec3 p, vec3 n,
                 struct photon_beam out[PHOTON_BEAMS]);

// The irradiance from caustic photons, from the caustic map. Those that have bounced more often
// than `bounces` are left out; negative: none.
rgb photon_caustic_irradiance(const struct photon_maps *maps, const struct satin_scene *scene,
                              vec3 p, vec3 n, int bounces, struct photon_other_light other);
// The number of bounces after which a photon still fits into a path of max_depth segments, where
// `after` segments follow the surface where it is stored; negative: no limit.
int photon_bounces_left(const satin_options *options, int after);

// ---- Progressive photon mapping (photon_sppm.c) ------------------------------------------

// The photons of the present pass, and the radii of the first one.
struct photon_sppm;
// Traces the photons from which the radii are found. No pass has begun. Statistics and errors as of
// photon_maps_build; the request must outlive *out, which the caller frees.
satin_status photon_sppm_new(const struct photon_request *request, struct parallel *pool,
                             struct log log, struct stats *stats, struct photon_sppm **out);
void photon_sppm_free(struct photon_sppm *sppm);  // NULL is allowed
// Lets the next pass be the one after so many more, whose photons are not traced.
void photon_sppm_skip(struct photon_sppm *sppm, uint32_t passes);
// Replaces the photons by those of the next pass, which have smaller radii. On failure,
// SATIN_CANCELLED or SATIN_ERROR_MEMORY, the present pass remains.
satin_status photon_sppm_next(struct photon_sppm *sppm, struct parallel *pool, struct log log,
                              struct stats *stats);
// The radiance that the point reflects of the photons. A direction from which a glossy lobe
// reflects too sharply is left out. The point is `depth` path segments and a distance `length` from
// the eye. *indirect is set to whether it is that of all light except direct light; if the photons
// of indirect light are sparse there, which does not differ between passes, it is that of caustics.
rgb photon_sppm_radiance(const struct photon_sppm *sppm, const struct shading_point *point,
                         int depth, float length, bool *indirect);
// The part of a sample's weight that is left out there: by it a path carries the light that is
// otherwise from photons.
rgb photon_sppm_rest(const struct shading_point *point, const struct brdf_sample *sample);

// The photon clusters, owned by the maps; NULL if there are none. `maps` may be NULL.
const struct guide_clusters *photon_clusters(const struct photon_maps *maps);

#endif
