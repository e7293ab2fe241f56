// SPDX-License-Identifier: Apache-2.0
// Private to scene/: choosing one of many lights.
#ifndef SCENE_LIGHT_TREE_H
#define SCENE_LIGHT_TREE_H

#include "scene/scene_light.h"

// Lights of a leaf, and the most that are chosen without a tree.
enum { LIGHT_LEAF_MAX = 8 };

// Builds scene->light_tree in the scene's arena, after all lights are prepared. SATIN_ERROR_MEMORY.
satin_status light_tree_build(struct satin_scene *scene);
// As light_choose and light_choose_probability.
uint32_t light_tree_choose(const struct satin_scene *scene, vec3 p, float u, float *probability);
float light_tree_probability(const struct satin_scene *scene, vec3 p, uint32_t light);

#endif
