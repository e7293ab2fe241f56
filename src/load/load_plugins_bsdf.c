// SPDX-License-Identifier: Apache-2.0
// <bsdf>: materials. Names, parameters and defaults are those of Mitsuba 3. phong and ward are
// those of Mitsuba 0.6, with the spelling of version 3.
#include "load/load_plugins_bsdf.h"
#include "base/array.h"
#include "base/text.h"

static const char *const distributions[] = {"beckmann", "ggx", NULL};  // enum brdf_distribution
static const char *const variants[] = {"ward", "ward-duer", "balanced", NULL};  // enum brdf_variant

static const struct param_spec diffuse_reflectance = {
    "reflectance", PARAM_COLOR, ".5", RANGE_UNIT, PARAM_TEXTURE, NULL, "The albedo."};
const struct param_spec bsdf_diffuse_reflectance = {"diffuse_reflectance",
                                                    PARAM_COLOR,
                                                    ".5",
                                                    RANGE_UNIT,
                                                    PARAM_TEXTURE,
                                                    NULL,
                                                    "A factor of the diffuse reflection."};
const struct param_spec bsdf_specular_reflectance = {"specular_reflectance",
                                                     PARAM_COLOR,
                                                     "1",
                                                     RANGE_UNIT,
                                                     PARAM_TEXTURE,
                                                     NULL,
                                                     "A factor of the specular reflection."};
static const struct param_spec lobe_reflectance = {
    "specular_reflectance",        PARAM_COLOR, ".2", RANGE_UNIT, PARAM_TEXTURE, NULL,
    "A factor of the glossy lobe."};
static const struct param_spec specular_transmittance = {
    "specular_transmittance",       PARAM_COLOR, "1", RANGE_UNIT, PARAM_TEXTURE, NULL,
    "A factor of the transmission."};
const struct param_spec bsdf_glass_ior = {
    "int_ior",
    PARAM_IOR,
    "bk7",
    RANGE_POSITIVE,
    0,
    NULL,
    "The index of refraction inside, or the name of a medium."};
static const struct param_spec plastic_ior = {
    "int_ior",
    PARAM_IOR,
    "polypropylene",
    RANGE_POSITIVE,
    0,
    NULL,
    "The index of refraction inside, or the name of a medium."};
const struct param_spec bsdf_ext_ior = {
    "ext_ior",
    PARAM_IOR,
    "air",
    RANGE_POSITIVE,
    0,
    NULL,
    "The index of refraction outside, or the name of a medium."};
static const struct param_spec nonlinear = {"nonlinear",
                                            PARAM_BOOLEAN,
                                            "false",
                                            0,
                                            0,
                                            NULL,
                                            "If true, light that scatters several times inside is "
                                            "coloured by the diffuse reflectance each time."};
static const struct param_spec metal_name = {
    "material", PARAM_STRING, NULL, 0, 0, NULL, "The name of a metal, instead of `eta` and `k`."};
static const struct param_spec metal_eta = {"eta",
                                            PARAM_COLOR,
                                            "0",
                                            RANGE_MODEST,
                                            PARAM_TEXTURE,
                                            NULL,
                                            "The real part of the index of refraction."};
static const struct param_spec metal_k = {
    "k",
    PARAM_COLOR,
    "1",
    RANGE_MODEST,
    PARAM_TEXTURE,
    NULL,
    "The imaginary part of the index of refraction, which describes absorption."};
static const struct param_spec metal_ext_eta = {
    "ext_eta",
    PARAM_IOR,
    "vacuum",
    RANGE_POSITIVE,
    0,
    NULL,
    "The index of refraction outside, or the name of a medium. `eta` and `k` are divided by it."};
const struct param_spec bsdf_distribution = {"distribution",
                                             PARAM_CHOICE,
                                             "beckmann",
                                             0,
                                             0,
                                             distributions,
                                             "The distribution of the microfacets' normals."};
static const struct param_spec alpha = {"alpha",
                                        PARAM_FLOAT,
                                        ".1",
                                        RANGE_MODEST,
                                        PARAM_TEXTURE,
                                        NULL,
                                        "The roughness alpha of the microfacets."};
