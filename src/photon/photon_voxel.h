// SPDX-License-Identifier: Apache-2.0
// Private to photon/: lookups of the entry of irradiance near a point, by voxels (photon_voxel.c).
#ifndef PHOTON_VOXEL_H
#define PHOTON_VOXEL_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"

struct photon_irradiance;

enum {
    PHOTON_VOXEL_SCALES = 32,
    PHOTON_VOXEL_NONE = 255,  // scale of regions without voxels
    PHOTON_VOXEL_BITS = 17,   // of a voxel's coordinate along an axis
    PHOTON_VOXEL_LOOKUPS = 512,
    PHOTON_VOXEL_NEAR = 14,  // entries near a voxel that are remembered: with a key a cache line
    PHOTON_VOXEL_TRIED = 4   // slots in which a voxel may be
};

// A voxel whose entries are known.
struct photon_voxel_slot {
    _Atomic uint64_t key;  // 0: the slot is free
    atomic_int number[];   // of the entries, from 2 on; 1: there is none; 0: it is being written
};

// A hash table of voxels.
struct photon_voxel_table {
    int numbers;  // of a slot
    size_t slots;
    unsigned shift;  // of a key's hash, to its slot
    unsigned char *memory;
};
static inline size_t photon_voxel_slot_bytes(int numbers) {
    return sizeof(uint64_t) * (1 + ((size_t)numbers + 1) / 2);
}

// The widths of voxels by region, and the voxels whose entries are known. All zero: there are no
// voxels.
struct photon_voxels {
    vec3 lo, hi;       // the box of the entries
    float per_length;  // regions per length
    int regions[3];    // number along each axis
    uint8_t *scale;    // by region: binary logarithm of the width of its voxels over `finest`, and
                       // 1; 0: all have none; PHOTON_VOXEL_NONE: its entries are too near
    vec3 corner;       // of the cube of all voxels, which holds the box
    float width;       // of that cube
    float finest;      // width of the finest voxels
    float per_width[PHOTON_VOXEL_SCALES];     // 1 / width, by scale
    struct photon_voxel_table nearest, near;  // one entry of a voxel, and several
};

// Makes the voxels of irradiance whose index is built; none if all entries are at one point. False
// if there is no memory.
bool photon_voxels_build(struct photon_irradiance *irradiance, struct parallel *pool);
void photon_voxels_free(struct photon_voxels *voxels);
size_t photon_voxels_bytes(const struct photon_voxels *voxels);
// The region that holds a point of the box.
static inline int photon_voxel_region(const struct photon_voxels *v, vec3 p) {
    const int x = (int)((p.x - v->lo.x) * v->per_length),
              y = (int)((p.y - v->lo.y) * v->per_length),
              z = (int)((p.z - v->lo.z) * v->per_length);
    return (z * v->regions[1] + y) * v->regions[0] + x;
}

// photon_voxel_find.c: finds the entries of the voxels that hold `count` points, at most
// PHOTON_VOXEL_LOOKUPS, with normals n: those nearest to the centres. Where there is no voxel, it
// is the entry nearest to the point; -1: there is none. Thread-safe.
void photon_voxel_find(const struct photon_irradiance *irradiance, const vec3 *p, const vec3 *n,
                       size_t count, int *entry);
// Finds several entries, in no particular order: those nearest to the centre of the voxel that
// holds p or, where there is none, to p. Missing ones are -1. Thread-safe.
void photon_voxel_find_near(const struct photon_irradiance *irradiance, vec3 p, vec3 n,
                            int entry[PHOTON_VOXEL_NEAR]);

#endif
