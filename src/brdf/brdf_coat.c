// SPDX-License-Identifier: Apache-2.0
// A dielectric coat over any BRDF that does not transmit: Mitsuba 0.6's coating and roughcoating
// [Weidlich and Wilkie 2007]. For directions w above the coat, refracted to w' in it,
//   f(wo, wi) = specular reflection + f_nested(wo', wi') T(wo) T(wi) A / ior^2,
//   A = exp(-depth (1 / cos wo' + 1 / cos wi')),
// where T is the transmittance of the boundary, and depth the absorption times the thickness. Light
// that is reflected inside of the coat is lost. 1 / ior^2 is the compression of solid angles with
// the ratio of cosines, so that f is reciprocal. Refraction is that of a smooth coat, also if the
// coat is rough: then the reflection has facets, and T is tabulated (brdf_boundary.h).
//
// A coat is a model of its own, made from that of the nested BRDF: each nested lobe stays a lobe of
// its kind. The reflection of a smooth coat has the direction of nested mirrors, so both are one
// delta lobe; that of a rough one is in the glossy lobe, which has then no common factor any more
// (brdf_glossy_factor).
#include <stdio.h>
#include "base/sampling.h"
#include "brdf/brdf_boundary.h"
#include "brdf/brdf_fresnel.h"
#include "brdf/brdf_models.h"

enum {
    LIGHT_NODES = 16,     // of means over light from all sides
    UNEVEN_NODES = 33,    // cosines 0 to 1 at equal distances
    UNEVEN_AZIMUTHS = 24  // over a half circle, as diffuse lobes are symmetric
};

// The light of one of a set of directions of equal azimuth.
struct coat_light {
    vec3 wi;               // refracted
    float weight;          // 2 cos(wi) T(wi) / ior^2 times that of the rule
    float inverse_cosine;  // of wi
};

struct brdf_coat {
    struct brdf_model model;          // of the coated BRDF
    const struct brdf_model *nested;  // its functions read the same struct brdf
    float ior, inv_ior2;
    float alpha;  // of a rough coat; 0: smooth
    enum brdf_distribution distribution;
    struct boundary_table boundary;  // if rough
    struct coat_light light[LIGHT_NODES];
    float base, gloss;  // typical albedos of the nested lobes for factors of 1, to choose lobes by
    rgb uneven[UNEVEN_NODES];  // the diffuse albedo over that of an even lobe; not if Lambertian
};

// ---- Refraction ---------------------------------------------------------------------------------

// The refracted direction, above the nested surface; z is 0 for total reflection.
static vec3 refract_in(const struct brdf_coat *c, vec3 w) {
    const float s = 1.0f / c->ior;
    return v3(w.x * s, w.y * s, s * safe_sqrtf(sqrf(c->ior) - 1.0f + sqrf(w.z)));
}

static float coat_transmits(const struct brdf_coat *c, float cosine) {
    if (c->alpha > 0.0f) return brdf_boundary_transmittance(&c->boundary, cosine);
    return 1.0f - brdf_fresnel_dielectric(cosine, c->ior, NULL);
}

// What is left after `path` times the thickness of the coat.
static rgb coat_absorbs(const struct brdf *b, float path) {
    const rgb d = b->coat_depth;
    if (rgb_black(d)) return rgb_grey(1.0f);
    return rgb_make(expf(-maxf(d.r, 0.0f) * path), expf(-maxf(d.g, 0.0f) * path),
                    expf(-maxf(d.b, 0.0f) * path));
}

static struct microfacet coat_facets(const struct brdf *b) {
    const float alpha = b->coat->alpha;
    return brdf_microfacet_make(b->coat->distribution, alpha, alpha, b->alpha_least);
}

// ---- Smooth lobes -------------------------------------------------------------------------------

static void coated_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    const struct brdf_coat *c = b->coat;
    const vec3 to = refract_in(c, wo), from = refract_in(c, wi);
    *diffuse = *glossy = rgb_grey(0.0f);
    if (c->nested->eval && to.z > 0.0f && from.z > 0.0f) {
        const float t = coat_transmits(c, wo.z) * coat_transmits(c, wi.z) * c->inv_ior2;
        const rgb factor = rgb_scale(coat_absorbs(b, 1.0f / to.z + 1.0f / from.z), t);
        c->nested->eval(b, to, from, diffuse, glossy);
        *diffuse = rgb_mul(*diffuse, factor);
        *glossy = rgb_mul(*glossy, factor);
    }
    if (!(c->alpha > 0.0f)) return;
    const float cos_d = minf(0.5f * v3_len(v3_add(wo, wi)), 1.0f);
    const float f = brdf_fresnel_dielectric(cos_d, c->ior, NULL) *
                    brdf_microfacet_reflection(coat_facets(b), wo, wi);
    *glossy = rgb_mad(*glossy, b->coat_specular, f);
}

