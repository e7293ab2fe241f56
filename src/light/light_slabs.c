// SPDX-License-Identifier: Apache-2.0
// Mesh lights of many triangles, from near: most light of a long one, as of a fluorescent tube, is
// from its nearest part. The mesh is cut into slabs along its longest side; a slab is chosen by an
// estimate of its light, and points are uniform in its area.
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "light/light_kinds.h"

enum {
    SLABS = 16,
    CORNERS = 5,             // the largest number of what is left of a triangle between two planes
    TRIANGLES_CUT = 1 << 16  // a bound of memory and time, as of light_facing.c
};

// A triangle that lies in one of those of the mesh.
struct piece {
    vec3 a, ab, ac;
    uint32_t triangle;
};

struct slab {
    vec3 centre;
    float spread2;  // mean squared distance from it
    float area;
    uint32_t first, count;  // pieces
};

struct light_slabs {
    int axis;
    float lo, step;  // of the first slab, and from one to the next
    struct slab slab[SLABS];
    const struct piece *piece;
    float area;        // of all
    const float *cdf;  // of the areas of each slab's pieces: count + 1 from first + its number on
};

// ---- Cutting ------------------------------------------------------------------------------------

struct polygon {
    vec3 corner[CORNERS + 1];
    int count;
};

// What is left of a polygon where sign * (x - at) is not negative, x along the axis.
static struct polygon cut_polygon(const struct polygon *from, int axis, float at, float sign) {
    struct polygon out = {.count = 0};
    for (int i = 0; i < from->count; i++) {
        const vec3 a = from->corner[i], b = from->corner[(i + 1) % from->count];
        const float da = sign * (v3_along(a, axis) - at), db = sign * (v3_along(b, axis) - at);
        if (da >= 0.0f && out.count < CORNERS) out.corner[out.count++] = a;
        if ((da >= 0.0f) != (db >= 0.0f) && out.count < CORNERS)
            out.corner[out.count++] = v3_mad(a, da / (da - db), v3_sub(b, a));
    }
    return out;
}

static float piece_area(const struct piece *p) {
    return 0.5f * v3_len_wide(v3_cross(p->ab, p->ac));
}

struct pieces {
    struct piece *piece;
    float *area;
    size_t count, capacity[2];
};

// Adds what is left of a triangle between two planes. False if there is no memory.
static bool add_pieces(struct pieces *out, const struct shape *shape, uint32_t triangle, int axis,
                       float lo, float hi) {
    const uint32_t *index = shape->mesh.index + 3 * (size_t)triangle;
    struct polygon between = {.count = 3};
    for (int k = 0; k < 3; k++) between.corner[k] = scene_mesh_vertex(&shape->mesh, index[k]);
    between = cut_polygon(&between, axis, lo, 1.0f);
    between = cut_polygon(&between, axis, hi, -1.0f);
    for (int k = 1; k + 1 < between.count; k++) {
        const vec3 a = between.corner[0];
        const struct piece piece = {a, v3_sub(between.corner[k], a),
                                    v3_sub(between.corner[k + 1], a), triangle};
        if (!array_reserve((void **)&out->piece, &out->capacity[0], out->count + 1,
                           sizeof *out->piece) ||
            !array_reserve((void **)&out->area, &out->capacity[1], out->count + 1,
                           sizeof *out->area))
            return false;
        out->area[out->count] = piece_area(&piece);
        out->piece[out->count++] = piece;
    }
    return true;
}

// Sets the area of a slab, its centre and spread, from its pieces. Weights are fractions of its
// area, as products of three lengths may leave the range of float.
static void measure_slab(const struct pieces *pieces, struct slab *slab) {
    const struct piece *piece = pieces->piece + slab->first;
    const float *area = pieces->area + slab->first;
    for (uint32_t i = 0; i < slab->count; i++) slab->area += area[i];
    if (!(slab->area > 0.0f)) return;
    for (uint32_t i = 0; i < slab->count; i++) {
        const vec3 middle = v3_mad(piece[i].a, 1.0f / 3.0f, v3_add(piece[i].ab, piece[i].ac));
        slab->centre = v3_mad(slab->centre, area[i] / slab->area, middle);
    }
    for (uint32_t i = 0; i < slab->count; i++) {
        const vec3 a = v3_sub(piece[i].a, slab->centre);
        const vec3 b = v3_add(a, piece[i].ab), c = v3_add(a, piece[i].ac);
        slab->spread2 +=
            area[i] / slab->area * (v3_len2(a) + v3_len2(b) + v3_len2(c)) * (1.0f / 3.0f);
    }
}

