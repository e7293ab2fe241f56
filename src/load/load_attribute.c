// SPDX-License-Identifier: Apache-2.0
// Finds the mesh attributes that the textures of a shape refer to.
#include "load/load_attribute.h"

bool load_attribute_want(struct attribute_names *names, const struct texture *texture) {
    if (!texture) return true;
    if (texture->check[0])
        return load_attribute_want(names, texture->check[0]) &&
               load_attribute_want(names, texture->check[1]);
    if (texture->kind != TEXTURE_ATTRIBUTE) return true;
    for (int i = 0; i < names->count; i++)
        if (names->name[i] == texture->attribute) return true;
    if (names->count == ATTRIBUTES_MAX) return false;
    names->name[names->count++] = texture->attribute;
    return true;
}

static bool want_side(struct attribute_names *names, const struct material_side *side) {
    if (side->component[0])
        return load_attribute_want(names, side->blend) && want_side(names, side->component[0]) &&
               want_side(names, side->component[1]);
    for (int i = 0; i < BRDF_SLOT_COUNT; i++)
        if (!load_attribute_want(names, side->slot[i])) return false;
    for (int i = 0; i < BRDF_BUMPS_MAX; i++)
        if (!load_attribute_want(names, side->bump[i].normal)) return false;
    return true;
}

bool load_attribute_want_all(struct attribute_names *names, const struct material *m) {
    return want_side(names, &m->front) && want_side(names, &m->back);
}

const char *load_attribute_missing(const struct attribute_names *names, const struct mesh *mesh) {
    for (int i = 0, k; i < names->count; i++) {
        for (k = 0; k < mesh->attribute_count; k++)
            if (mesh->attribute[k].name == names->name[i]) break;
        if (k == mesh->attribute_count) return names->name[i];
    }
    return NULL;
}