const struct param_spec bsdf_constant_alpha = {
    "alpha", PARAM_FLOAT, ".1", RANGE_MODEST, 0, NULL, "The roughness alpha of the microfacets."};
static const struct param_spec alpha_u = {
    "alpha_u", PARAM_FLOAT, NULL, RANGE_MODEST, PARAM_TEXTURE, NULL, "The roughness along u."};
static const struct param_spec alpha_v = {
    "alpha_v", PARAM_FLOAT, NULL, RANGE_MODEST, PARAM_TEXTURE, NULL, "The roughness along v."};
static const struct param_spec ward_alpha_u = {
    "alpha_u", PARAM_FLOAT, ".1", RANGE_MODEST, PARAM_TEXTURE, NULL, "The roughness along u."};
static const struct param_spec ward_alpha_v = {
    "alpha_v", PARAM_FLOAT, ".1", RANGE_MODEST, PARAM_TEXTURE, NULL, "The roughness along v."};
const struct param_spec bsdf_sample_visible = {"sample_visible",
                                               PARAM_BOOLEAN,
                                               "true",
                                               0,
                                               0,
                                               NULL,
                                               "It has no effect: Mitsuba uses it for sampling."};
static const struct param_spec phong_exponent = {"exponent",
                                                 PARAM_FLOAT,
                                                 "30",
                                                 RANGE_MODEST,
                                                 PARAM_TEXTURE,
                                                 NULL,
                                                 "The exponent of the lobe's cosine."};
static const struct param_spec variant = {
    "variant", PARAM_CHOICE, "balanced", 0, 0, variants, "The normalisation of the lobe."};

static const struct param_spec weight = {
    "weight",
    PARAM_FLOAT,
    NULL,
    RANGE_CLAMPED,
    PARAM_REQUIRED | PARAM_TEXTURE,
    NULL,
    "The weight of the second BRDF. Values of a texture are clamped to [0, 1]."};
static const struct param_spec bump_scale = {
    "scale", PARAM_FLOAT, "1", RANGE_ANY, 0, NULL, "A factor of the heights."};
static const struct param_spec normal_map = {
    "normalmap",
    PARAM_COLOR,
    NULL,
    0,
    PARAM_TEXTURE,
    NULL,
    "The components x, y, z of the normal in the surface's frame; values from 0 to 1 stand for -1 "
    "to 1. A texture of another name, or of none, is taken for it."};
static const struct param_spec flip_invalid = {
    "flip_invalid_normals",
    PARAM_BOOLEAN,
    "true",
    0,
    0,
    NULL,
    "If true, normals that point away from the viewer are mirrored."};
static const struct param_spec use_shadowing = {
    "use_shadowing_function",
    PARAM_BOOLEAN,
    "true",
    0,
    0,
    NULL,
    "If true, slopes of the map shadow light at grazing angles."};

static const struct param_spec opacity = {
    "opacity",
    PARAM_COLOR,
    ".5",
    RANGE_CLAMPED,
    PARAM_TEXTURE,
    NULL,
    "The opacity. Values of a texture are clamped to [0, 1]."};
static const struct param_spec groove_alpha = {
    "alpha",
    PARAM_FLOAT,
    ".2",
    RANGE_MODEST,
    PARAM_TEXTURE,
    NULL,
    "The roughness: the root mean square slope of the surface."};
static const struct param_spec fast_approximation = {
    "use_fast_approx",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "If true, light that goes from facet to facet is left out."};
static param_list mask_params = {&opacity, NULL};
static param_list blend_params = {&weight, NULL};
static param_list bump_params = {&bump_scale, &flip_invalid, &use_shadowing, NULL};
static param_list normal_params = {&normal_map, &flip_invalid, &use_shadowing, NULL};
static param_list diffuse_params = {&diffuse_reflectance, NULL};
static param_list roughdiffuse_params = {&diffuse_reflectance, &groove_alpha, &fast_approximation,
                                         NULL};
