// SPDX-License-Identifier: Apache-2.0
// Private to scene_trace.c: the acceleration structure for rays over one set of shapes. There is
// one for the scene itself and one for every group of shapes that has instances.
#ifndef SCENE_ACCEL_H
#define SCENE_ACCEL_H

#include "scene/scene_embree.h"
#include "scene/scene_interaction.h"
#include "scene/scene_quadric.h"

// The data of a mesh for its intersection filter.
struct guard {
    const struct mesh *mesh;
    const struct material *mask;  // NULL if rays cannot pass
    struct interaction_error error;
};

struct accel {
    RTCScene scene;
    uint32_t geometry_count;   // number of geometries without the quadrics; ids of instances follow
    uint32_t *geometry_shape;  // geometry id -> shape; the entry of quadric_id is unused
    struct guard *guard;       // geometry id -> data of its filter
    uint32_t quadric_id, quadric_count;
    struct quadric *quadric;
    uint32_t *hidden, hidden_count;  // the shapes that coincide with others, which hide them
};

// The shapes `first` to `first + count - 1` that belong to `group` (0: to none).
struct accel_shapes {
    uint32_t first, count, group;
};
// Builds a structure over shapes. Those of the groups that have instances in it (`groups`) must be
// built before. On failure *accel must be freed too.
satin_status scene_accel_build(RTCDevice device, const struct satin_scene *scene,
                               struct accel_shapes shapes, const struct accel *groups,
                               struct log log, struct accel *accel);
void scene_accel_free(struct accel *accel);

// Converts Embree's error to a status, and logs it.
satin_status scene_accel_status(RTCDevice device, struct log log);

#endif
