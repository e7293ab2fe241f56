// SPDX-License-Identifier: Apache-2.0
// Plastics: a diffuse base under a smooth or rough dielectric coat. The coat attenuates light on
// its way in and out, and reflects light back to the base from inside (the sum over all internal
// reflections is closed). With `nonlinear`, each reflection is multiplied by the base's colour. The
// coat's lobe is specular * Fresnel; the base's is
//   f = diffuse T(wo) T(wi) / (pi ior^2 (1 - R_in)),  R_in times diffuse if nonlinear,
// where T is the transmittance of the coat and R_in its mean reflectance from inside, both as
// Mitsuba tabulates them for the rough coat: single scattering, so that light that other facets
// mask is lost.
#include "base/sampling.h"
#include "brdf/brdf_boundary.h"
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_models.h"

struct plastic_coat {
    float inv_ior2;
    float inside;                    // mean reflectance from inside
    float enters;                    // mean transmittance from outside
    struct boundary_table boundary;  // of the rough coat
};

static rgb base_albedo(const struct brdf *b, const struct plastic_coat *c) {
    rgb d = b->diffuse;
    float r = c->inside;
    if (!b->nonlinear) return rgb_scale(d, c->inv_ior2 / (1.0f - r));
    return rgb_scale(
        rgb_make(d.r / (1.0f - d.r * r), d.g / (1.0f - d.g * r), d.b / (1.0f - d.b * r)),
        c->inv_ior2);
}

// ---- Smooth coat -------------------------------------------------------------------------------

static satin_status smooth_prepare(struct brdf *b, struct arena *arena) {
    struct plastic_coat *c = arena_alloc(arena, sizeof *c);
    if (!c) return SATIN_ERROR_MEMORY;
    c->inv_ior2 = 1.0f / (b->ior * b->ior);
    c->inside = brdf_fresnel_diffuse_mean(1.0f / b->ior);
    c->enters = 1.0f - brdf_fresnel_diffuse_mean(b->ior);
    b->tables = c;
    return SATIN_OK;
}

static void smooth_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    float t = (1.0f - brdf_fresnel_dielectric(wo.z, b->ior, NULL)) *
              (1.0f - brdf_fresnel_dielectric(wi.z, b->ior, NULL));
    *diffuse = rgb_scale(base_albedo(b, b->tables), t * (1.0f / PI_F));
    *glossy = rgb_grey(0.0f);
}

static int plastic_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode,
                         struct brdf_sample out[2]) {
    (void)mode;
    if (!(wo.z > 0.0f)) return 0;
    out[0] = brdf_mirror(wo, rgb_scale(b->specular, brdf_fresnel_dielectric(wo.z, b->ior, NULL)));
    return 1;
}

static rgb smooth_diffuse_albedo(const struct brdf *b, vec3 wo) {
    const struct plastic_coat *c = b->tables;
    float t = 1.0f - brdf_fresnel_dielectric(wo.z, b->ior, NULL);
    return rgb_scale(base_albedo(b, c), t * c->enters);
}

static void smooth_plastic_probabilities(const struct brdf *b, vec3 wo, float *diffuse,
                                         float *glossy, float *delta) {
    *diffuse = rgb_mean(smooth_diffuse_albedo(b, wo));
    *glossy = 0.0f;
    *delta = brdf_fresnel_dielectric(wo.z, b->ior, NULL) * rgb_mean(b->specular);
}

// ---- Rough coat --------------------------------------------------------------------------------

static struct microfacet plastic_facets(const struct brdf *b) {
    return brdf_microfacet_make(b->distribution, b->alpha_u, b->alpha_u, b->alpha_least);
}

static float transmittance(const struct plastic_coat *c, float cosine) {
    return brdf_boundary_transmittance(&c->boundary, cosine);
}

static satin_status rough_prepare(struct brdf *b, struct arena *arena) {
    struct plastic_coat *c = arena_alloc(arena, sizeof *c);
    if (!c) return SATIN_ERROR_MEMORY;
    brdf_boundary_build(plastic_facets(b), b->ior, &c->boundary);
    c->enters = brdf_boundary_enters(&c->boundary);
    c->inside = brdf_boundary_inside(plastic_facets(b), b->ior);
    c->inv_ior2 = 1.0f / (b->ior * b->ior);
    b->tables = c;
    return SATIN_OK;
}

static void plastic_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    const struct plastic_coat *c = b->tables;
    float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
    float f = brdf_fresnel_dielectric(cos_d, b->ior, NULL) *
              brdf_microfacet_reflection(plastic_facets(b), wo, wi);
    float t = transmittance(c, wo.z) * transmittance(c, wi.z);
    *diffuse = rgb_scale(base_albedo(b, c), t * (1.0f / PI_F));
    *glossy = rgb_scale(b->specular, f);
}

static void plastic_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                        float *glossy) {
    (void)lobes;
    *diffuse = wi.z * (1.0f / PI_F);
    *glossy = brdf_microfacet_reflection_pdf(plastic_facets(b), wo, wi);
}

static bool plastic_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    (void)lobes;
    return brdf_microfacet_reflect(plastic_facets(b), wo, u.y, u.z, wi);
}

static rgb rough_diffuse_albedo(const struct brdf *b, vec3 wo) {
    const struct plastic_coat *c = b->tables;
    return rgb_scale(base_albedo(b, c), transmittance(c, wo.z) * c->enters);
}

static void rough_plastic_probabilities(const struct brdf *b, vec3 wo, float *diffuse,
                                        float *glossy, float *delta) {
    *diffuse = rgb_mean(rough_diffuse_albedo(b, wo));
    *glossy = (1.0f - transmittance(b->tables, wo.z)) * rgb_mean(b->specular);
    *delta = 0.0f;
}

const struct brdf_model brdf_model_plastic = {
    .name = "plastic",
    .doc = "diffuse base under a smooth clear coat",
    .lobes = BRDF_DIFFUSE | BRDF_DELTA,
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_SPECULAR,
    .prepare = smooth_prepare,
    .eval = smooth_eval,
    .pdf = brdf_diffuse_pdf,
    .diffuse_albedo = smooth_diffuse_albedo,
    .delta = plastic_delta,
    .probabilities = smooth_plastic_probabilities,
};

const struct brdf_model brdf_model_roughplastic = {
    .name = "roughplastic",
    .doc = "diffuse base under a rough clear coat of microfacets (GGX or Beckmann)",
    .lobes = BRDF_REFLECT,
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_SPECULAR,
    .prepare = rough_prepare,
    .eval = plastic_eval,
    .pdf = plastic_pdf,
    .diffuse_albedo = rough_diffuse_albedo,
    .sample_glossy = plastic_sample,
    .probabilities = rough_plastic_probabilities,
};
