// SPDX-License-Identifier: Apache-2.0
// Rough glass: microfacets of a dielectric boundary that reflect and refract [Walter et al. 2007].
// What holds above the surface holds below it with the inverse index, so everything is computed
// with wo above. `ior` is the index below over that above.
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_microfacet.h"
#include "brdf/brdf_models.h"

// The boundary as seen from wo's side: eta is the index beyond over the index before.
struct boundary {
    struct microfacet facets;
    float eta;
};

static vec3 turned(vec3 w, bool turn) { return turn ? v3(w.x, w.y, -w.z) : w; }

static struct boundary boundary_at(const struct brdf *b, vec3 *wo, vec3 *wi) {
    bool below = wo->z < 0.0f;
    *wo = turned(*wo, below);
    *wi = turned(*wi, below);
    return (struct boundary){microfacet_make(b->distribution, b->alpha_u, b->alpha_v),
                             below ? 1.0f / b->ior : b->ior};
}

// The facet that refracts wo into wi, and its cosines to both, co > 0 > ci; false if there is none.
static bool refracting_facet(const struct boundary *at, vec3 wo, vec3 wi, vec3 *n, float *co,
                             float *ci) {
    vec3 h = v3_mad(wo, at->eta, wi);
    float length = v3_len(h);
    if (!(length > 0.0f)) return false;
    *n = v3_mul(h, (h.z < 0.0f ? -1.0f : 1.0f) / length);
    *co = v3_dot(wo, *n);
    *ci = v3_dot(wi, *n);
    return *co > 0.0f && *ci < 0.0f && n->z > 0.0f;
}

// Solid angle of facets per solid angle of refracted light.
static float refraction_jacobian(const struct boundary *at, float co, float ci) {
    return -sqrf(at->eta) * ci / sqrf(co + at->eta * ci);
}

static void eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    struct boundary at = boundary_at(b, &wo, &wi);
    float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
    float f = fresnel_dielectric(cos_d, at.eta, NULL) * microfacet_reflection(at.facets, wo, wi);
    *diffuse = rgb_grey(0.0f);
    *glossy = rgb_scale(b->specular, f);
}

static rgb through(const struct brdf *b, vec3 wo, vec3 wi, enum brdf_mode mode) {
    struct boundary at = boundary_at(b, &wo, &wi);
    vec3 n;
    float co, ci;
    if (!refracting_facet(&at, wo, wi, &n, &co, &ci)) return rgb_grey(0.0f);
    float t = (1.0f - fresnel_dielectric(co, at.eta, NULL)) * microfacet_d(at.facets, n);
    t *= microfacet_g1(at.facets, wo) * microfacet_g1(at.facets, turned(wi, true));
    t *= refraction_jacobian(&at, co, ci) * co / (wo.z * -wi.z);
    // Radiance is compressed into a smaller solid angle on the denser side.
    if (mode == BRDF_RADIANCE) t /= sqrf(at.eta);
    return rgb_scale(b->transmittance, t);
}

static void pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                float *glossy) {
    const bool both = (lobes & BRDF_GLOSSY) && (lobes & BRDF_THROUGH);
    struct boundary at = boundary_at(b, &wo, &wi);
    *diffuse = *glossy = 0.0f;
    if (wi.z > 0.0f) {
        float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
        *glossy = microfacet_reflection_pdf(at.facets, wo, wi) *
                  (both ? fresnel_dielectric(cos_d, at.eta, NULL) : 1.0f);
        return;
    }
    vec3 n;
    float co, ci;
    if (!refracting_facet(&at, wo, wi, &n, &co, &ci)) return;
    float f = fresnel_dielectric(co, at.eta, NULL);
    if (f >= 1.0f) return;
    float visible = microfacet_d(at.facets, n) * microfacet_g1_exact(at.facets, wo) * co / wo.z;
    *glossy = visible * refraction_jacobian(&at, co, ci) * (both ? 1.0f - f : 1.0f);
}

// A visible facet, then reflection or refraction there in proportion to its Fresnel reflectance.
static bool sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    const bool below = wo.z < 0.0f;
    *wi = v3(0, 0, 0);
    struct boundary at = boundary_at(b, &wo, wi);
    vec3 n = microfacet_sample(at.facets, wo, u.y, u.z);
    float co = v3_dot(wo, n), ct;
    float f = fresnel_dielectric(co, at.eta, &ct);
    bool reflect = lobes & BRDF_GLOSSY;
    if (reflect && lobes & BRDF_THROUGH) reflect = u.x < f;
    if (!(co > 0.0f) || (!reflect && f >= 1.0f)) return false;
    vec3 w = reflect ? v3_mad(v3_neg(wo), 2.0f * co, n)
                     : v3_mad(v3_mul(wo, -1.0f / at.eta), co / at.eta + ct, n);
    *wi = turned(w, below);
    return reflect ? w.z > 0.0f : w.z < 0.0f;
}

const struct brdf_model brdf_model_roughdielectric = {
    .name = "roughdielectric",
    .doc = "rough glass: microfacets (GGX or Beckmann) that reflect and refract",
    .lobes = BRDF_GLOSSY | BRDF_THROUGH,
    .slots = 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_TRANSMITTANCE | 1u << BRDF_SLOT_ALPHA_U |
             1u << BRDF_SLOT_ALPHA_V,
    .transmits = true,
    .eval = eval,
    .through = through,
    .pdf = pdf,
    .sample_glossy = sample,
};
