// SPDX-License-Identifier: Apache-2.0
// Finds shapes that coincide with an earlier one, by sorting hashes of their geometry.
#include "scene/scene_coincide.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/fileio.h"
#include "scene/scene_opacity.h"

enum { ARRAYS_MAX = 4 };

// The data that determines the position of a surface: a few arrays of bytes.
struct geometry {
    int count;
    struct {
        const void *data;
        size_t size;
    } array[ARRAYS_MAX];
};

static void add_geometry_bytes(struct geometry *g, const void *data, size_t size) {
    g->array[g->count].data = data;
    g->array[g->count++].size = size;
}

static struct geometry geometry_of(const struct shape *shape) {
    struct geometry g = {0};
    const struct mesh *mesh = &shape->mesh;
    const struct curves *curves = &shape->curves;
    add_geometry_bytes(&g, &shape->kind, sizeof shape->kind);
    switch (shape->kind) {
        case SHAPE_MESH:
            add_geometry_bytes(&g, mesh->position, 3 * sizeof(float) * mesh->vertex_count);
            add_geometry_bytes(&g, mesh->index, 3 * sizeof(uint32_t) * mesh->triangle_count);
            break;
        case SHAPE_CURVES:
            add_geometry_bytes(&g, curves->point, 4 * sizeof(float) * curves->points);
            add_geometry_bytes(&g, curves->first, sizeof(uint32_t) * curves->segments);
            add_geometry_bytes(&g, &curves->linear, sizeof curves->linear);
            break;
        case SHAPE_SPHERE:
            add_geometry_bytes(&g, &shape->centre, sizeof shape->centre);
            add_geometry_bytes(&g, &shape->radius, sizeof shape->radius);
            break;
        case SHAPE_INSTANCE:
            add_geometry_bytes(&g, &shape->instance_of, sizeof shape->instance_of);
            add_geometry_bytes(&g, &shape->to_world, sizeof shape->to_world);
            break;
        default:
            add_geometry_bytes(&g, &shape->to_world, sizeof shape->to_world);
            break;
    }
    return g;
}

static uint64_t hash_of(const struct geometry *g) {
    uint64_t hash = FILEIO_HASH;
    for (int i = 0; i < g->count; i++) {
        const uint64_t size = g->array[i].size;
        hash = fileio_hash(hash, &size, sizeof size);
        hash = fileio_hash_large(hash, g->array[i].data, g->array[i].size);
    }
    return hash;
}

static bool equal(const struct geometry *a, const struct geometry *b) {
    if (a->count != b->count) return false;
    for (int i = 0; i < a->count; i++) {
        const size_t size = a->array[i].size;
        if (size != b->array[i].size) return false;
        if (size && memcmp(a->array[i].data, b->array[i].data, size) != 0) return false;
    }
    return true;
}

struct keyed_shape {
    uint64_t hash;
    bool dark;  // it emits no light
    uint32_t shape;
};

static int by_hash(const void *a, const void *b) {
    const struct keyed_shape *x = a, *y = b;
    if (x->hash != y->hash) return x->hash < y->hash ? -1 : 1;
    if (x->dark != y->dark) return x->dark ? 1 : -1;  // of coincident shapes, the light is kept
    return x->shape < y->shape ? -1 : x->shape > y->shape;
}

bool scene_coincide_find(const struct satin_scene *scene, uint32_t first, uint32_t count,
                         uint32_t group, bool *hidden, uint32_t *found) {
    *found = 0;
    memset(hidden, 0, count * sizeof *hidden);
    if (count < 2) return true;
    struct keyed_shape *key = array_new(count, sizeof *key);
    if (!key) return false;
    size_t n = 0;
    for (uint32_t i = first; i < first + count; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->group != group) continue;
        if (shape->kind != SHAPE_INSTANCE && scene_opacity_of(scene, shape)) continue;
        const struct geometry g = geometry_of(shape);
        key[n++] = (struct keyed_shape){hash_of(&g), shape->light < 0, i};
    }
    qsort(key, n, sizeof *key, by_hash);
    // Each shape is compared only with the first one of its hash. If two different geometries ever
    // had the same hash, both would be kept.
    for (size_t i = 1, head = 0; i < n; i++) {
        if (key[i].hash != key[head].hash) {
            head = i;
            continue;
        }
        const struct geometry a = geometry_of(&scene->shape[key[head].shape]);
        const struct geometry b = geometry_of(&scene->shape[key[i].shape]);
        if (!equal(&a, &b)) continue;
        hidden[key[i].shape - first] = true;
        ++*found;
    }
    free(key);
    return true;
}
