// SPDX-License-Identifier: Apache-2.0
// Part of light.h: light through panes. A chain of ideal specular transmissions that ends in its
// first direction, as through a sheet of glass with parallel faces, shifts light but does not
// deflect it. Such light is direct light: light samples look for it, rays that hit it are weighted
// against them, and photons that came that way are direct photons. Every other specular chain makes
// caustics.
#ifndef LIGHT_PANE_H
#define LIGHT_PANE_H

#include "scene/scene.h"

struct light_sample;

// A chain of specular surfaces from its start. Glass changes the distances by whose product light
// falls off [Born and Wolf 1999, 4.6]: a bundle of rays spreads in the plane of incidence as after
// a distance `tangential`, and across it as after a distance `sagittal`.
struct light_chain {
    vec3 d;          // its first direction, unit
    bool transmits;  // whether all surfaces were panes', passed by transmission
    int crossed;     // number of surfaces
    float sagittal, tangential;
    float sagittal_rate, tangential_rate;  // growth of the two per length at the end of the chain
};
struct light_chain light_chain_begin(vec3 d);
// Advances by `length` to the next surface. The next function passes the surface s by the BRDF
// sample `next`, from wo, which is wo_l in the BRDF's frame.
void light_chain_advance(struct light_chain *chain, float length);
void light_chain_pass(struct light_chain *chain, const struct satin_scene *scene,
                      const struct interaction *s, vec3 wo, vec3 wo_l,
                      const struct brdf_sample *next);
// Whether light along the chain, if it continues along d, is direct light.
bool light_chain_straight(const struct light_chain *chain, vec3 d);
// The emitted radiance that the chain meets along d: that of the surface `hit`, or that of the
// environment if it is NULL. The environment is looked up along the first direction of a straight
// chain, as light samples do.
rgb light_chain_emitted(const struct light_chain *chain, const struct satin_scene *scene,
                        const struct interaction *hit, vec3 d);
// The point beside p, the start of the chain, from which the point q at its end would be visible
// along chain->d without panes.
vec3 light_chain_beside(const struct light_chain *chain, vec3 p, vec3 q);
// The factor from the density of drawing q at that point, at distance `dist`, to its density over
// solid angle at p.
float light_chain_density(const struct light_chain *chain, float dist);

// Whether the light of a sample arrives at p, directly or through at most `panes` surfaces of
// panes. Multiplies L by their transmittance, and sets wi and pdf_w to those of the path through
// them.
bool light_arrives(const struct satin_scene *scene, vec3 p, vec3 ng, int panes,
                   struct light_sample *s);

// The emitter that a ray from p in direction d hits, directly or through at most `panes` surfaces
// of panes. False, with *out undefined, if there is none.
struct light_found {
    struct light_chain chain;
    rgb L;                   // arriving radiance
    bool environment;        // whether the emitter is the environment
    struct interaction hit;  // on the emitter, if it is not
};
bool light_find(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d, int panes,
                struct light_found *out);

// Whether some shape may be a pane. light_prepare stores it in scene->panes.
bool light_has_panes(const struct satin_scene *scene);

#endif
