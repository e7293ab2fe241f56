// SPDX-License-Identifier: Apache-2.0
// Processing of every mesh after its file is parsed: checks, the transform to world space, vertex
// normals and the winding of triangles. Conventions are Mitsuba 3's.
#include "load/load_mesh.h"

#include <stdlib.h>

satin_status load_mesh_error(const struct load_source *source, int line, const char *format, ...) {
    va_list args;
    va_start(args, format);
    log_error_at_args(source->log, (struct log_place){source->path, line, 0}, NULL, format, args);
    va_end(args);
    return SATIN_ERROR_INPUT;
}

satin_status load_mesh_no_memory(const struct load_source *source) {
    return log_fail(source->log, SATIN_ERROR_MEMORY, "%s: not enough memory for its mesh",
                    source->path);
}

satin_status load_mesh_allocate(const struct load_source *source, uint32_t vertices, bool normals,
                                bool uvs, struct raw_mesh *out) {
    struct arena *arena = source->arena;
    struct raw_mesh raw = {.vertex_count = vertices};
    raw.position = arena_array(arena, (size_t)vertices * 3 + 1, sizeof(float));
    if (normals) raw.normal = arena_array(arena, (size_t)vertices * 3, sizeof(float));
    if (uvs) raw.uv = arena_array(arena, (size_t)vertices * 2, sizeof(float));
    if (!raw.position || (normals && !raw.normal) || (uvs && !raw.uv))
        return load_mesh_no_memory(source);
    *out = raw;
    return SATIN_OK;
}

// ---- Normals ------------------------------------------------------------------------------------

static vec3 vertex_at(const float *values, uint32_t i) {
    const float *v = values + (size_t)i * 3;
    return v3(v[0], v[1], v[2]);
}

static void set_vertex(float *values, uint32_t i, vec3 v) {
    values[(size_t)i * 3] = v.x;
    values[(size_t)i * 3 + 1] = v.y;
    values[(size_t)i * 3 + 2] = v.z;
}

// Sums the face normals around each vertex that has `wanted` set (NULL: all), weighted by the angle
// of the face there [Thuermer and Wuethrich 1998], and normalises the sum to `normal`.
static void smooth_normals(const struct raw_mesh *raw, const bool *wanted, float *normal) {
    for (uint32_t t = 0; t < raw->triangle_count; t++) {
        const uint32_t *index = raw->index + (size_t)t * 3;
        vec3 p[3];
        for (int k = 0; k < 3; k++) p[k] = vertex_at(raw->position, index[k]);
        vec3 n = v3_unit_wide(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])));
        if (v3_len2(n) == 0.0f) continue;
        for (int k = 0; k < 3; k++) {
            if (wanted && !wanted[index[k]]) continue;
            vec3 a = v3_unit(v3_sub(p[(k + 1) % 3], p[k]));
            vec3 b = v3_unit(v3_sub(p[(k + 2) % 3], p[k]));
            vec3 sum = vertex_at(normal, index[k]);
            set_vertex(normal, index[k], v3_mad(sum, v3_angle(a, b), n));
        }
    }
    for (uint32_t i = 0; i < raw->vertex_count; i++) {
        if (wanted && !wanted[i]) continue;
        vec3 n = v3_unit(vertex_at(normal, i));
        // No ray hits a vertex that only degenerate faces use, so its normal is arbitrary.
        set_vertex(normal, i, v3_len2(n) > 0.5f ? n : v3(1, 0, 0));
    }
}

// Transforms the file's normals by the transposed inverse, computed as the matrix of cofactors,
// which also exists for singular transforms.
static void transform_normals(const struct mat4 *m, struct raw_mesh *raw) {
    double c[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            c[i][j] = (double)m->m[i1][j1] * m->m[i2][j2] - (double)m->m[i1][j2] * m->m[i2][j1];
        }
    double sign = mat4_det3(m) < 0.0 ? -1.0 : 1.0;
    for (uint32_t i = 0; i < raw->vertex_count; i++) {
        const float *n = raw->normal + (size_t)i * 3;
        double w[3], l2 = 0.0;
        for (int r = 0; r < 3; r++) {
            w[r] = sign * (c[r][0] * n[0] + c[r][1] * n[1] + c[r][2] * n[2]);
            l2 += w[r] * w[r];
        }
        double s = l2 > 0.0 ? 1.0 / sqrt(l2) : 0.0;
        set_vertex(raw->normal, i, v3((float)(s * w[0]), (float)(s * w[1]), (float)(s * w[2])));
    }
}

// Computes the normals of vertices that have none in the file, where they are zero.
static satin_status complete_normals(const struct load_source *source, struct raw_mesh *raw) {
    bool *wanted = NULL;
    for (uint32_t i = 0; i < raw->vertex_count; i++) {
        if (v3_len2(vertex_at(raw->normal, i)) > 0.0f) continue;
        if (!wanted) wanted = calloc(raw->vertex_count, sizeof *wanted);
        if (!wanted) return load_mesh_no_memory(source);
        wanted[i] = true;
    }
    if (wanted) smooth_normals(raw, wanted, raw->normal);
    free(wanted);
    return SATIN_OK;
}

