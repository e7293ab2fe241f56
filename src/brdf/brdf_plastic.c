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

// Means over uniform light.
struct plastic_means {
    float inside;  // reflectance from inside
    float enters;  // transmittance from outside
};

// The base's albedo without the coat's transmittances.
static rgb base_albedo(const struct brdf *b, float inside) {
    rgb d = b->diffuse;
    const float inv_ior2 = 1.0f / (b->ior * b->ior);
    if (!b->nonlinear) return rgb_scale(d, inv_ior2 / (1.0f - inside));
    return rgb_scale(rgb_make(d.r / (1.0f - d.r * inside), d.g / (1.0f - d.g * inside),
                              d.b / (1.0f - d.b * inside)),
                     inv_ior2);
}

// ---- Smooth coat -------------------------------------------------------------------------------

static satin_status smooth_prepare(struct brdf *b, struct arena *arena) {
    struct plastic_means *means = arena_alloc(arena, sizeof *means);
    if (!means) return SATIN_ERROR_MEMORY;
    means->inside = brdf_fresnel_diffuse_mean(1.0f / b->ior);
    means->enters = 1.0f - brdf_fresnel_diffuse_mean(b->ior);
    b->tables = means;
    return SATIN_OK;
}

static void smooth_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    float t = (1.0f - brdf_fresnel_dielectric(wo.z, b->ior, NULL)) *
              (1.0f - brdf_fresnel_dielectric(wi.z, b->ior, NULL));
    const struct plastic_means *means = b->tables;
    *diffuse = rgb_scale(base_albedo(b, means->inside), t * (1.0f / PI_F));
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
    const struct plastic_means *means = b->tables;
    float t = 1.0f - brdf_fresnel_dielectric(wo.z, b->ior, NULL);
    return rgb_scale(base_albedo(b, means->inside), t * means->enters);
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

// The coat at one roughness.
struct plastic_rung {
    struct plastic_means means;
    struct boundary_table boundary;
};

// The coat at its roughness or, if that is textured, at several, between which a spline of their
// logarithm interpolates. The diffuse lobe is then within .9 % of that of a constant roughness, at
// grazing angles within 1.3 %. Above a roughness of 5 the coat stays the same.
struct plastic_coat {
    int rungs;
    struct plastic_rung rung[];
};

enum { ROUGH_RUNGS = 20, RUNGS_PER_OCTAVE = 2, RUNGS_AROUND = 4 };
#define ROUGH_STEP 0.01f  // rungs are equally far apart in the logarithm of this plus the roughness

static float rung_roughness(int i) {
    return ROUGH_STEP * (exp2f((float)i / (float)RUNGS_PER_OCTAVE) - 1.0f);
}

static satin_status rough_prepare(struct brdf *b, struct arena *arena) {
    const int rungs = b->rough_texture ? ROUGH_RUNGS : 1;
    struct plastic_coat *c = arena_alloc(arena, sizeof *c + (size_t)rungs * sizeof *c->rung);
    if (!c) return SATIN_ERROR_MEMORY;
    c->rungs = rungs;
    for (int i = 0; i < rungs; i++) {
        struct brdf at = *b;
        if (b->rough_texture) at.alpha_u = rung_roughness(i);
        const struct microfacet facets = plastic_facets(&at);
        struct plastic_rung *rung = &c->rung[i];
        brdf_boundary_build(facets, b->ior, &rung->boundary);
        rung->means.enters = brdf_boundary_enters(&rung->boundary);
        rung->means.inside = brdf_boundary_inside(facets, b->ior);
    }
    b->tables = c;
    return SATIN_OK;
}

struct plastic_rungs {
    const struct plastic_rung *rung[RUNGS_AROUND];
    float weight[RUNGS_AROUND];
    int count;
};

// Weights the rungs around b's roughness by a Catmull-Rom spline.
static struct plastic_rungs find_rungs(const struct brdf *b) {
    const struct plastic_coat *c = b->tables;
    struct plastic_rungs at = {{c->rung}, {1.0f}, 1};
    if (c->rungs == 1) return at;
    const int last = c->rungs - 1;
    const float octaves = log2f(1.0f + b->alpha_u / ROUGH_STEP);
    const float x = clampf(octaves * (float)RUNGS_PER_OCTAVE, 0.0f, (float)(last - 1));
    const int i = (int)x;
    const float t = x - (float)i, s = 1.0f - t;
    const float weight[RUNGS_AROUND] = {-0.5f * t * s * s, s * (1.0f + t - 1.5f * t * t),
                                        t * (1.0f + s - 1.5f * s * s), -0.5f * s * t * t};
    for (at.count = 0; at.count < RUNGS_AROUND; at.count++) {
        const int k = i + at.count - 1;
        at.rung[at.count] = &c->rung[k < 0 ? 0 : k > last ? last : k];
        at.weight[at.count] = weight[at.count];
    }
    return at;
}

static float transmittance(const struct plastic_rungs *at, float cosine) {
    float sum = 0.0f;
    for (int i = 0; i < at->count; i++)
        sum += at->weight[i] * brdf_boundary_transmittance(&at->rung[i]->boundary, cosine);
    return sum;
}

static struct plastic_means means_of(const struct plastic_rungs *at) {
    struct plastic_means sum = {0.0f, 0.0f};
    for (int i = 0; i < at->count; i++) {
        sum.inside += at->weight[i] * at->rung[i]->means.inside;
        sum.enters += at->weight[i] * at->rung[i]->means.enters;
    }
    return sum;
}

static void plastic_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    const struct plastic_rungs at = find_rungs(b);
    float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
    float f = brdf_fresnel_dielectric(cos_d, b->ior, NULL) *
              brdf_microfacet_reflection(plastic_facets(b), wo, wi);
    float t = transmittance(&at, wo.z) * transmittance(&at, wi.z);
    *diffuse = rgb_scale(base_albedo(b, means_of(&at).inside), t * (1.0f / PI_F));
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
    const struct plastic_rungs at = find_rungs(b);
    const struct plastic_means means = means_of(&at);
    return rgb_scale(base_albedo(b, means.inside), transmittance(&at, wo.z) * means.enters);
}

static void rough_plastic_probabilities(const struct brdf *b, vec3 wo, float *diffuse,
                                        float *glossy, float *delta) {
    *diffuse = rgb_mean(rough_diffuse_albedo(b, wo));
    const struct plastic_rungs at = find_rungs(b);
    *glossy = (1.0f - transmittance(&at, wo.z)) * rgb_mean(b->specular);
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
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_SPECULAR | 1u << BRDF_SLOT_ALPHA_U,
    .prepare = rough_prepare,
    .eval = plastic_eval,
    .pdf = plastic_pdf,
    .diffuse_albedo = rough_diffuse_albedo,
    .sample_glossy = plastic_sample,
    .probabilities = rough_plastic_probabilities,
};
