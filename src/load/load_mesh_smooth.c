// SPDX-License-Identifier: Apache-2.0
// max_smooth_angle: computes normals that are smooth only across edges below an angle, whatever
// normals the file has. Triangles get vertices of their own. The normal of a corner is the mean of
// those faces at its position whose normals are within the angle of that of its own face, weighted
// by the angles of the faces there.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/rng.h"
#include "load/load_mesh.h"

// The largest number of faces at one position that are compared for each corner: in a hostile file
// all corners may be at one position.
enum { FAN_MAX = 1024 };

// A corner of the mesh, for sorting by position.
struct smooth_corner {
    uint64_t key;     // hash of the bits of its position
    uint32_t number;  // 3 * triangle + 0, 1, 2
};

static vec3 corner_position(const struct raw_mesh *raw, uint32_t corner) {
    const float *p = raw->position + (size_t)raw->index[corner] * 3;
    return v3(p[0], p[1], p[2]);
}

static uint64_t position_key(vec3 p) {
    float c[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};  // -0 becomes 0
    uint32_t bits[3];
    memcpy(bits, c, sizeof bits);
    return rng_mix(rng_mix(bits[0] | (uint64_t)bits[1] << 32) + bits[2]);
}

static int by_position(const void *a, const void *b) {
    const struct smooth_corner *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

// The unit normal of a corner's triangle; zero if it has no area.
static vec3 face_normal(const struct raw_mesh *raw, uint32_t corner) {
    uint32_t first = corner - corner % 3;
    vec3 a = corner_position(raw, first), b = corner_position(raw, first + 1),
         c = corner_position(raw, first + 2);
    return v3_unit_wide(v3_cross(v3_sub(b, a), v3_sub(c, a)));
}

static float smooth_corner_angle(const struct raw_mesh *raw, uint32_t corner) {
    uint32_t first = corner - corner % 3, k = corner % 3;
    vec3 p = corner_position(raw, corner);
    vec3 a = v3_unit(v3_sub(corner_position(raw, first + (k + 1) % 3), p));
    vec3 b = v3_unit(v3_sub(corner_position(raw, first + (k + 2) % 3), p));
    return 2.0f * atan2f(v3_len(v3_sub(a, b)), v3_len(v3_add(a, b)));
}

// Computes the normals of the corners fan[0 .. count - 1], which are at one position.
static void smooth_fan(const struct raw_mesh *raw, const struct smooth_corner *fan, size_t count,
                       float cosine, float *normal) {
    size_t most = count < FAN_MAX ? count : FAN_MAX;
    for (size_t i = 0; i < count; i++) {
        vec3 own = face_normal(raw, fan[i].number), sum = v3(0, 0, 0);
        for (size_t j = 0; j < most; j++) {
            vec3 other = face_normal(raw, fan[j].number);
            if (j != i && v3_dot(own, other) < cosine) continue;
            sum = v3_mad(sum, smooth_corner_angle(raw, fan[j].number), other);
        }
        vec3 n = v3_unit(sum);
        if (v3_len2(n) < 0.5f) n = v3_len2(own) > 0.5f ? own : v3(1, 0, 0);
        memcpy(normal + (size_t)fan[i].number * 3, &n, sizeof n);
    }
}

static void smooth_corners(const struct raw_mesh *raw, struct smooth_corner *corner, size_t count,
                           float cosine, float *normal) {
    for (size_t i = 0; i < count; i++)
        corner[i] =
            (struct smooth_corner){position_key(corner_position(raw, (uint32_t)i)), (uint32_t)i};
    qsort(corner, count, sizeof *corner, by_position);
    for (size_t first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && corner[end].key == corner[first].key;) end++;
        smooth_fan(raw, corner + first, end - first, cosine, normal);
    }
}

// Copies the attributes to the corners, which are vertices now.
static satin_status attributes_of_corners(const struct load_source *source,
                                          const struct raw_mesh *raw, size_t corners,
                                          struct raw_mesh *out) {
    out->attribute = raw->attribute;
    out->attribute_count = raw->attribute_count;
    for (int i = 0; i < raw->attribute_count; i++) {
        struct mesh_attribute *a = &raw->attribute[i];
        size_t n = (size_t)a->channels;
        if (a->per_triangle) continue;
        float *value = arena_array(source->arena, corners * n, sizeof *value);
        if (!value) return load_mesh_no_memory(source);
        for (size_t k = 0; k < corners; k++)
            memcpy(value + k * n, a->value + raw->index[k] * n, n * sizeof *value);
        a->value = value;
    }
    return SATIN_OK;
}

satin_status load_mesh_smooth(const struct load_source *source, float degrees,
                              struct raw_mesh *raw) {
    size_t count = (size_t)raw->triangle_count * 3;
    if (count > UINT32_MAX)
        return load_mesh_error(source, 0, "it has too many triangles for max_smooth_angle");
    struct raw_mesh out;
    satin_status status = load_mesh_allocate(source, (uint32_t)count, true, raw->uv, &out);
    if (status != SATIN_OK) return status;
    struct smooth_corner *corner = array_new(count, sizeof *corner);
    out.index = arena_array(source->arena, count, sizeof *out.index);
    if (!corner || !out.index) {
        free(corner);
        return load_mesh_no_memory(source);
    }
    smooth_corners(raw, corner, count, cosf(degrees * (PI_F / 180.0f)), out.normal);
    free(corner);
    for (size_t i = 0; i < count; i++) {
        size_t from = raw->index[i];
        memcpy(out.position + i * 3, raw->position + from * 3, 3 * sizeof(float));
        if (out.uv) memcpy(out.uv + i * 2, raw->uv + from * 2, 2 * sizeof(float));
        out.index[i] = (uint32_t)i;
    }
    out.triangle_count = raw->triangle_count;
    status = attributes_of_corners(source, raw, count, &out);
    if (status == SATIN_OK) *raw = out;
    return status;
}
