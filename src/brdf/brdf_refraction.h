// SPDX-License-Identifier: Apache-2.0
// Rough dielectric boundaries [Walter et al. 2007]: facets that reflect and refract. What holds
// above the surface holds below it with the inverse index, so everything is computed with wo above.
// Private to brdf/.
#ifndef BRDF_REFRACTION_H
#define BRDF_REFRACTION_H

#include "brdf/brdf_microfacet.h"

// A boundary for light that leaves on wo's side: eta is the IOR of the other side over that of
// wo's.
struct refraction {
    struct microfacet facets;
    float eta;
};

// Mirrors both directions at the surface if wo is below; `ior` is the index below over that above.
struct refraction refraction_at(struct microfacet facets, float ior, vec3 *wo, vec3 *wi);

// f_t [sr^-1] without colour, for wo above and wi below.
float refraction_value(const struct refraction *at, vec3 wo, vec3 wi, enum brdf_mode mode);
// Density with which refraction at a visible facet draws wi; *f gets the facet's reflectance. 0 if
// no facet refracts wo into wi.
float refraction_pdf(const struct refraction *at, vec3 wo, vec3 wi, float *f);
// Refracts or reflects wo at the facet n; false if the light does not arrive on the right side.
bool refraction_follow(const struct refraction *at, vec3 wo, vec3 n, bool refract, vec3 *wi);

#endif
