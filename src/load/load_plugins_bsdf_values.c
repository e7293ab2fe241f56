// SPDX-License-Identifier: Apache-2.0
// The values of a BRDF's parameters: numbers and colours of the file, or textures.
#include "load/load_plugins_bsdf.h"

// Smaller roughnesses degenerate in single precision; it is also Mitsuba's limit.
#define ALPHA_MIN 1e-4f

// Limits the mean of a reflectance or transmittance to what counts of its texture
// (scene_material.c), with a warning if that is known to have more.
static void limit_reflectance(struct load_state *loader, const struct param_value *value,
                              const struct texture *texture, rgb *mean) {
    float lo, hi;
    *mean = rgb_at_most(*mean, 1.0f);
    if (scene_texture_range(texture, &lo, &hi) && hi > 1.0001f)
        log_warning_at(loader->log, value->place,
                       "a reflectance of up to %g in a texture: values over 1 count as 1",
                       (double)hi);
}

satin_status load_bsdf_set_color(struct load_state *loader, const struct param_value *value,
                                 struct material_side *side, enum brdf_slot slot) {
    rgb *field = brdf_color(&side->base, slot);
    *field = value->color;
    if (!value->texture) return SATIN_OK;
    satin_status status = load_texture_of(loader, value->texture, &side->slot[slot]);
    if (status != SATIN_OK) return status;
    *field = side->slot[slot]->mean;
    if (slot < BRDF_SLOT_ETA) limit_reflectance(loader, value, side->slot[slot], field);
    return SATIN_OK;
}

float load_bsdf_roughness(struct load_state *loader, const struct param_value *value) {
    if (value->given && value->f < ALPHA_MIN)
        log_warning_at(loader->log, value->place, "a roughness of %g counts as %g",
                       (double)value->f, (double)ALPHA_MIN);
    return fmaxf(value->f, ALPHA_MIN);
}

satin_status load_bsdf_set_number(struct load_state *loader, const struct param_value *value,
                                  struct material_side *side, enum brdf_slot slot) {
    bool rough = slot == BRDF_SLOT_ALPHA_U || slot == BRDF_SLOT_ALPHA_V;
    float number = value->f;
    if (value->texture) {
        satin_status status = load_texture_of(loader, value->texture, &side->slot[slot]);
        if (status != SATIN_OK) return status;
        number = rgb_luminance(side->slot[slot]->mean);
    }
    if (rough)
        number = value->texture ? fmaxf(number, ALPHA_MIN) : load_bsdf_roughness(loader, value);
    *brdf_number(&side->base, slot) = fmaxf(number, 0.0f);
    return SATIN_OK;
}

satin_status load_bsdf_set_reflectances(struct load_state *loader, const struct params *p,
                                        struct material_side *side) {
    satin_status status =
        load_bsdf_set_color(loader, load_param(p, "diffuse_reflectance"), side, BRDF_SLOT_DIFFUSE);
    if (status != SATIN_OK) return status;
    return load_bsdf_set_color(loader, load_param(p, "specular_reflectance"), side,
                               BRDF_SLOT_SPECULAR);
}

satin_status load_bsdf_scale(struct load_state *loader, struct material_side *side,
                             enum brdf_slot slot, float by) {
    rgb *mean = brdf_color(&side->base, slot);
    *mean = rgb_scale(*mean, by);
    if (!side->slot[slot]) return SATIN_OK;
    struct texture *scaled = arena_alloc(&loader->scene->arena, sizeof *scaled);
    if (!scaled) return load_no_memory(loader);
    load_texture_scale(side->slot[slot], rgb_grey(by), scaled);
    side->slot[slot] = scaled;
    return SATIN_OK;
}