static param_list conductor_params = {
    &metal_name, &metal_eta, &metal_k, &bsdf_specular_reflectance, &metal_ext_eta, NULL};
static param_list roughconductor_params = {
    &metal_name,          &metal_eta,     &metal_k, &bsdf_specular_reflectance,
    &bsdf_distribution,   &alpha,         &alpha_u, &alpha_v,
    &bsdf_sample_visible, &metal_ext_eta, NULL};
static param_list dielectric_params = {&bsdf_glass_ior, &bsdf_ext_ior, &bsdf_specular_reflectance,
                                       &specular_transmittance, NULL};
static param_list roughdielectric_params = {&bsdf_glass_ior,
                                            &bsdf_ext_ior,
                                            &bsdf_specular_reflectance,
                                            &specular_transmittance,
                                            &bsdf_distribution,
                                            &alpha,
                                            &alpha_u,
                                            &alpha_v,
                                            &bsdf_sample_visible,
                                            NULL};
static param_list plastic_params = {&bsdf_diffuse_reflectance,
                                    &bsdf_specular_reflectance,
                                    &plastic_ior,
                                    &bsdf_ext_ior,
                                    &nonlinear,
                                    NULL};
static param_list roughplastic_params = {&bsdf_diffuse_reflectance,
                                         &bsdf_specular_reflectance,
                                         &plastic_ior,
                                         &bsdf_ext_ior,
                                         &nonlinear,
                                         &bsdf_distribution,
                                         &alpha,
                                         &bsdf_sample_visible,
                                         NULL};
static param_list phong_params = {&bsdf_diffuse_reflectance, &lobe_reflectance, &phong_exponent,
                                  NULL};
static param_list ward_params = {
    &bsdf_diffuse_reflectance, &lobe_reflectance, &variant, &ward_alpha_u, &ward_alpha_v, NULL};

// Reads alpha, or alpha_u and alpha_v.
static satin_status set_alpha(struct load_state *loader, const struct params *p,
                              struct material_side *side) {
    const struct param_value *u = load_param(p, "alpha_u"), *v = load_param(p, "alpha_v");
    if (u->given != v->given || (u->given && load_param(p, "alpha")->given)) {
        log_error_at(loader->log, p->node->place,
                     "roughness is either alpha, or both alpha_u and alpha_v");
        return SATIN_ERROR_INPUT;
    }
    if (!u->given) u = v = load_param(p, "alpha");
    satin_status status = load_bsdf_set_number(loader, u, side, BRDF_SLOT_ALPHA_U);
    return status == SATIN_OK ? load_bsdf_set_number(loader, v, side, BRDF_SLOT_ALPHA_V) : status;
}

static satin_status set_metal(struct load_state *loader, const struct params *p,
                              struct material_side *side) {
    const struct param_value *eta = load_param(p, "eta"), *k = load_param(p, "k");
    const struct param_value *material = load_param(p, "material");
    if (!material->given) {
        satin_status status = load_bsdf_set_color(loader, eta, side, BRDF_SLOT_ETA);
        if (status == SATIN_OK) status = load_bsdf_set_color(loader, k, side, BRDF_SLOT_K);
        // The default is a perfect mirror, in version 0.6 copper.
        rgb n, absorption;
        if (status == SATIN_OK && p->node->mitsuba06 && load_metal_find("Cu", &n, &absorption)) {
            if (!eta->given) side->base.eta = n;
            if (!k->given) side->base.k = absorption;
        }
        return status;
    }
    if (eta->given || k->given) {
        log_error_at(loader->log, material->place, "a metal is either a material, or eta and k");
        return SATIN_ERROR_INPUT;
    }
    if (load_metal_find(material->s, &side->base.eta, &side->base.k)) return SATIN_OK;
    char list[512];
    struct log_spared spared = {loader->log, loader->each, "it is a perfect mirror"};
    struct text_nearest nearest = {.word = material->s};
    for (int i = 0; load_metal_name(i); i++) text_nearest_try(&nearest, load_metal_name(i));
    const satin_status status = load_value_unknown(
        loader->lenient ? log_spare(&spared) : loader->log, "material", material->place, &nearest,
        load_names_list(load_metal_name, list, sizeof list));
    return loader->lenient ? SATIN_OK : status;
}

