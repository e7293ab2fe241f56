// SPDX-License-Identifier: Apache-2.0
// Attributes of meshes: their values at a point of the surface, and their means.
#include "scene/scene_attribute.h"

#include "base/vec.h"

static rgb attribute_value(const struct mesh_attribute *a, uint32_t item) {
    const float *v = a->value + (size_t)item * (size_t)a->channels;
    return a->channels == 1 ? rgb_grey(v[0]) : rgb_make(v[0], v[1], v[2]);
}

rgb scene_attribute_eval(const char *name, const struct texture_lookup *at) {
    for (int i = 0; at->mesh && i < at->mesh->attribute_count; i++) {
        const struct mesh_attribute *a = &at->mesh->attribute[i];
        if (a->name != name) continue;
        if (a->per_triangle) return attribute_value(a, at->prim);
        const uint32_t *index = at->mesh->index + (size_t)at->prim * 3;
        rgb c = rgb_scale(attribute_value(a, index[0]), 1.0f - at->bary.x - at->bary.y);
        c = rgb_mad(c, attribute_value(a, index[1]), at->bary.x);
        return rgb_mad(c, attribute_value(a, index[2]), at->bary.y);
    }
    return rgb_grey(0.0f);
}

static vec3 corner_position_of(const struct mesh *mesh, uint32_t triangle, int k) {
    const float *p = mesh->position + (size_t)mesh->index[(size_t)triangle * 3 + (size_t)k] * 3;
    return v3(p[0], p[1], p[2]);
}

static rgb mesh_attribute_mean(const struct mesh *mesh, const char *name) {
    double sum[3] = {0.0, 0.0, 0.0}, area = 0.0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        vec3 a = corner_position_of(mesh, t, 0);
        float n = v3_len_wide(v3_cross(v3_sub(corner_position_of(mesh, t, 1), a),
                                       v3_sub(corner_position_of(mesh, t, 2), a)));
        struct texture_lookup middle = {
            .mesh = mesh, .prim = t, .bary = {1.0f / 3.0f, 1.0f / 3.0f}};
        rgb c = scene_attribute_eval(name, &middle);
        sum[0] += (double)(n * c.r), sum[1] += (double)(n * c.g), sum[2] += (double)(n * c.b);
        area += (double)n;
    }
    double scale = area > 0.0 ? 1.0 / area : 0.0;
    return rgb_make((float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale));
}

rgb scene_attribute_mean(const struct mesh *mesh, const struct texture *texture) {
    if (texture->kind == TEXTURE_SCALED)
        return rgb_mul(scene_attribute_mean(mesh, texture->check[0]), texture->value);
    if (texture->kind == TEXTURE_GRID) {
        const rgb between = scene_attribute_mean(mesh, texture->check[0]);
        const rgb line = scene_attribute_mean(mesh, texture->check[1]);
        return rgb_mad(rgb_scale(between, 1.0f - scene_texture_lines(texture)), line,
                       scene_texture_lines(texture));
    }
    if (texture->kind == TEXTURE_CHECKERBOARD)
        return rgb_scale(rgb_add(scene_attribute_mean(mesh, texture->check[0]),
                                 scene_attribute_mean(mesh, texture->check[1])),
                         0.5f);
    if (texture->kind != TEXTURE_ATTRIBUTE) return texture->mean;
    return rgb_scale(mesh_attribute_mean(mesh, texture->attribute), texture->scale);
}

bool scene_attribute_used(const struct texture *texture) {
    if (!texture) return false;
    return texture->kind == TEXTURE_ATTRIBUTE || scene_attribute_used(texture->check[0]) ||
           scene_attribute_used(texture->check[1]);
}
