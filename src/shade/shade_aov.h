// SPDX-License-Identifier: Apache-2.0
// Private to shade/: values of the first surface that the scene asks for.
#ifndef SHADE_AOV_H
#define SHADE_AOV_H

#include "shade/shade_eye.h"

// Those of p, which the eye ray `lens` meets first: out[scene->hints.aovs.values], of each kind
// from its `first` on.
void shade_aov(const struct shade *shade, const struct gather_point *p,
               const struct shade_lens *lens, float *out);
// The kind AOV_LIGHT of out: L, which is linear sRGB [W m^-2 sr^-1].
void shade_aov_light(const struct scene_aovs *aovs, rgb L, float *out);

#endif
