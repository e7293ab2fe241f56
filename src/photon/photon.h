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

// What happened to a photon before it was stored: nothing (direct), only ideal specular bounces
// (caustic), or anything else (indirect).
enum photon_class { PHOTON_DIRECT = 0, PHOTON_CAUSTIC, PHOTON_INDIRECT, PHOTON_CLASSES };

// The global and the caustic map. Immutable once built: every function below but those that build
// and free may be called from any thread. Irradiance is in W m^-2, radiance in W m^-2 sr^-1, radii
// in the scene's unit of length; p is a point, n and ng are unit vectors.
struct photon_maps;

// Traces photons and builds both maps. Statistics get photons.* entries. SATIN_CANCELLED if the
// pool was cancelled, or SATIN_ERROR_MEMORY. A scene without lights gives empty maps. The caller
// frees *out.
satin_status photon_maps_build(const struct satin_scene *scene, const satin_options *options,
                               struct parallel *pool, struct log log, struct stats *stats,
                               struct photon_maps **out);
void photon_maps_free(struct photon_maps *maps);  // NULL is allowed

// The first-pass estimate at a surface point: incident irradiance on the side of n (unit), by the
// nearest photon on that side whose irradiance was precomputed. *radius gets the radius of its
// density estimate, by the photons around those of the estimate: what is decided by the radius does
// not depend on the estimate's noise. E includes direct light unless options->gather_direct was set
// when the maps were built. Black and radius INFINITY where no photon is near that faces as n does
// and is not behind a wall.
rgb photon_irradiance(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p,
                      vec3 n, float *radius, int *entry);
// photon_irradiance where the path from the eye has `bounces` segments more than to the hit of a
// gather ray: without photons that have bounced so often that the whole path would be longer than
// the longest. For more than one the part of the light that is left out is taken to be the same of
// each.
rgb photon_irradiance_behind(const struct photon_maps *maps, const struct satin_scene *scene,
                             vec3 p, vec3 n, int bounces, float *radius, int *entry);
// For many points; arrays of `count`. `entry` gets the number of the precomputed entry that
// answered for the point's surroundings, or -1 if there is none as near as photons stand around it.
void photon_irradiance_many(const struct photon_maps *maps, const struct satin_scene *scene,
                            size_t count, const vec3 *p, const vec3 *n, rgb *E, float *radius,
                            int *entry);
// Where irradiance was precomputed: the number of entries, and the position and unit normal of one.
size_t photon_irradiance_count(const struct photon_maps *maps);
void photon_irradiance_position(const struct photon_maps *maps, size_t entry, vec3 *p, vec3 *n);
rgb photon_irradiance_at(const struct photon_maps *maps, size_t entry);
// The area around an entry where points are nearer to it than to others: the mean of entries as
// near to each other as those around it [square of the unit of length].
float photon_irradiance_area(const struct photon_maps *maps, size_t entry);
// Whether gather rays read direct light that is precomputed at the entries.
static inline bool photon_precomputes_direct(const satin_options *o) {
    return o->integrator == SATIN_TWO_PASS && o->first_pass == SATIN_FIRST_PRECOMPUTED &&
           o->gather_direct;
}
// Luminance of the direct photons that came down on that area: their power's sum [W] and the sum of
// its squares. None unless options->gather_direct was set when the maps were built.
struct photon_direct {
    float power, power2;
};
struct photon_direct photon_direct_at(const struct photon_maps *maps, size_t entry);
// The PHOTON_AROUND entries nearest to one, itself among them; those that there are not are -1.
enum { PHOTON_AROUND = 9 };
void photon_irradiance_around(const struct photon_maps *maps, size_t entry,
                              int around[PHOTON_AROUND]);

// Irradiance by caustic photons, from the caustic map.
rgb photon_caustic_irradiance(const struct photon_maps *maps, const struct satin_scene *scene,
                              vec3 p, vec3 n);

// The maximum lookup radius: an estimate of a larger one blurs over a good part of what is seen,
// and is not reliable.
float photon_lookup_max(const struct photon_maps *maps);

// Reflected radiance towards wo (local) by a k-nearest density estimate with the BRDF's smooth
// `lobes`, from the global map (all classes it holds) or the caustic map. frame is the BRDF's; ng
// the geometric normal on wo's side. *radius gets the radius of the estimate: INFINITY, and the
// radiance is black, where the map has fewer photons than an estimate takes.
rgb photon_radiance(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p,
                    vec3 ng, const struct frame *frame, const struct brdf *brdf, vec3 wo,
                    unsigned lobes, float *radius);
// Light beside a caustic: luminance L that the point reflects of it, and a random number u in
// [0, 1), by which a caustic that is faint beside it is looked at; L 0: it always is.
struct photon_beside {
    float L, u;
};
#define PHOTON_ALONE ((struct photon_beside){0.0f, 0.0f})
// Radiance of the caustic map's photons that the smooth `lobes` reflect towards wo; arguments as of
// photon_radiance.
rgb photon_caustic(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p, vec3 ng,
                   const struct frame *frame, const struct brdf *brdf, vec3 wo, unsigned lobes,
                   struct photon_beside beside);

// The clusters of photons where light comes down densely; NULL: none. They belong to the maps;
// `maps` may be NULL.
const struct guide_clusters *photon_clusters(const struct photon_maps *maps);

#endif
