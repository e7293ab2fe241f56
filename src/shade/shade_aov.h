// SPDX-License-Identifier: Apache-2.0
// Private to shade/: values of the first surface for the scene's AOVs.
#ifndef SHADE_AOV_H
#define SHADE_AOV_H

#include "shade/shade_eye.h"

// Writes the values of p, the first surface that the eye ray of `camera` hits, to
// out[scene->hints.aovs.values], where those of each kind begin at its `first`.
void shade_aov(const struct shade *shade, const struct shading_point *p,
               const struct shade_camera_sample *camera, float *out);
// Writes the values of AOV_LIGHT: L, which is linear sRGB [W m^-2 sr^-1].
void shade_aov_light(const struct scene_aovs *aovs, rgb L, float *out);

#endif
