// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the light that a lobe reflects of one record.
#ifndef CACHE_VALUE_H
#define CACHE_VALUE_H

#include "cache/cache.h"

// Transforms a lobe from frame `from` to frame `to`, for products with a record in that frame
// (cache_rotate.c). lobe->C then points to `rotated`, of 3 * order^2.
void cache_rotate(const struct cache *cache, const struct frame *from, const struct frame *to,
                  struct cache_lobe *lobe, float *rotated);

// The correction of the radiance that a lobe reflects of the record's harmonics; may be negative
// (cache_residual.c).
rgb cache_residual_read(const struct cache_residual *residual, const struct cache_lobe *lobe);

#endif