// Copies the pieces to the arena, and builds the distributions.
static satin_status keep_pieces(struct satin_scene *scene, const struct pieces *from,
                                struct light_slabs *slabs) {
    struct piece *piece = arena_array(&scene->arena, from->count, sizeof *piece);
    float *cdf = arena_array(&scene->arena, from->count + SLABS, sizeof *cdf);
    if (!piece || !cdf) return SATIN_ERROR_MEMORY;
    for (size_t i = 0; i < from->count; i++) piece[i] = from->piece[i];
    for (uint32_t s = 0; s < SLABS; s++) {
        const struct slab *slab = &slabs->slab[s];
        if (slab->area > 0.0f)
            sample_cdf_build(from->area + slab->first, slab->count, cdf + slab->first + s);
    }
    for (int s = 0; s < SLABS; s++) slabs->area += slabs->slab[s].area;
    slabs->piece = piece;
    slabs->cdf = cdf;
    return SATIN_OK;
}

// Cuts the mesh into the slabs. False if there is no memory.
static bool cut_mesh(const struct shape *shape, struct light_slabs *slabs, struct pieces *out) {
    for (int s = 0; s < SLABS; s++) {
        const float lo = slabs->lo + (float)s * slabs->step, hi = lo + slabs->step;
        struct slab *slab = &slabs->slab[s];
        slab->first = (uint32_t)out->count;
        for (uint32_t i = 0; i < shape->mesh.triangle_count; i++)
            if (!add_pieces(out, shape, i, slabs->axis, s ? lo : -INFINITY,
                            s + 1 < SLABS ? hi : INFINITY))
                return false;
        slab->count = (uint32_t)out->count - slab->first;
        measure_slab(out, slab);
    }
    return true;
}

satin_status light_slabs_build(struct satin_scene *scene, struct light *light) {
    const struct shape *shape = &scene->shape[light->shape];
    const size_t n = shape->mesh.triangle_count;
    if (n == 0 || n * scene->light_count > TRIANGLES_CUT) return SATIN_OK;
    struct light_slabs *slabs = arena_alloc(&scene->arena, sizeof *slabs);
    if (!slabs) return SATIN_ERROR_MEMORY;
    vec3 lo, hi;
    scene_shape_bounds(shape, &lo, &hi);
    const vec3 size = v3_sub(hi, lo);
    slabs->axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    slabs->lo = v3_along(lo, slabs->axis);
    slabs->step = v3_along(size, slabs->axis) / SLABS;
    if (!(slabs->step > 0.0f)) return SATIN_OK;
    struct pieces pieces = {0};
    satin_status status = SATIN_ERROR_MEMORY;
    if (cut_mesh(shape, slabs, &pieces)) status = keep_pieces(scene, &pieces, slabs);
    free(pieces.piece);
    free(pieces.area);
    if (status == SATIN_OK && slabs->area > 0.0f) light->slabs = slabs;
    return status;
}

// ---- Sampling -----------------------------------------------------------------------------------

// An estimate of the light of a slab, over its radiance.
static float slab_estimate(const struct slab *slab, vec3 p) {
    return slab->area > 0.0f ? slab->area / (v3_dist2(p, slab->centre) + slab->spread2) : 0.0f;
}

// The estimates of all slabs, or their areas if one is not finite. Returns their sum.
static float estimate_slabs(const struct light_slabs *slabs, vec3 p, float weight[SLABS]) {
    float sum = 0.0f;
    for (int s = 0; s < SLABS; s++) sum += weight[s] = slab_estimate(&slabs->slab[s], p);
    if (sum > 0.0f && isfinite(sum)) return sum;
    for (int s = 0; s < SLABS; s++) weight[s] = slabs->slab[s].area;
    return slabs->area;
}

float light_slabs_estimate(const struct light_slabs *slabs, vec3 p) {
    float weight[SLABS];
    return estimate_slabs(slabs, p, weight);
}

struct light_slab_point light_slabs_sample(const struct light_slabs *slabs, vec3 p, float u,
                                           float v) {
    float weight[SLABS];
    const float sum = estimate_slabs(slabs, p, weight);
    int s = 0, last = 0;
    for (float x = u * sum; s < SLABS; s++) {
        if (!(weight[s] > 0.0f)) continue;
        last = s;
        if (x < weight[s]) {
            u = x / weight[s];
            break;
        }
        x -= weight[s];
    }
    const struct slab *slab = &slabs->slab[last];
    const float *cdf = slabs->cdf + slab->first + last;
    const size_t i = sample_cdf(cdf, slab->count, clampf(u, 0.0f, SAMPLE_BELOW_ONE), &u);
    const struct piece *piece = &slabs->piece[slab->first + i];
    const vec2 b = sample_triangle(u, v);
    return (struct light_slab_point){v3_mad(v3_mad(piece->a, b.x, piece->ab), b.y, piece->ac),
                                     piece->triangle, weight[last] / (sum * slab->area)};
}

float light_slabs_pdf(const struct light_slabs *slabs, vec3 p, vec3 q) {
    float weight[SLABS];
    const float sum = estimate_slabs(slabs, p, weight);
    const float at = (v3_along(q, slabs->axis) - slabs->lo) / slabs->step;
    const int s = (int)clampf(at, 0.0f, (float)(SLABS - 1));
    return weight[s] > 0.0f ? weight[s] / (sum * slabs->slab[s].area) : 0.0f;
}
