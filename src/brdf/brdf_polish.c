// SPDX-License-Identifier: Apache-2.0
// Metal of a small roughness is followed like a mirror: its model is replaced by one with a delta
// lobe, which has the directions of facets (brdf_conductor.c).
#include "brdf/brdf.h"

void brdf_polish(struct brdf *b) {
    if (b->model->if_polished && maxf(b->alpha_u, b->alpha_v) <= BRDF_POLISHED)
        b->model = b->model->if_polished;
}
