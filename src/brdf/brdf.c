// SPDX-License-Identifier: Apache-2.0
// Functions for all models: the table of models, and evaluation and sampling of selected lobes.
// Sampling chooses a lobe by the model's probabilities, restricted to the selected lobes; the
// density of a direction is that of the mixture of the smooth lobes among them.
#include "brdf/brdf.h"

#include <string.h>

#include "base/sampling.h"
#include "brdf/brdf_models.h"

const struct brdf_model *const brdf_models[] = {
    &brdf_model_diffuse,         &brdf_model_roughdiffuse,
    &brdf_model_conductor,       &brdf_model_roughconductor,
    &brdf_model_dielectric,      &brdf_model_thindielectric,
    &brdf_model_roughdielectric, &brdf_model_null,
    &brdf_model_principled,      &brdf_model_principledthin,
    &brdf_model_plastic,         &brdf_model_roughplastic,
    &brdf_model_phong,           &brdf_model_ward,
    &brdf_model_lafortune,       &brdf_model_merl,
    &brdf_model_tabulated,       &(const struct brdf_model){.name = NULL}};

const struct brdf_model *brdf_find(const char *name) {
    for (int i = 0; brdf_models[i]->name; i++)
        if (!strcmp(brdf_models[i]->name, name)) return brdf_models[i];
    return NULL;
}

satin_status brdf_prepare(struct brdf *b, struct arena *arena, const struct brdf_glossy **made) {
    if (made && brdf_albedo_reuse(b, *made)) return SATIN_OK;
    satin_status status = b->model->prepare ? b->model->prepare(b, arena) : SATIN_OK;
    return status ? status : brdf_albedo_prepare(b, arena, made);
}

// Whether the coats of two BRDFs of one model do the same to the glossy lobe.
static bool same_coat(const struct brdf *a, const struct brdf *b) {
    if (a->coat != b->coat) return false;
    if (!a->coat) return true;
    if (memcmp(&a->coat_depth, &b->coat_depth, sizeof a->coat_depth) != 0) return false;
    return brdf_is_factored(a) ||
           (memcmp(&a->specular, &b->specular, sizeof a->specular) == 0 &&
            memcmp(&a->coat_specular, &b->coat_specular, sizeof a->coat_specular) == 0);
}

bool brdf_same_shape(const struct brdf *a, const struct brdf *b) {
    if (!same_coat(a, b)) return false;
    if (a->model != b->model || a->ior != b->ior || a->distribution != b->distribution ||
        a->variant != b->variant || a->opaque != b->opaque ||
        (a->model->data && a->tables != b->tables))
        return false;
    for (enum brdf_slot i = BRDF_SLOT_NUMBERS; i < BRDF_SLOT_COUNT; i++)
        if (brdf_number_of(a, i) != brdf_number_of(b, i)) return false;
    if (a->model->slots & 1u << BRDF_SLOT_ETA)
        return memcmp(&a->eta, &b->eta, sizeof a->eta) == 0 &&
               memcmp(&a->k, &b->k, sizeof a->k) == 0;
    return !brdf_tinted(a) || memcmp(&a->diffuse, &b->diffuse, sizeof a->diffuse) == 0;
}

unsigned brdf_lobes(const struct brdf *b) {
    unsigned lobes = b->coat ? brdf_coat_nested(b)->lobes : b->model->lobes;
    if (b->opaque) lobes &= ~(unsigned)BRDF_THROUGH;
    if (rgb_black(b->diffuse) && b->sheen == 0.0f) lobes &= ~(unsigned)BRDF_DIFFUSE;
    if (b->model->transmits && rgb_black(b->transmittance)) lobes &= ~(unsigned)BRDF_THROUGH;
    if (rgb_black(b->specular)) {
        lobes &= ~(unsigned)BRDF_GLOSSY;
        if (!b->model->transmits || rgb_black(b->transmittance)) lobes &= ~(unsigned)BRDF_DELTA;
    }
    return b->coat ? brdf_coat_lobes(b, lobes) : lobes;
}

