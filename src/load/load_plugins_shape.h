// SPDX-License-Identifier: Apache-2.0
// Private to load/: common to the files that build shapes.
#ifndef LOAD_PLUGINS_SHAPE_H
#define LOAD_PLUGINS_SHAPE_H

#include "load/load_params.h"
#include "scene/scene.h"

// Parameters that shapes have in common (load_plugins_shape.c).
extern const struct param_spec load_shape_to_world, load_shape_flip_normals;

// Names of materials of an OBJ.
struct obj_materials {
    const char *const *name;
    size_t count;
    bool others;  // whether faces of other materials are expected
};
// Reads the meshes of an OBJ's materials, and one of all other faces: count + 1. Sets whether the
// shape has facets.
satin_status load_shape_obj(struct load_state *loader, const struct params *p,
                            const struct obj_materials *materials, struct shape *shape,
                            struct mesh *out);

// Adds to the element of an OBJ without a BRDF, for each material of the files that it names, a
// <bsdf> of that name (load_mesh_mtl.c).
satin_status load_mesh_mtl(struct load_state *loader, const struct params *p);

// The elements that every shape takes.
#define SHAPE_CHILDREN (1u << XML_BSDF | 1u << XML_EMITTER)

#endif
