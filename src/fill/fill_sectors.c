// SPDX-License-Identifier: Apache-2.0
// How far a new record serves points in each sector: up to most of the distance of the nearest
// surface, if that is within its search radius.
#include "fill/fill_record.h"

// A record serves points up to this fraction of the least distance of the hits in a sector, and no
// ray is traced to points nearer than this fraction of that in all, because its rays may have
// missed something nearer. The error of a furnished room at 2 seconds is the same with .5 to 1.
static const float NEARER = 0.8f;

float fill_find_sectors(const struct gather_surroundings *around, float radius, float least,
                        uint8_t sector[CACHE_SECTORS]) {
    float clear = radius;
    for (int s = 0; s < CACHE_SECTORS; s++) {
        sector[s] = UINT8_MAX;
        if (!(around->sector[s] < radius)) continue;
        const float distance = NEARER * around->sector[s];
        sector[s] = (uint8_t)fminf(fmaxf(distance, least) / radius * UINT8_MAX, UINT8_MAX - 1);
        clear = fminf(clear, distance);
    }
    return clear;
}
