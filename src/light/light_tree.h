// SPDX-License-Identifier: Apache-2.0
// Private to light/: choosing one of many lights.
#ifndef LIGHT_TREE_H
#define LIGHT_TREE_H

#include "light/light_kinds.h"

// The largest number of lights of a leaf, and of lights that are chosen without a tree.
enum { LIGHT_LEAF_MAX = 8 };

// Builds scene->light_tree in the scene's arena, after all lights are prepared. Fails with
// SATIN_ERROR_MEMORY.
satin_status light_tree_build(struct satin_scene *scene);
// Do what light_choose and light_choose_probability do.
uint32_t light_tree_choose(const struct satin_scene *scene, vec3 p, float *u, float *probability);
float light_tree_probability(const struct satin_scene *scene, vec3 p, uint32_t light);

#endif