// The probabilities of choosing a lobe; `glossy` is that of all lobes that sample_glossy draws.
struct lobe_probability {
    float diffuse, glossy, delta;
};

// False if none of the selected lobes scatters light to wo.
static bool find_probabilities(const struct brdf *b, vec3 wo, unsigned lobes,
                               struct lobe_probability *out) {
    lobes &= brdf_lobes(b);
    if (!(wo.z > 0.0f) && (!brdf_transmits(b) || wo.z == 0.0f)) return false;
    struct lobe_probability s = {1.0f, 1.0f, 1.0f};
    if (b->model->probabilities) b->model->probabilities(b, wo, &s.diffuse, &s.glossy, &s.delta);
    if (!(lobes & BRDF_DIFFUSE)) s.diffuse = 0.0f;
    if (!(lobes & (BRDF_GLOSSY | BRDF_THROUGH))) s.glossy = 0.0f;
    if (!(lobes & BRDF_DELTA)) s.delta = 0.0f;
    float sum = s.diffuse + s.glossy + s.delta;
    if (!(sum > 0.0f)) return false;
    *out = (struct lobe_probability){s.diffuse / sum, s.glossy / sum, s.delta / sum};
    return true;
}

// The smooth lobes among `lobes` that scatter light from wi to wo, given the sides of the two.
static unsigned smooth_lobes(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes) {
    float sides = wo.z * wi.z;
    lobes &= b->model->lobes & BRDF_SMOOTH;
    if (!(wo.z > 0.0f) && !brdf_transmits(b)) return 0;
    if (sides > 0.0f) return lobes & BRDF_REFLECT;
    return sides < 0.0f && !b->opaque ? lobes & BRDF_THROUGH : 0;
}

bool brdf_is_sharp(const struct brdf *b, vec3 wo, vec3 wi, float most) {
    if (!(most < INFINITY) || !(b->model->lobes & BRDF_GLOSSY)) return false;
    return brdf_pdf(b, wo, wi, BRDF_GLOSSY) > most;
}

// Evaluates `lobes`, from smooth_lobes and not 0.
static rgb eval_smooth(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes,
                       enum brdf_mode mode) {
    if (lobes & BRDF_THROUGH) return b->model->through(b, wo, wi, mode);
    rgb diffuse, glossy;
    b->model->eval(b, wo, wi, &diffuse, &glossy);
    if (!(lobes & BRDF_DIFFUSE)) return glossy;
    return lobes & BRDF_GLOSSY ? rgb_add(diffuse, glossy) : diffuse;
}

static float pdf_smooth(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes,
                        struct lobe_probability s) {
    float diffuse, glossy;
    lobes &= brdf_lobes(b);
    b->model->pdf(b, wo, wi, lobes, &diffuse, &glossy);
    return s.diffuse * diffuse + s.glossy * glossy;
}

rgb brdf_eval(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes) {
    lobes = smooth_lobes(b, wo, wi, lobes);
    if (!lobes) return rgb_grey(0.0f);
    rgb f = eval_smooth(b, wo, wi, lobes, BRDF_RADIANCE);
    return brdf_has_bump(b) ? rgb_scale(f, brdf_bump_toward(b, wi, wi)) : f;
}

float brdf_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes) {
    struct lobe_probability s;
    if (!smooth_lobes(b, wo, wi, lobes) || !find_probabilities(b, wo, lobes, &s)) return 0.0f;
    if (brdf_has_bump(b) && brdf_bump_toward(b, wi, wi) == 0.0f) return 0.0f;
    return pdf_smooth(b, wo, wi, lobes, s);
}

// Draws one delta lobe by u in [0, 1), and a facet of a polished surface by `facet`. `chosen` is
// the probability with which delta lobes were chosen.
static bool sample_delta(const struct brdf *b, vec3 wo, float u, vec2 facet, float chosen,
                         enum brdf_mode mode, struct brdf_sample *out) {
    struct brdf_sample lobe[2];
    int n = brdf_delta(b, wo, mode, lobe);
    if (n == 0) return false;
    *out = lobe[n == 2 && u >= lobe[0].probability];
    if (brdf_is_polished(b) && !brdf_facet(b, wo, facet, mode, out)) return false;
    out->probability *= chosen;
    out->weight = rgb_scale(out->weight, 1.0f / out->probability);
    return true;
}