// What the nested lobes receive and return at about the angle of wo, over their albedos.
static float attenuation(const struct brdf *b, vec3 wo) {
    const vec3 to = refract_in(b->coat, wo);
    if (!(to.z > 0.0f)) return 0.0f;
    return coat_transmits(b->coat, wo.z) * rgb_mean(coat_absorbs(b, 2.0f / to.z));
}

static float coat_reflects(const struct brdf *b, vec3 wo) {
    return (1.0f - coat_transmits(b->coat, wo.z)) * rgb_mean(b->coat_specular);
}

static float nested_gloss(const struct brdf *b) {
    const bool has = b->coat->nested->lobes & BRDF_GLOSSY;
    return has ? b->coat->gloss * rgb_mean(b->specular) : 0.0f;
}

// The probability with which sample_glossy chooses the coat's own lobe.
static float choose_coat(const struct brdf *b, vec3 wo) {
    if (!(b->coat->alpha > 0.0f)) return 0.0f;
    const float own = coat_reflects(b, wo), inner = nested_gloss(b) * attenuation(b, wo);
    return own + inner > 0.0f ? own / (own + inner) : 1.0f;
}

static void coated_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                       float *glossy) {
    const struct brdf_coat *c = b->coat;
    const float own = choose_coat(b, wo);
    *diffuse = wi.z * (1.0f / PI_F);
    *glossy = own > 0.0f ? own * brdf_microfacet_reflection_pdf(coat_facets(b), wo, wi) : 0.0f;
    if (!(own < 1.0f) || !c->nested->sample_glossy) return;
    const vec3 to = refract_in(c, wo), from = refract_in(c, wi);
    if (!(to.z > 0.0f && from.z > 0.0f)) return;
    float even, inner;
    c->nested->pdf(b, to, from, lobes, &even, &inner);
    *glossy += (1.0f - own) * inner * c->inv_ior2 * wi.z / from.z;
}

static bool coated_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    const struct brdf_coat *c = b->coat;
    const float own = choose_coat(b, wo);
    if (u.x < own) return brdf_microfacet_reflect(coat_facets(b), wo, u.y, u.z, wi);
    const vec3 to = refract_in(c, wo), rest = v3(sample_rest(u.x, own), u.y, u.z);
    vec3 from;
    if (!(to.z > 0.0f) || !c->nested->sample_glossy) return false;
    if (!c->nested->sample_glossy(b, to, lobes & c->nested->lobes, rest, &from)) return false;
    const float z2 = 1.0f - sqrf(c->ior) * (1.0f - sqrf(from.z));
    if (!(from.z > 0.0f && z2 > 0.0f)) return false;  // total reflection
    *wi = v3_unit(v3(from.x * c->ior, from.y * c->ior, sqrtf(z2)));
    return true;
}

static void coated_probabilities(const struct brdf *b, vec3 wo, float *diffuse, float *glossy,
                                 float *delta) {
    const struct brdf_coat *c = b->coat;
    const float left = attenuation(b, wo), own = coat_reflects(b, wo);
    const bool even = c->nested->lobes & BRDF_DIFFUSE;
    *diffuse = even ? left * c->base * (rgb_mean(b->diffuse) + b->sheen) : 0.0f;
    *glossy = left * nested_gloss(b) + (c->alpha > 0.0f ? own : 0.0f);
    *delta = c->alpha > 0.0f ? 0.0f : own;
    struct brdf_sample mirror[2];
    const vec3 to = refract_in(c, wo);
    if (c->nested->delta && to.z > 0.0f && c->nested->delta(b, to, BRDF_RADIANCE, mirror))
        *delta += coat_transmits(c, wo.z) * left * rgb_mean(mirror[0].weight);
}

// ---- Delta lobe ---------------------------------------------------------------------------------

