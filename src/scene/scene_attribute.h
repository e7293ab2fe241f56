// SPDX-License-Identifier: Apache-2.0
// Private to scene/: attributes of meshes, which textures look up by their names. A mesh keeps
// those that the textures of its own material and emitter ask for.
#ifndef SCENE_ATTRIBUTE_H
#define SCENE_ATTRIBUTE_H

#include "scene/scene_build.h"

// The attribute of that name (the pointer counts) at a place; black if the mesh has none.
rgb attribute_eval(const char *name, const struct texture_place *at);
// The mean of a texture, where it is an attribute over the surface of the mesh.
rgb attribute_mean(const struct mesh *mesh, const struct texture *texture);

// Adds the names that the texture, or one nested in it, asks for; NULL: no texture. False if there
// are more than ATTRIBUTES_MAX.
bool attribute_want(struct attribute_names *names, const struct texture *texture);
// The same for all textures of a material.
bool attribute_want_all(struct attribute_names *names, const struct material *m);
// The first of the names that the mesh has not; NULL: it has all.
const char *attribute_missing(const struct attribute_names *names, const struct mesh *mesh);

#endif
