// SPDX-License-Identifier: Apache-2.0
// Private to scene/: shapes that coincide exactly with an earlier one. A ray tests all n surfaces
// of one position but shows one of them, so only the first of the file is kept, which costs one
// test.
#ifndef SCENE_COINCIDE_H
#define SCENE_COINCIDE_H

#include "scene/scene.h"

// Sets hidden[i] for shape first + i, i < count, and *found to their number: the shapes of the
// group whose surface equals, bit for bit, that of an earlier opaque shape. A surface that rays can
// pass is not hidden and hides nothing, except for instances, which let the same rays pass. The
// time is proportional to the size of the geometry, plus n log n for n shapes. False if there is no
// memory.
bool scene_coincide_find(const struct satin_scene *scene, uint32_t first, uint32_t count,
                         uint32_t group, bool *hidden, uint32_t *found);

#endif