bool load_bsdf_ior_valid(struct load_state *loader, struct log_place place, const char *name,
                         float ior) {
    if (ior >= BRDF_IOR_MIN && ior <= BRDF_IOR_MAX) return true;
    log_error_at(loader->log, place, "%s is %g, but must be in [%g, %g]", name, (double)ior,
                 (double)BRDF_IOR_MIN, (double)BRDF_IOR_MAX);
    return false;
}

static satin_status set_ior(struct load_state *loader, const struct params *p,
                            struct material_side *side) {
    side->base.ior = load_param(p, "int_ior")->f / load_param(p, "ext_ior")->f;
    return load_bsdf_ior_valid(loader, p->node->place, "int_ior / ext_ior", side->base.ior)
               ? SATIN_OK
               : SATIN_ERROR_INPUT;
}

// Reads ext_eta, the index of the medium outside of a metal.
static satin_status set_outside(struct load_state *loader, const struct params *p,
                                struct material_side *side) {
    const struct param_value *outside = load_param(p, "ext_eta");
    if (outside->f == 1.0f) return SATIN_OK;
    if (!load_bsdf_ior_valid(loader, outside->place, "ext_eta", outside->f))
        return SATIN_ERROR_INPUT;
    if (side->slot[BRDF_SLOT_ETA] || side->slot[BRDF_SLOT_K]) {
        log_error_at(loader->log, outside->place, "ext_eta needs eta and k without textures");
        return SATIN_ERROR_INPUT;
    }
    side->base.eta = rgb_scale(side->base.eta, 1.0f / outside->f);
    side->base.k = rgb_scale(side->base.k, 1.0f / outside->f);
    return SATIN_OK;
}

// Scales the reflectances so that their sum, that of means of textures, is below 1, with Mitsuba
// 0.6's margin: paths that gain light would not end.
static satin_status check_glossy_albedo(struct load_state *loader, const struct params *p,
                                        struct material_side *side) {
    float most = rgb_max(rgb_add(side->base.diffuse, side->base.specular));
    if (most <= 1.0001f) return SATIN_OK;
    const float scale = ALBEDO_MOST / most;
    log_warning_at(loader->log, p->node->place,
                   "diffuse_reflectance and specular_reflectance sum to %g, which is over 1; "
                   "both are scaled by %.3g",
                   (double)most, (double)scale);
    const satin_status status = load_bsdf_scale(loader, side, BRDF_SLOT_DIFFUSE, scale);
    return status == SATIN_OK ? load_bsdf_scale(loader, side, BRDF_SLOT_SPECULAR, scale) : status;
}

static satin_status build_diffuse(struct load_state *loader, const struct params *p, void *object) {
    return load_bsdf_set_color(loader, load_param(p, "reflectance"), object, BRDF_SLOT_DIFFUSE);
}

static satin_status build_roughdiffuse(struct load_state *loader, const struct params *p,
                                       void *object) {
    struct material_side *side = object;
    const struct param_value *rough = load_param(p, "alpha");
    side->base.fast = load_param(p, "use_fast_approx")->b;
    side->base.alpha_u = rough->f;  // 0 is allowed: Lambertian
    if (rough->texture) {
        satin_status status = load_bsdf_set_number(loader, rough, side, BRDF_SLOT_ALPHA_U);
        if (status != SATIN_OK) return status;
    }
    return build_diffuse(loader, p, side);
}

static satin_status build_conductor(struct load_state *loader, const struct params *p,
                                    void *object) {
    satin_status status = set_metal(loader, p, object);
    if (status == SATIN_OK) status = set_outside(loader, p, object);
    if (status != SATIN_OK) return status;
    return load_bsdf_set_color(loader, load_param(p, "specular_reflectance"), object,
                               BRDF_SLOT_SPECULAR);
}

