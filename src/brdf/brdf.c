// SPDX-License-Identifier: Apache-2.0
// What all models share: the table of models, and evaluation and sampling of a choice of lobes.
// Sampling picks a lobe by the model's shares, restricted to the lobes asked for; the density of a
// direction is that of the mixture of the smooth lobes among them.
#include "brdf/brdf.h"

#include <string.h>

#include "base/sampling.h"
#include "brdf/brdf_models.h"

const struct brdf_model *const brdf_models[] = {
    &brdf_model_diffuse,        &brdf_model_conductor,
    &brdf_model_roughconductor, &brdf_model_dielectric,
    &brdf_model_thindielectric, &brdf_model_plastic,
    &brdf_model_roughplastic,   &brdf_model_phong,
    &brdf_model_ward,           &(const struct brdf_model){.name = NULL}};

const struct brdf_model *brdf_find(const char *name) {
    for (int i = 0; brdf_models[i]->name; i++)
        if (!strcmp(brdf_models[i]->name, name)) return brdf_models[i];
    return NULL;
}

satin_status brdf_prepare(struct brdf *b, struct arena *arena) {
    satin_status status = b->model->prepare ? b->model->prepare(b, arena) : SATIN_OK;
    return status ? status : brdf_albedo_prepare(b, arena);
}

unsigned brdf_lobes(const struct brdf *b) {
    unsigned lobes = b->model->lobes;
    if (rgb_black(b->diffuse)) lobes &= ~(unsigned)BRDF_DIFFUSE;
    if (rgb_black(b->specular)) {
        lobes &= ~(unsigned)BRDF_GLOSSY;
        if (!b->model->transmits || rgb_black(b->transmittance)) lobes &= ~(unsigned)BRDF_DELTA;
    }
    return lobes;
}

// Probabilities of choosing a lobe.
struct shares {
    float diffuse, glossy, delta;
};

// False if none of the lobes asked for scatters light of wo.
static bool lobe_shares(const struct brdf *b, vec3 wo, unsigned lobes, struct shares *out) {
    lobes &= brdf_lobes(b);
    if (!(wo.z > 0.0f)) lobes &= b->model->transmits ? BRDF_DELTA : 0u;
    struct shares s = {1.0f, 1.0f, 1.0f};
    if (b->model->shares) b->model->shares(b, wo, &s.diffuse, &s.glossy, &s.delta);
    if (!(lobes & BRDF_DIFFUSE)) s.diffuse = 0.0f;
    if (!(lobes & BRDF_GLOSSY)) s.glossy = 0.0f;
    if (!(lobes & BRDF_DELTA)) s.delta = 0.0f;
    float sum = s.diffuse + s.glossy + s.delta;
    if (!(sum > 0.0f)) return false;
    *out = (struct shares){s.diffuse / sum, s.glossy / sum, s.delta / sum};
    return true;
}

static bool above(vec3 wo, vec3 wi) { return wo.z > 0.0f && wi.z > 0.0f; }

// Both directions above, some smooth lobe in `lobes`.
static rgb eval_smooth(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes) {
    rgb diffuse, glossy;
    b->model->eval(b, wo, wi, &diffuse, &glossy);
    if (!(lobes & BRDF_DIFFUSE)) return glossy;
    return lobes & BRDF_GLOSSY ? rgb_add(diffuse, glossy) : diffuse;
}

static float pdf_smooth(const struct brdf *b, vec3 wo, vec3 wi, struct shares s) {
    float diffuse, glossy;
    b->model->pdf(b, wo, wi, &diffuse, &glossy);
    return s.diffuse * diffuse + s.glossy * glossy;
}

rgb brdf_eval(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes) {
    if (!above(wo, wi) || !(b->model->lobes & lobes & BRDF_SMOOTH)) return rgb_grey(0.0f);
    return eval_smooth(b, wo, wi, lobes);
}

float brdf_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes) {
    struct shares s;
    if (!above(wo, wi) || !(b->model->lobes & lobes & BRDF_SMOOTH)) return 0.0f;
    return lobe_shares(b, wo, lobes, &s) ? pdf_smooth(b, wo, wi, s) : 0.0f;
}

// One delta lobe, chosen by u in [0, 1); `share` is the probability of having come here.
static bool sample_delta(const struct brdf *b, vec3 wo, float u, float share, enum brdf_mode mode,
                         struct brdf_sample *out) {
    struct brdf_sample lobe[2];
    int n = b->model->delta(b, wo, mode, lobe);
    if (n == 0) return false;
    *out = lobe[n == 2 && u >= lobe[0].probability];
    out->probability *= share;
    out->weight = rgb_scale(out->weight, 1.0f / out->probability);
    return true;
}

bool brdf_sample(const struct brdf *b, vec3 wo, float u_lobe, float u, float v, unsigned lobes,
                 enum brdf_mode mode, struct brdf_sample *out) {
    struct shares s;
    if (!lobe_shares(b, wo, lobes, &s)) return false;
    if (u_lobe < s.delta) return sample_delta(b, wo, u_lobe / s.delta, s.delta, mode, out);
    bool glossy = u_lobe < s.delta + s.glossy || s.diffuse == 0.0f;
    vec3 wi;
    if (!glossy)
        wi = sample_cosine_hemisphere(u, v);
    else if (!b->model->sample_glossy(b, wo, u, v, &wi))
        return false;
    if (!above(wo, wi)) return false;
    float pdf = pdf_smooth(b, wo, wi, s);
    if (!(pdf > 0.0f)) return false;
    rgb f = eval_smooth(b, wo, wi, lobes);
    *out = (struct brdf_sample){.wi = wi,
                                .weight = rgb_scale(f, wi.z / pdf),
                                .pdf_w = pdf,
                                .probability = 1.0f,
                                .eta = 1.0f,
                                .lobe = glossy ? BRDF_GLOSSY : BRDF_DIFFUSE};
    return true;
}

int brdf_delta(const struct brdf *b, vec3 wo, enum brdf_mode mode, struct brdf_sample out[2]) {
    return b->model->delta ? b->model->delta(b, wo, mode, out) : 0;
}
