// SPDX-License-Identifier: Apache-2.0
// Private to load/: common to the files that build BRDFs.
#ifndef LOAD_PLUGINS_BSDF_H
#define LOAD_PLUGINS_BSDF_H

#include "load/load_state.h"

typedef const struct param_spec *const param_list[];

// ---- Values of parameters (load_plugins_bsdf_values.c)

// Sets the slot of a colour or a number from a parameter: its value, or its texture and, as a
// constant for estimates, the texture's mean.
satin_status load_bsdf_set_color(struct load_state *loader, const struct param_value *value,
                                 struct material_side *side, enum brdf_slot slot);
satin_status load_bsdf_set_number(struct load_state *loader, const struct param_value *value,
                                  struct material_side *side, enum brdf_slot slot);
// The roughness that is used for a value in the file.
float load_bsdf_roughness(struct load_state *loader, const struct param_value *value);
// Sets the diffuse and the specular factor that many BRDFs have, and their rows of a table.
satin_status load_bsdf_set_reflectances(struct load_state *loader, const struct params *p,
                                        struct material_side *side);
// Multiplies a reflectance, or its texture, by a number.
satin_status load_bsdf_scale(struct load_state *loader, struct material_side *side,
                             enum brdf_slot slot, float by);
extern const struct param_spec bsdf_diffuse_reflectance, bsdf_specular_reflectance;
// load_plugins_bsdf.c
extern const struct param_spec bsdf_glass_ior, bsdf_ext_ior, bsdf_distribution, bsdf_constant_alpha,
    bsdf_sample_visible;

// ---- BRDFs

// Whether an index of refraction, called `name`, is in range; else logs an error.
bool load_bsdf_ior_valid(struct load_state *loader, struct log_place place, const char *name,
                         float ior);

// load_plugins_principled.c
extern param_list bsdf_principled_params, bsdf_principledthin_params, bsdf_difftrans_params;
satin_status load_bsdf_principled_build(struct load_state *loader, const struct params *p,
                                        void *object);
satin_status load_bsdf_principledthin_build(struct load_state *loader, const struct params *p,
                                            void *object);
satin_status load_bsdf_difftrans_build(struct load_state *loader, const struct params *p,
                                       void *object);

// load_plugins_material.c
extern param_list bsdf_mixture_params;

// load_plugins_coat.c
extern param_list bsdf_coat_params, bsdf_roughcoat_params;
// A coat with the textures that replace its colours, or NULL.
struct bsdf_coat {
    struct brdf_coating coating;
    const struct texture *specular, *depth;
};
satin_status load_bsdf_coat_read(struct load_state *loader, const struct params *p,
                                 struct bsdf_coat *out);
// Puts a coat, struct bsdf_coat in ctx, over a leaf. Logs an error if that is not possible.
satin_status load_bsdf_coat_side(struct load_state *loader, const struct params *p,
                                 struct material_side *leaf, const void *ctx);

// load_plugins_measured.c
extern param_list bsdf_lafortune_params, bsdf_measured_params;
satin_status load_bsdf_lafortune_build(struct load_state *loader, const struct params *p,
                                       void *object);
satin_status load_bsdf_merl_build(struct load_state *loader, const struct params *p, void *object);
satin_status load_bsdf_tabulated_build(struct load_state *loader, const struct params *p,
                                       void *object);

#endif
