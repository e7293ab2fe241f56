// SPDX-License-Identifier: Apache-2.0
// Mesh lights of many triangles: from any point at most half of a closed one is visible, such as of
// the filament of a bulb. For each of some directions from the light, the triangles have a
// distribution by how much of their area faces it.
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "light/light_kinds.h"

enum {
    SIDE = 2,  // each side of a cube of directions has 2 x 2 sectors
    SECTORS = 6 * SIDE * SIDE,
    DIRECTIONS = 4,  // along each edge of a sector: directions for which the facing is averaged
    // A bound of memory, 6 MB, and of .1 s: the largest number of triangles times that of lights.
    TRIANGLES_MOST = 1 << 16
};
// Points that are nearer than so many radii of the light see its parts in too different directions.
static const float FAR = 3.0f;
// This much of the area counts even if it faces away, for points that are not quite far.
static const float FACING_LEAST = 0.05f;

// The sector of the cube of directions that w is in.
static int cube_sector(vec3 w) {
    const float x = fabsf(w.x), y = fabsf(w.y), z = fabsf(w.z);
    const int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    const int sign = v3_along(w, axis) < 0.0f;
    const int s = v3_along(w, (axis + 1) % 3) < 0.0f, t = v3_along(w, (axis + 2) % 3) < 0.0f;
    return ((axis * 2 + sign) * SIDE + s) * SIDE + t;
}

// A direction of a sector, at s and t in (0, 1).
static vec3 sector_direction(int sector, float s, float t) {
    const int axis = sector / (2 * SIDE * SIDE);
    const float side = sector / (SIDE * SIDE) % 2 ? -1.0f : 1.0f;
    float w[3];
    w[axis] = side;
    w[(axis + 1) % 3] = sector / SIDE % 2 ? -s : s;
    w[(axis + 2) % 3] = sector % 2 ? -t : t;
    return v3_unit(v3(w[0], w[1], w[2]));
}

// The directions of all sectors.
struct facing_directions {
    vec3 w[SECTORS][DIRECTIONS * DIRECTIONS];
};

static void make_directions(struct facing_directions *out) {
    for (int sector = 0; sector < SECTORS; sector++)
        for (int i = 0; i < DIRECTIONS * DIRECTIONS; i++)
            out->w[sector][i] =
                sector_direction(sector, ((float)(i % DIRECTIONS) + 0.5f) / DIRECTIONS,
                                 ((float)(i / DIRECTIONS) + 0.5f) / DIRECTIONS);
}

// The mean of what a triangle of a normal shows to the directions of a sector.
static float facing(const struct facing_directions *all, vec3 n, int sector) {
    float sum = 0.0f;
    for (int i = 0; i < DIRECTIONS * DIRECTIONS; i++)
        sum += maxf(v3_dot(n, all->w[sector][i]), 0.0f);
    return sum / (DIRECTIONS * DIRECTIONS);
}

satin_status light_facing_build(struct satin_scene *scene, struct light *light) {
    const struct shape *shape = &scene->shape[light->shape];
    const size_t n = shape->mesh.triangle_count;
    if (n * scene->light_count > TRIANGLES_MOST) return SATIN_OK;
    float *weight = array_new_unset(SECTORS * n, sizeof *weight);
    float *cdf = arena_array(&scene->arena, SECTORS * (n + 1), sizeof *cdf);
    struct facing_directions all;
    make_directions(&all);
    for (size_t i = 0; i < n && weight && cdf; i++) {
        const vec3 n2 = light_triangle_normal(shape, (uint32_t)i);
        const float area2 = v3_len_wide(n2);
        const vec3 normal = v3_mul(n2, area2 > 0.0f ? 1.0f / area2 : 0.0f);
        for (int sector = 0; sector < SECTORS; sector++)
            weight[(size_t)sector * n + i] = area2 * (facing(&all, normal, sector) + FACING_LEAST);
    }
    for (size_t sector = 0; sector < SECTORS && weight && cdf; sector++)
        sample_cdf_build(weight + sector * n, n, cdf + sector * (n + 1));
    light->facing_cdf = weight ? cdf : NULL;
    free(weight);
    return light->facing_cdf ? SATIN_OK : SATIN_ERROR_MEMORY;
}

bool light_mesh_is_far(const struct light *light, vec3 p) {
    return !(v3_dist2(p, light->centre) < sqrf(FAR * light->radius));
}

const float *light_facing_cdf(const struct light *light, const struct shape *shape, vec3 p) {
    if (!light->facing_cdf || !light_mesh_is_far(light, p)) return shape->area_cdf;
    const int sector = cube_sector(v3_sub(p, light->centre));
    return light->facing_cdf + (size_t)sector * (shape->mesh.triangle_count + 1);
}
