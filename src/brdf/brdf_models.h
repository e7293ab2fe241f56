// SPDX-License-Identifier: Apache-2.0
// The rows of the table of models, one per file brdf_X.c or two where they are kin. Private to
// brdf/.
#ifndef BRDF_MODELS_H
#define BRDF_MODELS_H

#include "brdf/brdf.h"

extern const struct brdf_model brdf_model_diffuse;
extern const struct brdf_model brdf_model_conductor, brdf_model_roughconductor;
extern const struct brdf_model brdf_model_dielectric, brdf_model_thindielectric;
extern const struct brdf_model brdf_model_roughdielectric, brdf_model_null;
extern const struct brdf_model brdf_model_plastic, brdf_model_roughplastic;
extern const struct brdf_model brdf_model_principled, brdf_model_principledthin;
extern const struct brdf_model brdf_model_phong;
extern const struct brdf_model brdf_model_ward;
extern const struct brdf_model brdf_model_lafortune, brdf_model_merl, brdf_model_tabulated;

// Tabulates the glossy albedo of b, if it has a glossy lobe (brdf_albedo.c).
satin_status brdf_albedo_prepare(struct brdf *b, struct arena *arena);

// Whether rotating both directions about the normal changes nothing. All models but uneven ones are
// symmetric about the x and the y axis.
static inline bool brdf_isotropic(const struct brdf *b) {
    if (b->model->data) return b->isotropic;
    if (b->model->slots & 1u << BRDF_SLOT_ANISOTROPIC) return b->anisotropic == 0.0f;
    return !(b->model->slots & 1u << BRDF_SLOT_ALPHA_V) || b->alpha_u == b->alpha_v;
}

// The ideal reflection of wo, as a delta lobe that takes all samples.
static inline struct brdf_sample brdf_mirror(vec3 wo, rgb weight) {
    return (struct brdf_sample){.wi = v3(-wo.x, -wo.y, wo.z),
                                .weight = weight,
                                .probability = 1.0f,
                                .eta = 1.0f,
                                .lobe = BRDF_DELTA};
}

#endif
