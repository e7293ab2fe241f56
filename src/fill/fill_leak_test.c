// SPDX-License-Identifier: Apache-2.0
// The sectors of a new record in which light may leak: those with surfaces within its search
// radius.
#include "fill/fill_record.h"

// No ray is traced to points nearer than this fraction of the least distance of the record's hits,
// because the rays may have missed something nearer.
static const float CLEAR = 0.8f;

uint32_t fill_leak_sectors(const struct gather_surroundings *around, float radius, float *clear) {
    uint32_t near = 0;
    *clear = radius;
    for (int s = 0; s < CACHE_SECTORS; s++)
        if (around->sector[s] < radius) {
            near |= 1u << s;
            *clear = fminf(*clear, CLEAR * around->sector[s]);
        }
    return near;
}
