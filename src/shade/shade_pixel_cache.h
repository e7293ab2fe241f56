// SPDX-License-Identifier: Apache-2.0
// Private to shade/: the per-pixel cache. Light that is interpolated between records varies little
// over a pixel of one surface, so its mean over a few positions serves all samples there, which
// saves time for edges and direct light. Caustic photons do vary, and averaging over the samples of
// a pixel reduces their noise, so they are not cached.
#ifndef SHADE_PIXEL_CACHE_H
#define SHADE_PIXEL_CACHE_H

#include "gather/gather.h"
#include "shade/shade.h"

// The value for this point: one of the same surface less than two pixels away, with a similar
// normal and direction to the eye, or an empty one. `pixel` is the width of a pixel there.
struct shade_pixel_value *shade_pixel_cache_find(struct shade_pixel_cache *cache,
                                                 const struct shading_point *p, float pixel);

// Whether the records of a kind should be read at one more position, as their mean is not certain.
bool shade_pixel_light_wanted(const struct shade_pixel_value *value, enum cache_kind kind);
// Adds what the records have given at a position: the sums of `used`, and the two kinds of light.
void shade_pixel_light_add(struct shade_pixel_light *light, struct cache_used used, rgb glossy,
                           rgb E);

#endif