static satin_status build_roughconductor(struct load_state *loader, const struct params *p,
                                         void *object) {
    struct material_side *side = object;
    side->base.distribution = (enum brdf_distribution)load_param(p, "distribution")->i;
    satin_status status = build_conductor(loader, p, side);
    return status == SATIN_OK ? set_alpha(loader, p, side) : status;
}

static satin_status build_dielectric(struct load_state *loader, const struct params *p,
                                     void *object) {
    struct material_side *side = object;
    satin_status status = set_ior(loader, p, side);
    if (status == SATIN_OK)
        status = load_bsdf_set_color(loader, load_param(p, "specular_reflectance"), side,
                                     BRDF_SLOT_SPECULAR);
    if (status != SATIN_OK) return status;
    return load_bsdf_set_color(loader, load_param(p, "specular_transmittance"), side,
                               BRDF_SLOT_TRANSMITTANCE);
}

static satin_status build_roughdielectric(struct load_state *loader, const struct params *p,
                                          void *object) {
    struct material_side *side = object;
    side->base.distribution = (enum brdf_distribution)load_param(p, "distribution")->i;
    satin_status status = build_dielectric(loader, p, side);
    if (status == SATIN_OK) status = set_alpha(loader, p, side);
    if (status != SATIN_OK || side->base.ior != 1.0f) return status;
    log_error_at(loader->log, p->node->place, "int_ior and ext_ior must differ");
    return SATIN_ERROR_INPUT;
}

static satin_status build_null(struct load_state *loader, const struct params *p, void *object) {
    struct material_side *side = object;
    (void)loader, (void)p;
    side->base.transmittance = rgb_grey(1.0f);
    side->holes = true;
    return SATIN_OK;
}

static satin_status build_plastic(struct load_state *loader, const struct params *p, void *object) {
    struct material_side *side = object;
    side->base.nonlinear = load_param(p, "nonlinear")->b;
    satin_status status = set_ior(loader, p, side);
    return status == SATIN_OK ? load_bsdf_set_reflectances(loader, p, side) : status;
}

static satin_status build_roughplastic(struct load_state *loader, const struct params *p,
                                       void *object) {
    struct material_side *side = object;
    side->base.distribution = (enum brdf_distribution)load_param(p, "distribution")->i;
    const struct param_value *rough = load_param(p, "alpha");
    side->base.rough_texture = rough->texture != NULL;
    const satin_status status = load_bsdf_set_number(loader, rough, side, BRDF_SLOT_ALPHA_U);
    side->base.alpha_v = side->base.alpha_u;
    return status == SATIN_OK ? build_plastic(loader, p, side) : status;
}

static satin_status build_phong(struct load_state *loader, const struct params *p, void *object) {
    satin_status status = load_bsdf_set_reflectances(loader, p, object);
    if (status == SATIN_OK)
        status =
            load_bsdf_set_number(loader, load_param(p, "exponent"), object, BRDF_SLOT_EXPONENT);
    return status == SATIN_OK ? check_glossy_albedo(loader, p, object) : status;
}

static satin_status build_ward(struct load_state *loader, const struct params *p, void *object) {
    struct material_side *side = object;
    side->base.variant = (enum brdf_variant)load_param(p, "variant")->i;
    satin_status status = load_bsdf_set_reflectances(loader, p, side);
    if (status == SATIN_OK)
        status = load_bsdf_set_number(loader, load_param(p, "alpha_u"), side, BRDF_SLOT_ALPHA_U);
    if (status == SATIN_OK)
        status = load_bsdf_set_number(loader, load_param(p, "alpha_v"), side, BRDF_SLOT_ALPHA_V);
    return status == SATIN_OK ? check_glossy_albedo(loader, p, side) : status;
}

