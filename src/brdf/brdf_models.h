// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: the rows of the table of models. A file brdf_X.c has one model, or two that are
// similar.
#ifndef BRDF_MODELS_H
#define BRDF_MODELS_H

#include "brdf/brdf.h"

extern const struct brdf_model brdf_model_diffuse, brdf_model_roughdiffuse;
extern const struct brdf_model brdf_model_conductor, brdf_model_roughconductor;
extern const struct brdf_model brdf_model_dielectric, brdf_model_thindielectric;
extern const struct brdf_model brdf_model_roughdielectric, brdf_model_null;
extern const struct brdf_model brdf_model_plastic, brdf_model_roughplastic;
extern const struct brdf_model brdf_model_principled, brdf_model_principledthin;
extern const struct brdf_model brdf_model_phong;
extern const struct brdf_model brdf_model_ward;
extern const struct brdf_model brdf_model_lafortune, brdf_model_merl, brdf_model_tabulated;

// Functions of a model (struct brdf_model): the density of a diffuse lobe alone, and probabilities
// of lobes by the means of their colours, without a delta lobe (brdf_diffuse.c).
void brdf_diffuse_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                      float *glossy);
void brdf_mean_probabilities(const struct brdf *b, vec3 wo, float *diffuse, float *glossy,
                             float *delta);

// The lobes of a coated BRDF that are not zero, given those of the nested one, and the model of
// that (brdf_coat.c).
unsigned brdf_coat_lobes(const struct brdf *b, unsigned nested);
const struct brdf_model *brdf_coat_nested(const struct brdf *b);

// Tabulates the albedo of the glossy lobe of b, if there is one, and adds its tables to `made` as
// brdf_prepare (brdf_albedo.c).
satin_status brdf_albedo_prepare(struct brdf *b, struct arena *arena,
                                 const struct brdf_glossy **made);
// Gives b the tables of a BRDF of the same shape. False if none is in the list.
bool brdf_albedo_reuse(struct brdf *b, const struct brdf_glossy *made);

// Whether a rotation of both directions about the normal changes nothing. All models except those
// with `asymmetric` are symmetric about the x and the y axis.
static inline bool brdf_isotropic(const struct brdf *b) {
    if (b->model->data) return b->isotropic;
    if (b->model->slots & 1u << BRDF_SLOT_ANISOTROPIC) return b->anisotropic == 0.0f;
    return !(b->model->slots & 1u << BRDF_SLOT_ALPHA_V) || b->alpha_u == b->alpha_v;
}

// The fraction of light from direction `light` that bump shadowing leaves, where w is the other
// direction or `light` itself (brdf_bump.c). Both are local to the rotated frame.
float brdf_bump_toward(const struct brdf *b, vec3 w, vec3 light);

// The mirror reflection of wo, as the only delta lobe.
static inline struct brdf_sample brdf_mirror(vec3 wo, rgb weight) {
    return (struct brdf_sample){.wi = v3(-wo.x, -wo.y, wo.z),
                                .weight = weight,
                                .probability = 1.0f,
                                .eta = 1.0f,
                                .lobe = BRDF_DELTA};
}

#endif
