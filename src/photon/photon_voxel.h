// SPDX-License-Identifier: Apache-2.0
// Private to photon/: lookups of the entry of irradiance near a point, by voxels (photon_voxel.c).
#ifndef PHOTON_VOXEL_H
#define PHOTON_VOXEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"

struct photon_irradiance;

enum { PHOTON_VOXEL_SCALES = 32 };

// The widths of voxels by region, and the voxels whose entries are known. All zero: there are no
// voxels.
struct photon_voxels {
    vec3 lo;           // corner of the regions' box
    float per_length;  // regions per length
    int regions[3];    // number along each axis
    uint8_t *scale;    // by region: binary logarithm of the width of its voxels over `finest`, and
                       // 1; 0: it has no voxels
    float finest;      // width of the finest voxels
    float per_width[PHOTON_VOXEL_SCALES];  // 1 / width, by scale
    size_t slots;                          // number of `slot`
    unsigned shift;                        // of a key's hash, to its slot
    struct photon_voxel_slot *slot;        // hash table of the voxels
};

// Makes the voxels of irradiance whose index is built; none if all entries are at one point. False
// if there is no memory.
bool photon_voxels_build(struct photon_irradiance *irradiance, struct parallel *pool);
void photon_voxels_free(struct photon_voxels *voxels);
size_t photon_voxels_bytes(const struct photon_voxels *voxels);
// Finds the entries of the voxels that hold `count` points, at most PHOTON_VOXEL_LOOKUPS, with
// normals n: those nearest to the centres. Where there is no voxel, it is the entry nearest to the
// point; -1: there is none. Thread-safe.
enum { PHOTON_VOXEL_LOOKUPS = 512 };
void photon_voxel_find(const struct photon_irradiance *irradiance, const vec3 *p, const vec3 *n,
                       size_t count, int *entry);

#endif
