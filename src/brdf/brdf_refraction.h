// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: rough dielectric boundaries [Walter et al. 2007], whose facets reflect and
// refract. The formulas are the same above and below the surface, with the inverse IOR, so
// everything is computed with wo above.
#ifndef BRDF_REFRACTION_H
#define BRDF_REFRACTION_H

#include "brdf/brdf_microfacet.h"

// A boundary for light that leaves on wo's side: eta is the IOR of the other side over that of
// wo's.
struct refraction {
    struct microfacet facets;
    float eta;
};

// Mirrors both directions at the surface if wo is below. `ior` is that below over that above.
struct refraction brdf_refraction_at(struct microfacet facets, float ior, vec3 *wo, vec3 *wi);

// f_t [sr^-1] without colour, for wo above and wi below.
float brdf_refraction_value(const struct refraction *at, vec3 wo, vec3 wi, enum brdf_mode mode);
// The density with which refraction at a visible facet draws wi; *f is set to the reflectance of
// the facet. 0 if no facet refracts wo to wi.
float brdf_refraction_pdf(const struct refraction *at, vec3 wo, vec3 wi, float *f);
// Refracts or reflects wo at the facet n. False if the result is on the wrong side.
bool brdf_refraction_follow(const struct refraction *at, vec3 wo, vec3 n, bool refract, vec3 *wi);

#endif
