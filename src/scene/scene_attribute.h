// SPDX-License-Identifier: Apache-2.0
// Private to scene/: attributes of meshes, which textures look up by their names.
#ifndef SCENE_ATTRIBUTE_H
#define SCENE_ATTRIBUTE_H

#include "scene/scene.h"

// The value at a lookup of the attribute whose name is the same pointer; black if the mesh has
// none.
rgb scene_attribute_eval(const char *name, const struct texture_lookup *at);
#endif
