// SPDX-License-Identifier: Apache-2.0
// Private to shade/: the per-pixel cache. Light that is interpolated between records hardly varies
// over a pixel of one surface, so a sample near an earlier one uses its values, which saves time
// for edges and direct light. Caustic photons do vary, and averaging over the samples of a pixel
// reduces their noise, so they are not cached.
#ifndef SHADE_PIXEL_CACHE_H
#define SHADE_PIXEL_CACHE_H

#include "gather/gather.h"
#include "shade/shade.h"

// The value for this point: one of the same surface less than two pixels away, with a similar
// normal and direction to the eye, or an empty one. `pixel` is the width of a pixel there.
struct shade_pixel_value *shade_pixel_cache_find(struct shade_pixel_cache *cache,
                                                 const struct shading_point *p, float pixel);

#endif
