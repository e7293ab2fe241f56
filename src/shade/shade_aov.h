// SPDX-License-Identifier: Apache-2.0
// Private to shade/: values of the first surface that the scene asks for.
#ifndef SHADE_AOV_H
#define SHADE_AOV_H

#include "shade/shade_eye.h"

// Writes the values of p, which the eye ray of `camera` meets first, to
// out[scene->hints.aovs.values]: those of each kind begin at its `first`.
void shade_aov(const struct shade *shade, const struct gather_point *p,
               const struct shade_camera_sample *camera, float *out);
// The kind AOV_LIGHT of out: L, which is linear sRGB [W m^-2 sr^-1].
void shade_aov_light(const struct scene_aovs *aovs, rgb L, float *out);

#endif
