// SPDX-License-Identifier: Apache-2.0
// Private to scene/: surfaces with holes, which are null components of blends. A ray is stopped
// with the opacity as the probability, drawn by the ray and the primitive alone; otherwise it
// continues as if there were no surface. So holes need no lobe, and shadow rays, photons and
// records see through them.
#ifndef SCENE_OPACITY_H
#define SCENE_OPACITY_H

#include "scene/scene.h"

// The weight of component[1] of a blend.
float scene_opacity_weight(const struct material_side *side, const struct texture_lookup *at);
// The opacity of a side: the sum of the weights of all components but the holes.
float scene_opacity_side(const struct material_side *side, const struct texture_lookup *at);
// The shape's material if rays may pass it, else NULL. Rays do not pass surfaces that emit light.
const struct material *scene_opacity_of(const struct satin_scene *scene, const struct shape *shape);
// Whether the ray from o along d is stopped at a point of primitive `salt`. With `whole` it is
// stopped unless the opacity is 0.
bool scene_opacity_stops(const struct material *m, const struct texture_lookup *at,
                         const struct ray *ray, uint32_t salt, bool whole);

#endif