static int coated_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode,
                        struct brdf_sample out[2]) {
    const struct brdf_coat *c = b->coat;
    if (!(wo.z > 0.0f)) return 0;
    const float t = coat_transmits(c, wo.z);
    const vec3 to = refract_in(c, wo);
    rgb weight = rgb_scale(b->coat_specular, c->alpha > 0.0f ? 0.0f : 1.0f - t);
    struct brdf_sample nested[2];
    if (c->nested->delta && to.z > 0.0f && c->nested->delta(b, to, mode, nested))
        weight = rgb_fma(weight, nested[0].weight, rgb_scale(coat_absorbs(b, 2.0f / to.z), t * t));
    out[0] = brdf_mirror(wo, weight);
    return 1;
}

// ---- Diffuse albedo -----------------------------------------------------------------------------

// The albedo of a nested lobe of albedo 1 that scatters evenly, without the way to wo.
static rgb even_albedo(const struct brdf *b) {
    const struct brdf_coat *c = b->coat;
    rgb sum = rgb_grey(0.0f);
    for (int i = 0; i < LIGHT_NODES; i++)
        sum = rgb_mad(sum, coat_absorbs(b, c->light[i].inverse_cosine), c->light[i].weight);
    return sum;
}

static rgb nested_albedo(const struct brdf *b, vec3 to) {
    return b->coat->nested->diffuse_albedo ? b->coat->nested->diffuse_albedo(b, to) : b->diffuse;
}

// It is exact for constant colours. The table is for those of the constants, whose ratios hardly
// depend on colours.
static rgb coated_diffuse_albedo(const struct brdf *b, vec3 wo) {
    const struct brdf_coat *c = b->coat;
    const vec3 to = refract_in(c, wo);
    if (!(to.z > 0.0f)) return rgb_grey(0.0f);
    const rgb out = rgb_scale(coat_absorbs(b, 1.0f / to.z), coat_transmits(c, wo.z));
    const rgb even = rgb_mul(nested_albedo(b, to), rgb_mul(even_albedo(b), out));
    if (!c->nested->diffuse_albedo) return even;
    const float x = wo.z * (float)(UNEVEN_NODES - 1);
    const int i = x < (float)(UNEVEN_NODES - 2) ? (int)x : UNEVEN_NODES - 2;
    const rgb ratio = rgb_mad(c->uneven[i], rgb_sub(c->uneven[i + 1], c->uneven[i]), x - (float)i);
    return rgb_mul(even, ratio);
}

// The exact albedo without the way to wo, by sums over directions.
static rgb summed_albedo_of(const struct brdf *b, vec3 to) {
    const struct brdf_coat *c = b->coat;
    rgb sum = rgb_grey(0.0f);
    for (int i = 0; i < LIGHT_NODES; i++) {
        const struct coat_light *light = &c->light[i];
        rgb mean = rgb_grey(0.0f), diffuse, glossy;
        for (int k = 0; k < UNEVEN_AZIMUTHS; k++) {
            const float phi = PI_F * ((float)k + 0.5f) / UNEVEN_AZIMUTHS;
            const vec3 wi = v3(light->wi.x * cosf(phi), light->wi.x * sinf(phi), light->wi.z);
            c->nested->eval(b, to, wi, &diffuse, &glossy);
            mean = rgb_mad(mean, diffuse, PI_F / UNEVEN_AZIMUTHS);
        }
        const rgb left = rgb_scale(coat_absorbs(b, light->inverse_cosine), light->weight);
        sum = rgb_fma(sum, mean, left);
    }
    return sum;
}

static float ratio_or_1(float a, float b) { return b > 0.0f ? a / b : 1.0f; }

static void tabulate_uneven(const struct brdf *b, struct brdf_coat *c) {
    const rgb even = even_albedo(b);
    for (int i = 0; i < UNEVEN_NODES; i++) {
        const float z = maxf((float)i / (UNEVEN_NODES - 1), 1e-4f);
        const vec3 to = refract_in(c, v3(sqrtf(1.0f - z * z), 0.0f, z));
        c->uneven[i] = rgb_grey(1.0f);
        if (!(to.z > 0.0f)) continue;
        const rgb sum = summed_albedo_of(b, to), flat = rgb_mul(nested_albedo(b, to), even);
        c->uneven[i] = rgb_make(ratio_or_1(sum.r, flat.r), ratio_or_1(sum.g, flat.g),
                                ratio_or_1(sum.b, flat.b));
    }
}

// ---- Making a coat ------------------------------------------------------------------------------