// Orders the vertices of every triangle so that its front side is that of its vertex normals,
// because Mitsuba shades by these alone. This matters for mirroring transforms and for inconsistent
// files.
static void orient_triangles(struct raw_mesh *raw) {
    for (uint32_t t = 0; t < raw->triangle_count; t++) {
        uint32_t *index = raw->index + (size_t)t * 3;
        vec3 a = vertex_at(raw->position, index[0]), b = vertex_at(raw->position, index[1]),
             c = vertex_at(raw->position, index[2]);
        vec3 n = v3_add(vertex_at(raw->normal, index[0]),
                        v3_add(vertex_at(raw->normal, index[1]), vertex_at(raw->normal, index[2])));
        if (v3_dot(v3_cross(v3_sub(b, a), v3_sub(c, a)), n) >= 0.0f) continue;
        uint32_t swap = index[1];
        index[1] = index[2];
        index[2] = swap;
    }
}

static satin_status make_normals(const struct load_source *source,
                                 const struct mesh_request *request, struct raw_mesh *raw) {
    if (request->face_normals) {
        raw->normal = NULL;
        return SATIN_OK;
    }
    if (request->smooth_angle > 0.0f) {
        satin_status status = load_mesh_smooth(source, request->smooth_angle, raw);
        if (status != SATIN_OK) return status;
    } else if (raw->normal) {
        transform_normals(&request->to_world, raw);
        satin_status status = complete_normals(source, raw);
        if (status != SATIN_OK) return status;
        orient_triangles(raw);
    } else {
        size_t count = (size_t)raw->vertex_count * 3;
        raw->normal = arena_array(source->arena, count, sizeof(float));
        if (!raw->normal) return load_mesh_no_memory(source);
        smooth_normals(raw, NULL, raw->normal);
    }
    if (request->flip_normals)
        for (size_t i = 0; i < (size_t)raw->vertex_count * 3; i++) raw->normal[i] = -raw->normal[i];
    return SATIN_OK;
}

// ---- Attributes ---------------------------------------------------------------------------------

void load_mesh_attribute_check(const struct load_source *source, const char *name, float *value,
                               size_t count) {
    size_t bad = 0;
    for (size_t i = 0; i < count; i++) {
        if (value[i] >= 0.0f) continue;
        value[i] = 0.0f;
        bad++;
    }
    if (bad)
        log_message(source->log, SATIN_LOG_WARNING,
                    "%s: %zu values of %s are negative and count as 0", source->path, bad, name);
}

// ---- Finishing ----------------------------------------------------------------------------------

// Collapses triangles without area to points. Rounding could make the ray tracer hit such a
// triangle, which has no normal; a point is never hit.
static void collapse_flat(struct raw_mesh *raw) {
    for (size_t t = 0; t < raw->triangle_count; t++) {
        uint32_t *index = raw->index + 3 * t;
        const float *p = raw->position + 3 * (size_t)index[0];
        double e[2][3];
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 3; i++)
                e[k][i] = (double)raw->position[3 * (size_t)index[k + 1] + i] - p[i];
        if (e[0][0] * e[1][1] == e[0][1] * e[1][0] && e[0][1] * e[1][2] == e[0][2] * e[1][1] &&
            e[0][2] * e[1][0] == e[0][0] * e[1][2])
            index[1] = index[2] = index[0];
    }
}

satin_status load_mesh_finish(const struct load_source *source, const struct mesh_request *request,
                              struct raw_mesh *raw, struct mesh *out) {
    for (size_t i = 0; i < (size_t)raw->triangle_count * 3; i++)
        if (raw->index[i] >= raw->vertex_count)
            return load_mesh_error(source, 0, "triangle %zu refers to vertex %u, but there are %u",
                                   i / 3, raw->index[i], raw->vertex_count);
    for (uint32_t i = 0; i < raw->vertex_count; i++) {
        vec3 p = mat4_point(&request->to_world, vertex_at(raw->position, i));
        if (!(v3_finite(p) && v3_max_abs(p) <= SCENE_COORDINATE_MAX))
            return load_mesh_error(source, 0, "vertex %u is not finite or too far away", i);
        set_vertex(raw->position, i, p);
    }
    collapse_flat(raw);
    if (request->flip_tex_coords && raw->uv)
        for (uint32_t i = 0; i < raw->vertex_count; i++)
            raw->uv[(size_t)i * 2 + 1] = 1.0f - raw->uv[(size_t)i * 2 + 1];
    satin_status status = make_normals(source, request, raw);
    if (status != SATIN_OK) return status;
    *out = (struct mesh){.vertex_count = raw->vertex_count,
                         .triangle_count = raw->triangle_count,
                         .position = raw->position,
                         .normal = raw->normal,
                         .uv = raw->uv,
                         .index = raw->index,
                         .attribute = raw->attribute,
                         .attribute_count = raw->attribute_count};
    return SATIN_OK;
}
