// SPDX-License-Identifier: Apache-2.0
// Private to load/: common to the files that build shapes.
#ifndef LOAD_PLUGINS_SHAPE_H
#define LOAD_PLUGINS_SHAPE_H

#include "load/load_params.h"

// Parameters that shapes have in common (load_plugins_shape.c).
extern const struct param_spec load_shape_to_world, load_shape_flip_normals;

// The elements that every shape takes.
#define SHAPE_CHILDREN (1u << XML_BSDF | 1u << XML_EMITTER)

#endif