unsigned brdf_coat_lobes(const struct brdf *b, unsigned nested) {
    if (rgb_black(b->coat_specular)) return nested;
    return nested | (b->coat->alpha > 0.0f ? BRDF_GLOSSY : BRDF_DELTA);
}

const struct brdf_model *brdf_coat_nested(const struct brdf *b) { return b->coat->nested; }

bool brdf_is_factored(const struct brdf *b) { return !b->coat || !(b->coat->alpha > 0.0f); }

// Sets the rule over cosines from that of total reflection, or 0, to 1.
static void set_light(struct brdf_coat *c) {
    const float least = safe_sqrtf(1.0f - sqrf(c->ior)), range = 1.0f - least;
    struct quadrature rule;
    brdf_quadrature_gauss(&rule, LIGHT_NODES);
    for (int i = 0; i < LIGHT_NODES; i++) {
        const float mu = least + range * (float)rule.x[i];
        const vec3 wi = refract_in(c, v3(sqrtf(1.0f - mu * mu), 0.0f, mu));
        if (!(wi.z > 0.0f)) continue;
        const float t = coat_transmits(c, mu) * c->inv_ior2 * range * (float)rule.weight[i];
        c->light[i] = (struct coat_light){wi, 2.0f * mu * t, 1.0f / wi.z};
    }
}

// The model of a coat over this one.
static struct brdf_model coated_model(const struct brdf_model *nested, bool rough,
                                      const char *name) {
    struct brdf_model m = {.name = name,
                           .doc = "a dielectric coat over another BRDF",
                           .data = nested->data,
                           .delta = coated_delta,
                           .probabilities = coated_probabilities};
    m.lobes = (nested->lobes & ~(unsigned)BRDF_THROUGH) | (rough ? BRDF_GLOSSY : BRDF_DELTA);
    m.slots = nested->slots | 1u << BRDF_SLOT_COAT_SPECULAR | 1u << BRDF_SLOT_COAT_DEPTH;
    if (m.lobes & BRDF_SMOOTH) {
        m.eval = coated_eval;
        m.pdf = coated_pdf;
    }
    if (m.lobes & BRDF_GLOSSY) m.sample_glossy = coated_sample;
    if (m.lobes & BRDF_DIFFUSE) m.diffuse_albedo = coated_diffuse_albedo;
    if (!(m.lobes & BRDF_DELTA)) m.delta = NULL;
    return m;
}

// The mean albedo of a lobe of the nested BRDF with factors of 1, at 45 degrees.
static float typical_albedo(struct brdf white, unsigned lobe) {
    white.diffuse = white.specular = rgb_grey(1.0f);
    return rgb_mean(brdf_albedo(&white, v3(sqrtf(0.5f), 0.0f, sqrtf(0.5f)), lobe));
}

satin_status brdf_coat_set(struct brdf *b, struct arena *arena,
                           const struct brdf_coating *coating) {
    struct brdf_coat *c = arena_alloc(arena, sizeof *c);
    char name[96];
    const int length = snprintf(name, sizeof name, "%s over %s",
                                coating->alpha > 0.0f ? "roughcoating" : "coating", b->model->name);
    const char *kept = arena_text(arena, name, (size_t)length);
    if (!c || !kept) return SATIN_ERROR_MEMORY;
    *c = (struct brdf_coat){.model = coated_model(b->model, coating->alpha > 0.0f, kept),
                            .nested = b->model,
                            .ior = coating->ior,
                            .inv_ior2 = 1.0f / sqrf(coating->ior),
                            .alpha = coating->alpha,
                            .distribution = coating->distribution,
                            .base = typical_albedo(*b, BRDF_DIFFUSE),
                            .gloss = typical_albedo(*b, BRDF_GLOSSY)};
    struct brdf coated = *b;
    coated.model = &c->model;
    coated.coat = c;
    coated.glossy = NULL;
    coated.coat_specular = coating->specular;
    coated.coat_depth = coating->depth;
    if (c->alpha > 0.0f) brdf_boundary_build(coat_facets(&coated), c->ior, &c->boundary);
    set_light(c);
    c->base *= rgb_mean(even_albedo(&(struct brdf){.coat = c}));
    if (c->nested->diffuse_albedo) tabulate_uneven(&coated, c);
    const satin_status status = brdf_albedo_prepare(&coated, arena, NULL);
    if (status == SATIN_OK) *b = coated;
    return status;
}
