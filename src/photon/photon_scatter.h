// SPDX-License-Identifier: Apache-2.0
// Private to photon/: how a surface scatters a photon (photon_scatter.c).
#ifndef PHOTON_SCATTER_H
#define PHOTON_SCATTER_H

#include "base/rng.h"
#include "scene/scene.h"

// A BRDF and its frame, which depend on the direction of the viewer.
struct photon_facet {
    struct brdf brdf;
    struct frame frame;
    float probability;  // with which the directions of its lobes are drawn
};

// A surface that a photon meets.
struct photon_surface {
    const struct satin_scene *scene;
    const struct interaction *s;
    const struct material_side *side;  // the component of the blend
    vec3 wi, n;  // to where the photon comes from; normal of the surface on that side
    struct photon_facet facet[2];  // towards wi; and that of other viewers, if a map mirrors it
    int facets;
};

// A photon's scattered direction wo, and its sample in the frame of the facet that a viewer there
// sees, where it is `wi`. The weight is of the BSDF, without the adjoint's factor.
struct photon_scattered {
    struct brdf_sample sample;
    struct frame frame;
    vec3 wo;
};

// False if the surface scatters nothing.
bool photon_surface_make(const struct satin_scene *scene, const struct interaction *s, vec3 wi,
                         struct photon_surface *out);
// How much more of a photon's power the shading normal of a frame takes than the surface: the
// factor of the adjoint BSDF that does not depend on the scattered direction.
float photon_factor_in(const struct photon_surface *at, const struct frame *frame);
// Draws the direction of a photon by these lobes, BRDF_ALL or BRDF_DELTA. False if it is absorbed.
bool photon_scatter(const struct photon_surface *at, unsigned lobes, struct rng *rng,
                    struct photon_scattered *out);
// The density of wo by the smooth lobes of all that photon_scatter draws [sr^-1].
float photon_scatter_pdf(const struct photon_surface *at, vec3 wo);
// Evaluates the smooth lobes for a direction out->wo that was drawn with this density. False if
// nothing is scattered there. For a surface that does not transmit.
bool photon_scatter_along(const struct photon_surface *at, float pdf, struct photon_scattered *out);

#endif
