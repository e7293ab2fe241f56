// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: what rough boundaries between dielectrics transmit and reflect, by single
// scattering: light that other facets mask is lost, as in Mitsuba's tables.
#ifndef BRDF_BOUNDARY_H
#define BRDF_BOUNDARY_H

#include "brdf/brdf_microfacet.h"

enum { BOUNDARY_SIZE = 64 };

// The transmittance of light from outside, at cosines from 0 to 1 of equal distances.
struct boundary_table {
    float transmittance[BOUNDARY_SIZE];
};

// Tabulates the boundary of isotropic facets; ior is that of the inside over that of the outside.
void brdf_boundary_build(struct microfacet facets, float ior, struct boundary_table *out);
// The mean of the transmittance over uniform light from outside.
float brdf_boundary_enters(const struct boundary_table *table);
// The mean reflectance for uniform light from inside.
float brdf_boundary_inside(struct microfacet facets, float ior);

// The transmittance at a cosine from 0 to 1.
static inline float brdf_boundary_transmittance(const struct boundary_table *table, float cosine) {
    float x = cosine * (float)(BOUNDARY_SIZE - 1);
    int i = x < (float)(BOUNDARY_SIZE - 2) ? (int)x : BOUNDARY_SIZE - 2;
    return lerpf(table->transmittance[i], table->transmittance[i + 1], x - (float)i);
}

#endif
