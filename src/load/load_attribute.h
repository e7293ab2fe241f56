// SPDX-License-Identifier: Apache-2.0
// Private to load/: which attributes a mesh keeps: those that the textures of its own material and
// emitter ask for.
#ifndef LOAD_ATTRIBUTE_H
#define LOAD_ATTRIBUTE_H

#include "load/load_build.h"

// Adds the names that the texture, or one nested in it, asks for; NULL: no texture. False if there
// are more than ATTRIBUTES_MAX.
bool attribute_want(struct attribute_names *names, const struct texture *texture);
// Names of attributes that all textures of a material want.
bool attribute_want_all(struct attribute_names *names, const struct material *m);
// The first of the names that the mesh has not; NULL: it has all.
const char *attribute_missing(const struct attribute_names *names, const struct mesh *mesh);

#endif
