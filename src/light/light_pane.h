// SPDX-License-Identifier: Apache-2.0
// Part of light.h: light through panes. Glass that shifts light but hardly deflects or focuses it,
// as a sheet with parallel faces or the thin wall of a bulb, is a pane. Light through it is direct
// light: light samples look for it, rays that hit it are weighted against them, and photons that
// came that way are direct photons. All other light by specular surfaces is that of caustics.
//
// Which is which is decided by light samples alone: light from a point is direct if a shadow ray
// that is aimed at this point finds its path. So the two never overlap, and together are all light.
#ifndef LIGHT_PANE_H
#define LIGHT_PANE_H

#include "scene/scene.h"

struct light_sample;

// ---- Connections (light_connect.c) --------------------------------------------------------------

// A path from a point o through panes to a point on a light.
struct light_connection {
    vec3 d, exit;  // its first and last direction, unit
    rgb T;         // transmittance
    int crossed;   // number of surfaces of panes
    float spread;  // cross-section of a bundle of rays at its end per solid angle at o, over the
                   // squared distance between the two points; 1: no panes
};
struct light_end {
    vec3 p;
    uint32_t light;  // index of the light
};
// Finds the path from o, which is on no surface, that passes at least one surface of a pane.
// `first`, if not NULL, is the first hit of the straight ray. False, with *out undefined, if the
// search fails, though there may be a path.
bool light_connect(const struct satin_scene *scene, vec3 o, const struct light_end *to,
                   const struct interaction *first, struct light_connection *out);
// The density over solid angle at p with which a light sample is drawn whose connection ends at
// `hit`, on a light; the connection is a straight line if it has not crossed a surface.
float light_connection_pdf(const struct satin_scene *scene, vec3 p,
                           const struct light_connection *connection,
                           const struct interaction *hit);

// Whether the light of a sample arrives at p, directly or through at most `panes` surfaces of
// panes. Multiplies L by their transmittance, and sets wi and pdf_w to those of the path through
// them.
bool light_arrives(const struct satin_scene *scene, vec3 p, vec3 ng, int panes,
                   struct light_sample *s);

// ---- Chains (light_chain.c) ---------------------------------------------------------------------

// A chain of specular surfaces from its start o, which is on no surface, along the ray d.
struct light_chain {
    vec3 o, d;
    bool transmits;  // whether all surfaces were panes', passed by transmission
    bool curved;     // whether one of them was curved
    int crossed;     // number of surfaces
};
struct light_chain light_chain_begin(const struct ray *ray);
// Passes the surface s by the BRDF sample `next`, from wo, which is wo_l in the BRDF's frame.
void light_chain_pass(struct light_chain *chain, const struct satin_scene *scene,
                      const struct interaction *s, vec3 wo, vec3 wo_l,
                      const struct brdf_sample *next);
// Whether the chain, continued along d, brings direct light to its start: from the surface `hit` of
// a light, or from the environment if `hit` is NULL. *out is set to its connection, of which only d
// and `crossed` count for the environment.
bool light_chain_direct(const struct light_chain *chain, const struct satin_scene *scene, vec3 d,
                        const struct interaction *hit, struct light_connection *out);
// Whether a chain that starts at a light brings direct light along d to the surface s.
bool light_chain_brings_direct(const struct light_chain *chain, const struct satin_scene *scene,
                               uint32_t light, vec3 d, const struct interaction *s);
// The emitted radiance that the chain meets along d: that of the surface `hit`, or that of the
// environment if it is NULL. The environment is looked up along the first direction of a straight
// chain, as light samples do.
rgb light_chain_emitted(const struct light_chain *chain, const struct satin_scene *scene,
                        const struct interaction *hit, vec3 d);

// The emitter that a ray from p in direction d hits, directly or through at most `panes` surfaces
// of panes. False, with *out undefined, if there is none, or if its light is not direct.
struct light_found {
    struct light_connection connection;
    rgb L;                   // arriving radiance
    bool environment;        // whether the emitter is the environment
    struct interaction hit;  // on the emitter, if it is not
};
bool light_find(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d, int panes,
                struct light_found *out);

// ---- Panes (light_pane_find.c) ------------------------------------------------------------------

// Sets scene->panes, whether some shape may be a pane, and `deflects_little` of its shapes. To be
// called after scene_trace_build.
void light_find_panes(struct satin_scene *scene);

#endif
