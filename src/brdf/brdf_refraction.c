// SPDX-License-Identifier: Apache-2.0
// Refraction at facets, see brdf_refraction.h.
#include "brdf/brdf_refraction.h"

#include "brdf/brdf_fresnel.h"

struct refraction brdf_refraction_at(struct microfacet facets, float ior, vec3 *wo, vec3 *wi) {
    if (wo->z > 0.0f) return (struct refraction){facets, ior};
    wo->z = -wo->z;
    wi->z = -wi->z;
    return (struct refraction){facets, 1.0f / ior};
}

// The normal of the facet that refracts wo to wi, and its cosines to both, co > 0 > ci. False if
// there is none.
static bool find_facet(const struct refraction *at, vec3 wo, vec3 wi, vec3 *n, float *co,
                       float *ci) {
    vec3 h = v3_mad(wo, at->eta, wi);
    float length = v3_len(h);
    if (!(length > 0.0f)) return false;
    *n = v3_mul(h, (h.z < 0.0f ? -1.0f : 1.0f) / length);
    *co = v3_dot(wo, *n);
    *ci = v3_dot(wi, *n);
    return *co > 0.0f && *ci < 0.0f && n->z > 0.0f;
}

// The solid angle of facets per solid angle of refracted light.
static float jacobian(const struct refraction *at, float co, float ci) {
    return -sqrf(at->eta) * ci / sqrf(co + at->eta * ci);
}

float brdf_refraction_value(const struct refraction *at, vec3 wo, vec3 wi, enum brdf_mode mode) {
    vec3 n;
    float co, ci;
    if (!find_facet(at, wo, wi, &n, &co, &ci)) return 0.0f;
    float t =
        (1.0f - brdf_fresnel_dielectric(co, at->eta, NULL)) * brdf_microfacet_d(at->facets, n);
    t *= brdf_microfacet_g1(at->facets, wo) * brdf_microfacet_g1(at->facets, v3(wi.x, wi.y, -wi.z));
    t *= jacobian(at, co, ci) * co / (wo.z * -wi.z);
    // Radiance is compressed to a smaller solid angle on the denser side.
    return mode == BRDF_RADIANCE ? t / sqrf(at->eta) : t;
}

float brdf_refraction_pdf(const struct refraction *at, vec3 wo, vec3 wi, float *f) {
    vec3 n;
    float co, ci;
    *f = 1.0f;
    if (!find_facet(at, wo, wi, &n, &co, &ci)) return 0.0f;
    *f = brdf_fresnel_dielectric(co, at->eta, NULL);
    if (*f >= 1.0f) return 0.0f;
    float visible =
        brdf_microfacet_d(at->facets, n) * brdf_microfacet_g1_exact(at->facets, wo) * co / wo.z;
    return visible * jacobian(at, co, ci);
}

bool brdf_refraction_follow(const struct refraction *at, vec3 wo, vec3 n, bool refract, vec3 *wi) {
    float co = v3_dot(wo, n), ct;
    if (!(co > 0.0f)) return false;
    if (!refract) {
        *wi = v3_mad(v3_neg(wo), 2.0f * co, n);
        return wi->z > 0.0f;
    }
    if (brdf_fresnel_dielectric(co, at->eta, &ct) >= 1.0f) return false;
    *wi = v3_mad(v3_mul(wo, -1.0f / at->eta), co / at->eta + ct, n);
    return wi->z < 0.0f;
}
