// SPDX-License-Identifier: Apache-2.0
// Private to load/: the attributes that a mesh keeps, which are those that the textures of its own
// material and emitter refer to.
#ifndef LOAD_ATTRIBUTE_H
#define LOAD_ATTRIBUTE_H

#include "load/load_build.h"

// Adds the attributes to which the texture, or one nested in it, refers; NULL is no texture. False
// if there are more than ATTRIBUTES_MAX.
bool load_attribute_want(struct attribute_names *names, const struct texture *texture);
// Does what load_attribute_want does, for all textures of a material.
bool load_attribute_want_all(struct attribute_names *names, const struct material *m);
// The first of the names that the mesh does not have, or NULL if it has all.
const char *load_attribute_missing(const struct attribute_names *names, const struct mesh *mesh);

#endif
