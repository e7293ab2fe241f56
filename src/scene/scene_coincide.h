// SPDX-License-Identifier: Apache-2.0
// Private to scene/: shapes that lie exactly where an earlier one does. A ray meets all surfaces of
// one position, so that n of them cost n tests per ray, and shows one; the first of the file is as
// good as any other, and alone it costs one test.
#ifndef SCENE_COINCIDE_H
#define SCENE_COINCIDE_H

#include "scene/scene.h"

// Fills hidden[i] for shape first + i, of `count`, and *found with their number: those of the group
// whose surface equals, bit for bit, that of an opaque earlier one. A surface that rays can pass is
// neither hidden nor hides others, but for instances, which let the same rays pass. Takes time
// proportional to the size of the geometry, and n log n for n shapes. False without memory.
bool coincide_find(const struct satin_scene *scene, uint32_t first, uint32_t count, uint32_t group,
                   bool *hidden, uint32_t *found);

#endif
