// SPDX-License-Identifier: Apache-2.0
// The first pass: photons from the lights, and the rough solution that is read from them.
#ifndef PHOTON_PHOTON_H
#define PHOTON_PHOTON_H

#include "base/parallel.h"
#include "base/stats.h"
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

// The rough solution at a surface point: incident irradiance on the side of n (unit), by the
// nearest photon on that side whose irradiance was precomputed. *radius gets the radius of its
// density estimate. E includes direct light unless options->gather_shadow was set when the maps
// were built. Black and radius INFINITY where no photon is near that faces as n does and is not
// behind a wall.
rgb photon_irradiance(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p,
                      vec3 n, float *radius);
// The same for many points; arrays of `count`.
void photon_irradiance_many(const struct photon_maps *maps, const struct satin_scene *scene,
                            size_t count, const vec3 *p, const vec3 *n, rgb *E, float *radius);

// The same from the caustic map.
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
rgb photon_caustic(const struct photon_maps *maps, const struct satin_scene *scene, vec3 p, vec3 ng,
                   const struct frame *frame, const struct brdf *brdf, vec3 wo, unsigned lobes);

// What is seen of the lights around p, for sampling direct light.
struct light_seen photon_seen_at(const struct photon_maps *maps, vec3 p);

// ---- Bright places (photon_cones.c) -----------------------------------------------------------

// From where light is gathered.
struct photon_eye {
    vec3 p, n, ng;  // hemisphere about n; geometric normal on the same side
};

// A sphere around a place where light comes down densely, and the directions in which it is seen.
struct photon_place;
struct photon_cone {
    const struct photon_place *place;  // belongs to the maps
    vec3 center, axis;
    float radius, versine;  // of the sphere; 1 - cosine of the half angle
    float E;                // roughly what a white surface there adds to the irradiance [W m^-2]
    float chance;           // roughly that a cosine-weighted ray meets what is bright,
    float filled;           // and that one within the cone does; over 1: more than the cone holds
};
enum { PHOTON_CONES = 48 };

// Cones of the bright places that the eye sees, returned is how many; if there are any, *expected
// gets roughly the irradiance at p by indirect light. Which they are does not depend on what gather
// rays find.
int photon_bright_cones(const struct photon_maps *maps, const struct satin_scene *scene,
                        const struct photon_eye *eye, struct photon_cone out[PHOTON_CONES],
                        float *expected);
// The same for surfaces near p that face anywhere and may see what p does not: photon_cone_move
// makes cones of them. `expected` [W m^-2] is the irradiance there.
int photon_bright_around(const struct photon_maps *maps, vec3 p, float expected,
                         struct photon_cone out[PHOTON_CONES]);
// Changes axis, versine, E and filled to those at p with normal n, as if nothing stood between; E
// is 0 below the horizon. False if p is so near to the sphere that the cone would be wide.
bool photon_cone_move(struct photon_cone *cone, vec3 p, vec3 n);
// Whether the eye sees point i of the PHOTON_PROBES by which the cone's place is probed.
enum { PHOTON_PROBES = 4 };
bool photon_cone_seen(const struct photon_maps *maps, const struct satin_scene *scene,
                      const struct photon_cone *cone, const struct photon_eye *eye, size_t i);

#endif
