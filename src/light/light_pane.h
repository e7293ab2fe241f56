// SPDX-License-Identifier: Apache-2.0
// Part of light.h: light through panes. A chain of ideal specular transmissions that ends in the
// direction it began with, as through a sheet of glass with parallel faces, shifts light but does
// not deflect it. Such light is direct light: light samples look for it, rays that find it are
// weighed against them, and photons that came so are direct photons. Every other specular chain
// makes caustics.
#ifndef LIGHT_PANE_H
#define LIGHT_PANE_H

#include <stdbool.h>

#include "base/vec.h"

struct brdf_sample;
struct light_sample;
struct ray;
struct satin_scene;
struct interaction;

// A chain of specular surfaces so far, from where it began. The distance whose square divides light
// is changed by glass [Born and Wolf 1999, 4.6]: a bundle of rays spreads in the plane of incidence
// as if it had gone a distance of `tangential`, across it `sagittal`.
struct light_chain {
    vec3 d;          // its first direction, unit
    bool transmits;  // all surfaces were panes', passed by transmission
    int crossed;     // how many
    float sagittal, tangential;
    float sagittal_rate, tangential_rate;  // by which they grow per length where the chain is now
};
struct light_chain light_chain_begin(vec3 d);
// Goes `length` to the next surface, and passes s by `next`: as from wo, in the BRDF's frame
// wo_l.
void light_chain_advance(struct light_chain *chain, float length);
void light_chain_pass(struct light_chain *chain, const struct satin_scene *scene,
                      const struct interaction *s, vec3 wo, vec3 wo_l,
                      const struct brdf_sample *next);
// Whether light along the chain that goes on along d is direct light.
bool light_chain_straight(const struct light_chain *chain, vec3 d);
// Radiance of the emitter that the chain meets, going on along d: `hit` is the surface interaction
// on it, NULL for the environment, which is met along the first direction of a straight chain, as
// light samples see it.
rgb light_chain_emitted(const struct light_chain *chain, const struct satin_scene *scene,
                        const struct interaction *hit, vec3 d);
// From where the point q at the chain's end would be visible along chain->d without panes, beside
// the point p where it began.
vec3 light_chain_beside(const struct light_chain *chain, vec3 p, vec3 q);
// The density over solid angle at p of drawing q, over the density at that point, at distance
// `dist` from q.
float light_chain_density(const struct light_chain *chain, float dist);

// Whether the light of a sample arrives at p, directly or through at most `panes` surfaces of
// panes: multiplies L by what they transmit, and sets wi and pdf_w to the path through them.
bool light_arrives(const struct satin_scene *scene, vec3 p, vec3 ng, int panes,
                   struct light_sample *s);

// The emitter that a ray from p in direction d meets, directly or through at most `panes` surfaces
// of panes.
struct light_found {
    struct light_chain chain;
    rgb L;  // that arrives
};
// *hit is filled if true is returned and *environment is false.
bool light_find(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d, int panes,
                struct interaction *hit, bool *environment, struct light_found *out);

// Whether a ray of light meets a specular surface that makes a caustic of it: another than panes.
bool light_makes_caustic(const struct satin_scene *scene, struct ray ray);

// Whether some shape may be a pane. light_prepare keeps it in scene->panes.
bool light_has_panes(const struct satin_scene *scene);

#endif
