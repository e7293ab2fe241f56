// SPDX-License-Identifier: Apache-2.0
// Private to scene/: surfaces with holes, components of blends that are nothing. A ray is stopped
// with the opacity there as the probability, drawn by the ray and the primitive alone; else it goes
// on as if there were no surface. So holes need no lobe of their own, and shadows, photons and
// records see through them.
#ifndef SCENE_OPACITY_H
#define SCENE_OPACITY_H

#include "scene/scene.h"

// The weight of component[1] of a blend.
float side_weight(const struct material_side *side, const struct texture_lookup *at);
// The fraction of it that is there: the weights of all components but the holes.
float side_opacity(const struct material_side *side, const struct texture_lookup *at);
// The shape's material if rays may pass it; else NULL. What emits is not passed.
const struct material *opacity_of(const struct satin_scene *scene, const struct shape *shape);
// Whether the ray from o along d is stopped at a point of primitive `salt`. A ray that sees the
// `whole` surface is unless nothing is there at all.
bool opacity_stops(const struct material *m, const struct texture_lookup *at, const struct ray *ray,
                   uint32_t salt, bool whole);

#endif
