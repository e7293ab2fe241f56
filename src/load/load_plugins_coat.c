// SPDX-License-Identifier: Apache-2.0
// The coats of Mitsuba 0.6, coating and roughcoating: their parameters, and how they are put over
// the leaves of a material. Reflection is linear, so a coat over a blend is a blend of coats.
#include "load/load_plugins_bsdf.h"

static const struct param_spec thickness = {
    "thickness",
    PARAM_FLOAT,
    "1",
    RANGE_MODEST,
    0,
    NULL,
    "The thickness of the coat, in the inverse unit of `sigma_a`."};
static const struct param_spec sigma_a = {"sigma_a",
                                          PARAM_COLOR,
                                          "0",
                                          RANGE_MODEST,
                                          PARAM_TEXTURE,
                                          NULL,
                                          "The absorption coefficient of the coat."};

param_list bsdf_coat_params = {
    &bsdf_glass_ior, &bsdf_ext_ior, &thickness, &sigma_a, &bsdf_specular_reflectance, NULL};
param_list bsdf_roughcoat_params = {&bsdf_glass_ior,
                                    &bsdf_ext_ior,
                                    &thickness,
                                    &sigma_a,
                                    &bsdf_specular_reflectance,
                                    &bsdf_distribution,
                                    &bsdf_constant_alpha,
                                    &bsdf_sample_visible,
                                    NULL};

// The absorption across the coat, constant or textured. Textures give colours of which each
// channel counts.
static satin_status read_depth(struct load_state *loader, const struct params *p,
                               struct bsdf_coat *out) {
    const struct param_value *sigma = load_param(p, "sigma_a");
    const rgb by = rgb_grey(load_param(p, "thickness")->f);
    if (!sigma->texture) {
        out->coating.depth = rgb_mul(sigma->color, by);
        return SATIN_OK;
    }
    const struct texture *inner;
    struct texture *scaled = arena_alloc(&loader->scene->arena, sizeof *scaled);
    if (!scaled) return load_no_memory(loader);
    satin_status status = load_texture_of(loader, sigma->texture, &inner);
    if (status != SATIN_OK) return status;
    load_texture_scale(inner, by, scaled);
    out->depth = scaled;
    out->coating.depth = scaled->mean;
    return SATIN_OK;
}

satin_status load_bsdf_coat_read(struct load_state *loader, const struct params *p,
                                 struct bsdf_coat *out) {
    const bool rough = load_params_has(p, "alpha");
    const struct param_value *specular = load_param(p, "specular_reflectance");
    *out = (struct bsdf_coat){0};
    struct brdf_coating *c = &out->coating;
    c->ior = load_param(p, "int_ior")->f / load_param(p, "ext_ior")->f;
    if (!load_bsdf_ior_valid(loader, p->node->place, "int_ior / ext_ior", c->ior))
        return SATIN_ERROR_INPUT;
    if (rough && c->ior == 1.0f) return load_refuse(loader, p, "int_ior and ext_ior must differ");
    if (rough) {
        c->alpha = load_bsdf_roughness(loader, load_param(p, "alpha"));
        c->distribution = (enum brdf_distribution)load_param(p, "distribution")->i;
    }
    c->specular = specular->color;
    if (specular->texture) {
        satin_status status = load_texture_of(loader, specular->texture, &out->specular);
        if (status != SATIN_OK) return status;
        c->specular = rgb_at_most(out->specular->mean, 1.0f);
    }
    return read_depth(loader, p, out);
}

satin_status load_bsdf_coat_side(struct load_state *loader, const struct params *p,
                                 struct material_side *leaf, const void *ctx) {
    const struct bsdf_coat *coat = ctx;
    if (leaf->base.coat) return load_refuse(loader, p, "a coat cannot wrap another one");
    if (leaf->holes)
        return load_refuse(loader, p, "it cannot wrap a mask or null; a mask may be around it");
    if (brdf_transmits(&leaf->base)) {
        log_error_at(loader->log, p->node->place, "'%s' transmits, so it cannot have a coat",
                     leaf->base.model->name);
        return SATIN_ERROR_INPUT;
    }
    if (brdf_coat_set(&leaf->base, &loader->scene->arena, &coat->coating) != SATIN_OK)
        return load_no_memory(loader);
    leaf->slot[BRDF_SLOT_COAT_SPECULAR] = coat->specular;
    leaf->slot[BRDF_SLOT_COAT_DEPTH] = coat->depth;
    return SATIN_OK;
}
