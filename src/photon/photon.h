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

struct photon_maps;  // the global and the caustic map

// Traces photons and builds both maps. Statistics get photons.* entries. SATIN_CANCELLED if the
// pool was cancelled. A scene without lights gives empty maps.
satin_status photon_maps_build(const struct satin_scene *scene, const satin_options *options,
                               struct parallel *pool, struct log log, struct stats *stats,
                               struct photon_maps **out);
void photon_maps_free(struct photon_maps *maps);  // NULL is allowed

// The first-pass estimate at a surface point: incident irradiance on the side of n (unit), by the
// nearest photon on that side whose irradiance was precomputed. *radius gets the radius of its
// density estimate. E includes direct light unless options->gather_shadow was set when the maps
// were built. Black and radius INFINITY where no photon is near that faces as n does and is not
// behind a wall.
rgb photon_irradiance(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p,
                      vec3 n, float *radius);
// photon_irradiance of many points; arrays of `count`.
void photon_irradiance_many(const struct photon_maps *maps, const struct satin_scene *scene,
                            size_t count, const vec3 *p, const vec3 *n, rgb *E, float *radius);

// Irradiance by caustic photons, from the caustic map.
rgb photon_caustic_irradiance(const struct photon_maps *maps, const struct satin_scene *scene,
                              vec3 p, vec3 n);

// An estimate of a larger radius blurs over a good part of what is seen, and should not be
// believed.
float photon_trust(const struct photon_maps *maps);

// Reflected radiance towards wo (local) by a k-nearest density estimate with the BRDF's smooth
// `lobes`, from the global map (all classes it holds) or the caustic map. frame is the BRDF's; ng
// the geometric normal on wo's side. *radius gets the radius of the estimate: INFINITY, and the
// radiance is black, where the map has fewer photons than an estimate takes.
rgb photon_radiance(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p,
                    vec3 ng, const struct frame *frame, const struct brdf *brdf, vec3 wo,
                    unsigned lobes, float *radius);
// Light beside a caustic: luminance that the point reflects of it, and a random number in [0, 1). A
// caustic that is faint beside it is looked at by chance; L 0: always.
struct photon_beside {
    float L, u;
};
#define PHOTON_ALONE ((struct photon_beside){0.0f, 0.0f})
rgb photon_caustic(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p, vec3 ng,
                   const struct frame *frame, const struct brdf *brdf, vec3 wo, unsigned lobes,
                   struct photon_beside beside);

// The clusters of photons where light comes down densely; NULL: none. They belong to the maps;
// `maps` may be NULL.
const struct guide_clusters *photon_clusters(const struct photon_maps *maps);

#endif