// The IOR of the other side over that of wo's side, for light that is transmitted.
static float index_through(const struct brdf *b, vec3 wo) {
    if (b->model->thin) return 1.0f;
    return wo.z > 0.0f ? b->ior : 1.0f / b->ior;
}

bool brdf_sample_wi(const struct brdf *b, vec3 wo, float u_lobe, vec2 u, unsigned lobes,
                    enum brdf_mode mode, struct brdf_sample *out) {
    struct lobe_probability s;
    if (!find_probabilities(b, wo, lobes, &s)) return false;
    if (u_lobe < s.delta) return sample_delta(b, wo, u_lobe / s.delta, u, s.delta, mode, out);
    bool glossy = u_lobe < s.delta + s.glossy || s.diffuse == 0.0f;
    vec3 wi;
    if (!glossy) {
        wi = sample_cosine_hemisphere(u.x, u.y);
        if (wo.z < 0.0f) wi.z = -wi.z;
    } else {
        float rest = minf((u_lobe - s.delta) / s.glossy, SAMPLE_BELOW_ONE);
        unsigned both = lobes & brdf_lobes(b) & (BRDF_GLOSSY | BRDF_THROUGH);
        if (!b->model->sample_glossy(b, wo, both, v3(rest, u.x, u.y), &wi)) return false;
    }
    unsigned side = smooth_lobes(b, wo, wi, lobes);
    float pdf = side ? pdf_smooth(b, wo, wi, lobes, s) : 0.0f;
    if (!(pdf > 0.0f)) return false;
    rgb f = eval_smooth(b, wo, wi, side, mode);
    if (brdf_has_bump(b)) {
        float left = brdf_bump_toward(b, wi, mode == BRDF_RADIANCE ? wi : wo);
        if (left == 0.0f) return false;
        f = rgb_scale(f, left);
    }
    bool through = side & BRDF_THROUGH;
    *out = (struct brdf_sample){.wi = wi,
                                .weight = rgb_scale(f, fabsf(wi.z) / pdf),
                                .pdf_w = pdf,
                                .probability = 1.0f,
                                .eta = through ? index_through(b, wo) : 1.0f,
                                .lobe = through  ? BRDF_THROUGH
                                        : glossy ? BRDF_GLOSSY
                                                 : BRDF_DIFFUSE};
    return true;
}

int brdf_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode, struct brdf_sample out[2]) {
    int n = b->model->delta ? b->model->delta(b, wo, mode, out) : 0;
    for (int i = 0; i < n && brdf_has_bump(b); i++) {
        float left = brdf_bump_toward(b, out[i].wi, mode == BRDF_RADIANCE ? out[i].wi : wo);
        out[i].weight = rgb_scale(out[i].weight, left);
    }
    return n;
}

bool brdf_facet(const struct brdf *b, vec3 wo, vec2 u, enum brdf_mode mode,
                struct brdf_sample *delta) {
    rgb diffuse, glossy;
    float by_diffuse, pdf;
    if (!b->model->sample_glossy(b, wo, BRDF_GLOSSY, v3(0.0f, u.x, u.y), &delta->wi)) return false;
    b->model->pdf(b, wo, delta->wi, BRDF_GLOSSY, &by_diffuse, &pdf);
    if (!(pdf > 0.0f)) return false;
    b->model->eval(b, wo, delta->wi, &diffuse, &glossy);
    delta->weight = rgb_scale(glossy, delta->wi.z / pdf);
    const vec3 light = mode == BRDF_RADIANCE ? delta->wi : wo;
    if (brdf_has_bump(b))
        delta->weight = rgb_scale(delta->weight, brdf_bump_toward(b, delta->wi, light));
    return true;
}
