// SPDX-License-Identifier: Apache-2.0
// <bsdf type="principled"> and "principledthin": parameters and defaults of Mitsuba 3. "difftrans"
// of Mitsuba 0.6 is a special case.
#include <string.h>

#include "load/load_plugins_bsdf.h"

#define NUMBER(name, default_text, doc) \
    { #name, PARAM_FLOAT, default_text, RANGE_UNIT, PARAM_TEXTURE, NULL, doc }

static const struct param_spec base_color = {"base_color",
                                             PARAM_COLOR,
                                             ".5",
                                             RANGE_UNIT,
                                             PARAM_TEXTURE,
                                             NULL,
                                             "The colour of all components."};
static const struct param_spec roughness = NUMBER(
    roughness, ".5", "The perceived roughness of the microfacets; their alpha is its square.");
static const struct param_spec anisotropic =
    NUMBER(anisotropic, "0", "How much highlights are elongated along u: 0 is isotropic.");
static const struct param_spec metallic =
    NUMBER(metallic, "0", "The weight of the metallic component.");
static const struct param_spec spec_trans =
    NUMBER(spec_trans, "0",
           "The fraction of the light below the surface that is transmitted; the rest is reflected "
           "diffusely.");
static const struct param_spec eta = {
    "eta", PARAM_FLOAT, NULL, RANGE_POSITIVE, 0, NULL, "The relative index of refraction."};
static const struct param_spec thin_eta = {"eta",
                                           PARAM_FLOAT,
                                           "1.5",
                                           RANGE_POSITIVE,
                                           PARAM_TEXTURE,
                                           NULL,
                                           "The relative index of refraction."};
static const struct param_spec specular = {
    "specular",
    PARAM_FLOAT,
    ".5",
    RANGE_NOT_NEGATIVE,
    0,
    NULL,
    "The reflectance at normal incidence in units of 8 %, instead of `eta`, at most 12."};
static const struct param_spec spec_tint =
    NUMBER(spec_tint, "0", "How much the base colour tints the dielectric reflection.");
static const struct param_spec sheen =
    NUMBER(sheen, "0", "The weight of sheen, a reflection at grazing angles, as of cloth.");
static const struct param_spec sheen_tint =
    NUMBER(sheen_tint, "0", "How much the base colour tints the sheen.");
static const struct param_spec flatness =
    NUMBER(flatness, "0",
           "A blend from diffuse reflection, at 0, to an approximation of subsurface scattering, "
           "as of skin or wax, at 1.");
static const struct param_spec clearcoat =
    NUMBER(clearcoat, "0", "The weight of a second specular lobe, that of a clear coat.");
static const struct param_spec clearcoat_gloss =
    NUMBER(clearcoat_gloss, "0", "The gloss of the clear coat: 0 is satin, 1 is glossy.");
static const struct param_spec diff_trans = {
    "diff_trans",
    PARAM_FLOAT,
    "0",
    RANGE_NOT_NEGATIVE,
    PARAM_TEXTURE,
    NULL,
    "The diffuse transmission, at most 2: at 0 all diffuse light is reflected, at 2 all is "
    "transmitted."};

// The sampling rate that Mitsuba has for a lobe.
#define RATE(name)                                            \
    {                                                         \
#name, PARAM_FLOAT, "1", RANGE_NOT_NEGATIVE, 0, NULL, \
            "It has no effect: Mitsuba uses it for sampling." \
    }
static const struct param_spec rate[] = {
    RATE(main_specular_sampling_rate),          RATE(clearcoat_sampling_rate),
    RATE(diffuse_reflectance_sampling_rate),    RATE(specular_reflectance_sampling_rate),
    RATE(specular_transmittance_sampling_rate), RATE(diffuse_transmittance_sampling_rate)};

param_list bsdf_principled_params = {
    &base_color,      &roughness, &anisotropic, &metallic,   &spec_trans, &eta,
    &specular,        &spec_tint, &sheen,       &sheen_tint, &flatness,   &clearcoat,
    &clearcoat_gloss, &rate[0],   &rate[1],     &rate[2],    NULL};
param_list bsdf_principledthin_params = {
    &base_color, &roughness,  &anisotropic, &spec_trans, &thin_eta, &spec_tint, &sheen, &sheen_tint,
    &flatness,   &diff_trans, &rate[2],     &rate[3],    &rate[4],  &rate[5],   NULL};

static const struct param_spec diffuse_transmittance = {
    "transmittance",
    PARAM_COLOR,
    ".5",
    RANGE_UNIT,
    PARAM_TEXTURE,
    NULL,
    "The fraction of the light that is transmitted; none is reflected."};
param_list bsdf_difftrans_params = {&diffuse_transmittance, NULL};

// The reflectance at normal incidence is .08 times `specular`, which would be 1 at 12.5.
#define PRINCIPLED_SPECULAR_MAX 12.0f

struct slot_name {
    const char *name;
    enum brdf_slot slot;
};

// `list` ends with a NULL name.
static satin_status set_numbers(struct load_state *loader, const struct params *p,
                                struct material_side *side, const struct slot_name *list) {
    satin_status status = SATIN_OK;
    for (; list->name && status == SATIN_OK; list++)
        status = load_bsdf_set_number(loader, load_param(p, list->name), side, list->slot);
    return status;
}

static satin_status set_common(struct load_state *loader, const struct params *p,
                               struct material_side *side) {
    static const struct slot_name numbers[] = {
        {"roughness", BRDF_SLOT_ALPHA_U},     {"anisotropic", BRDF_SLOT_ANISOTROPIC},
        {"spec_trans", BRDF_SLOT_SPEC_TRANS}, {"spec_tint", BRDF_SLOT_SPEC_TINT},
        {"sheen", BRDF_SLOT_SHEEN},           {"sheen_tint", BRDF_SLOT_SHEEN_TINT},
        {"flatness", BRDF_SLOT_FLATNESS},     {NULL, 0}};
    side->base.specular = side->base.transmittance = rgb_grey(1.0f);
    satin_status status =
        load_bsdf_set_color(loader, load_param(p, "base_color"), side, BRDF_SLOT_DIFFUSE);
    return status == SATIN_OK ? set_numbers(loader, p, side, numbers) : status;
}

satin_status load_bsdf_principled_build(struct load_state *loader, const struct params *p,
                                        void *object) {
    static const struct slot_name numbers[] = {{"metallic", BRDF_SLOT_METALLIC},
                                               {"clearcoat", BRDF_SLOT_CLEARCOAT},
                                               {"clearcoat_gloss", BRDF_SLOT_CLEARCOAT_GLOSS},
                                               {NULL, 0}};
    struct material_side *side = object;
    const struct param_value *index = load_param(p, "eta"), *reflects = load_param(p, "specular");
    if (index->given && reflects->given) {
        log_error_at(loader->log, p->node->place, "the reflectance is either eta or specular");
        return SATIN_ERROR_INPUT;
    }
    if (reflects->f > PRINCIPLED_SPECULAR_MAX) {
        log_error_at(loader->log, reflects->place, "specular is %g, but must be in [0, %g]",
                     (double)reflects->f, (double)PRINCIPLED_SPECULAR_MAX);
        return SATIN_ERROR_INPUT;
    }
    if (index->given && !load_bsdf_ior_valid(loader, index->place, "eta", index->f))
        return SATIN_ERROR_INPUT;
    satin_status status = set_common(loader, p, side);
    if (status == SATIN_OK) status = set_numbers(loader, p, side, numbers);
    side->base.opaque = !side->slot[BRDF_SLOT_SPEC_TRANS] && side->base.spec_trans == 0.0f;
    // Light that is transmitted needs a boundary: as in Mitsuba, its IOR is then never exactly 1.
    float least = side->base.opaque ? 0.0f : 1e-3f;
    side->base.ior = 2.0f / (1.0f - sqrtf(0.08f * fmaxf(reflects->f, least))) - 1.0f;
    if (index->given) side->base.ior = index->f == 1.0f && !side->base.opaque ? 1.001f : index->f;
    return status;
}

satin_status load_bsdf_principledthin_build(struct load_state *loader, const struct params *p,
                                            void *object) {
    static const struct slot_name numbers[] = {
        {"diff_trans", BRDF_SLOT_DIFF_TRANS}, {"eta", BRDF_SLOT_IOR}, {NULL, 0}};
    struct material_side *side = object;
    const struct param_value *index = load_param(p, "eta"), *passes = load_param(p, "diff_trans");
    satin_status status = set_common(loader, p, side);
    if (status == SATIN_OK) status = set_numbers(loader, p, side, numbers);
    if (status != SATIN_OK) return status;
    if (index->texture)
        side->base.ior = clampf(side->base.ior, BRDF_IOR_MIN, BRDF_IOR_MAX);
    else if (!load_bsdf_ior_valid(loader, index->place, "eta", index->f))
        return SATIN_ERROR_INPUT;
    if (side->base.diff_trans <= 2.0f) return SATIN_OK;
    log_error_at(loader->log, passes->place, "diff_trans is over 2");
    return SATIN_ERROR_INPUT;
}

// The diffuse transmission of `principledthin` alone.
satin_status load_bsdf_difftrans_build(struct load_state *loader, const struct params *p,
                                       void *object) {
    struct material_side *side = object;
    side->base.model = brdf_find("principledthin");
    side->base.specular = side->base.transmittance = rgb_grey(1.0f);
    side->base.ior = 1.5f;
    side->base.alpha_u = 0.5f;
    side->base.diff_trans = 2.0f;
    return load_bsdf_set_color(loader, load_param(p, "transmittance"), side, BRDF_SLOT_DIFFUSE);
}
