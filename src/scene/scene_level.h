// SPDX-License-Identifier: Apache-2.0
// Private to scene_trace.c: the ray tracing structure over one set of shapes. There is one for the
// scene itself and one for every group of shapes that instances place.
#ifndef SCENE_LEVEL_H
#define SCENE_LEVEL_H

#include "scene/scene_embree.h"
#include "scene/scene_interaction.h"
#include "scene/scene_quadric.h"

// A mesh as its filter sees it.
struct guard {
    const struct mesh *mesh;
    const struct material *mask;  // NULL if rays cannot pass
    struct interaction_error error;
};

struct level {
    RTCScene scene;
    uint32_t geometry_count;   // of all but the quadrics; ids of instances come after theirs
    uint32_t *geometry_shape;  // geometry id -> shape; the place of quadric_id is not used
    struct guard *guard;       // geometry id -> its filter's data
    uint32_t quadric_id, quadric_count;
    struct quadric *quadric;
    uint32_t hidden_count, hidden_first;  // shapes that lie where others do, and one of them
};

// Builds over the shapes `first` to `first + count - 1` that belong to `group` (0: to none). The
// groups' own levels, for its instances, are built before. On failure *level is to be freed too.
satin_status level_build(RTCDevice device, const struct satin_scene *scene, uint32_t first,
                         uint32_t count, uint32_t group, const struct level *groups, struct log log,
                         struct level *level);
void level_free(struct level *level);

// A status for what Embree reports, logged.
satin_status level_status(RTCDevice device, struct log log);

#endif