const struct plugin_spec load_bsdf_plugins[] = {
    {XML_BSDF, "diffuse", "Lambertian reflection", diffuse_params, 0, build_diffuse, false},
    {XML_BSDF, "roughdiffuse", "a rough diffuse surface, as in Mitsuba 0.6", roughdiffuse_params, 0,
     build_roughdiffuse, false},
    {XML_BSDF, "conductor", "a polished metal", conductor_params, 0, build_conductor, false},
    {XML_BSDF, "roughconductor", "a rough metal with microfacets", roughconductor_params, 0,
     build_roughconductor, false},
    {XML_BSDF, "dielectric", "a smooth boundary, as of glass or water", dielectric_params, 0,
     build_dielectric, false},
    {XML_BSDF, "thindielectric",
     "a thin pane, which does not change the direction of transmitted light", dielectric_params, 0,
     build_dielectric, false},
    {XML_BSDF, "roughdielectric", "a rough boundary with microfacets, as of ground glass",
     roughdielectric_params, 0, build_roughdielectric, false},
    {XML_BSDF, "null", "a boundary that does not change light", NULL, 0, build_null, false},
    {XML_BSDF, "plastic", "a diffuse base under a smooth coat", plastic_params, 0, build_plastic,
     false},
    {XML_BSDF, "roughplastic", "a diffuse base under a rough coat", roughplastic_params, 0,
     build_roughplastic, false},
    {XML_BSDF, "phong", "a diffuse component and a modified Phong lobe", phong_params, 0,
     build_phong, false},
    {XML_BSDF, "ward", "a diffuse component and Ward's anisotropic lobe", ward_params, 0,
     build_ward, false},
    {XML_BSDF, "lafortune", "a diffuse component and generalised cosine lobes",
     bsdf_lafortune_params, 0, load_bsdf_lafortune_build, false},
    {XML_BSDF, "merl", "a measured BRDF of the MERL database", bsdf_measured_params, 0,
     load_bsdf_merl_build, false},
    {XML_BSDF, "tabulated", "a measured BRDF in satin's text form", bsdf_measured_params, 0,
     load_bsdf_tabulated_build, false},
    {XML_BSDF, "principled",
     "a mixture of diffuse, metallic, transmitted, sheen and clear-coat components",
     bsdf_principled_params, 0, load_bsdf_principled_build, false},
    {XML_BSDF, "principledthin", "the principled BRDF of a thin sheet", bsdf_principledthin_params,
     0, load_bsdf_principledthin_build, false},
    {XML_BSDF, "difftrans", "diffuse transmission, as in Mitsuba 0.6", bsdf_difftrans_params, 0,
     load_bsdf_difftrans_build, false},
    {XML_BSDF, "coating", "a BRDF under a smooth coat, as in Mitsuba 0.6", bsdf_coat_params,
     1u << XML_BSDF, NULL, false},
    {XML_BSDF, "roughcoating", "a BRDF under a rough coat, as in Mitsuba 0.6",
     bsdf_roughcoat_params, 1u << XML_BSDF, NULL, false},
    {XML_BSDF, "twosided", "one BRDF for both sides, or two for front and back", NULL,
     1u << XML_BSDF, NULL, false},
    {XML_BSDF, "blendbsdf", "a weighted mean of two BRDFs", blend_params, 1u << XML_BSDF, NULL,
     false},
    {XML_BSDF, "mixturebsdf", "a weighted sum of BRDFs, as in Mitsuba 0.6", bsdf_mixture_params,
     1u << XML_BSDF, NULL, false},
    {XML_BSDF, "mask", "a BRDF with holes", mask_params, 1u << XML_BSDF, NULL, false},
    {XML_BSDF, "bumpmap", "a BRDF whose normal follows a height map, the <texture> inside",
     bump_params, 1u << XML_BSDF | 1u << XML_TEXTURE, NULL, false},
    {XML_BSDF, "normalmap", "a BRDF whose normal is read from a map, the <texture> inside",
     normal_params, 1u << XML_BSDF | 1u << XML_TEXTURE, NULL, false},
    {0}};

satin_status load_side_build(struct load_state *loader, const struct params *p,
                             struct material_side *side) {
    *side = (struct material_side){.index = loader->scene->side_count++};
    side->base.model = brdf_find(p->plugin->name);
    satin_status status = p->plugin->build(loader, p, side);
    if (status != SATIN_OK) return status;
    status = brdf_prepare(&side->base, &loader->scene->arena, &loader->tables);
    return status == SATIN_OK ? status : load_no_memory(loader);
}
