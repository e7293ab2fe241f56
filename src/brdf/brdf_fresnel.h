// SPDX-License-Identifier: Apache-2.0
// Fresnel reflectance of smooth boundaries, for unpolarised light. Private to brdf/.
#ifndef BRDF_FRESNEL_H
#define BRDF_FRESNEL_H

#include "base/vec.h"

// The fraction that a boundary between dielectrics reflects [Born and Wolf, 1.5.2]. `cos_i` is the
// signed cosine to the normal, negative inside; `ior` is that of the inside over that of the
// outside. *cos_t (may be NULL) is set to the cosine of the refracted direction to the normal,
// whose sign is opposite to that of cos_i, or to 0 for total reflection.
static inline float brdf_fresnel_dielectric(float cos_i, float ior, float *cos_t) {
    float eta = cos_i >= 0.0f ? ior : 1.0f / ior;
    float ci = fabsf(cos_i), eta2 = eta * eta;
    float ct2 = 1.0f - (1.0f - ci * ci) / eta2;
    float ct = ct2 > 0.0f ? sqrtf(ct2) : 0.0f;
    if (cos_t) *cos_t = cos_i >= 0.0f ? -ct : ct;
    if (ct2 <= 0.0f || ci == 0.0f) return ior == 1.0f ? 0.0f : 1.0f;
    float s = (ci - eta * ct) / (ci + eta * ct);
    float p = (ct - eta * ci) / (ct + eta * ci);
    return 0.5f * (s * s + p * p);
}

// Reflectance per channel of a conductor with complex index eta + i k relative to the outside, at
// cosine cos_i >= 0.
rgb brdf_fresnel_conductor(float cos_i, rgb eta, rgb k);

// Cosine-weighted hemispherical mean of the dielectric reflectance for light that comes from the
// side where the relative IOR (of the other side over this one) is eta: the fits of Egan and
// Hilgeman 1973 for eta < 1 and of d'Eon and Irving 2011 for eta > 1, accurate to 0.6 % for indices
// below 2.
float brdf_fresnel_diffuse_mean(float eta);

#endif
