// SPDX-License-Identifier: Apache-2.0
// BRDF tables for the scene's glossy materials [K05 figure 3.5, preprocessing].
#include <stdlib.h>
#include <string.h>

#include "shade/shade.h"

// Whether textures change more of the glossy part than its factor.
static bool shape_textured(const struct material_side *side) {
    for (int i = BRDF_SLOT_ETA; i < BRDF_SLOT_COUNT; i++)
        if (side->slot[i]) return true;
    return false;
}

static satin_status build_side(const struct material_side *side, const satin_options *o,
                               struct parallel *pool, struct brdf_table **out) {
    if (!side->base.model || !(brdf_lobes(&side->base) & BRDF_GLOSSY) || shape_textured(side))
        return SATIN_OK;
    satin_status status = brdf_table_build(&side->base, o->radiance_basis, o->radiance_order,
                                           o->radiance_error, pool, out);
    if (status == SATIN_OK && brdf_table_info(*out).order == 0) {
        brdf_table_free(*out);
        *out = NULL;
    }
    return status;
}

// Whether two BRDFs have the same glossy part but for its factor.
static bool alike(const struct brdf *a, const struct brdf *b) {
    return a->model == b->model && a->alpha_u == b->alpha_u && a->alpha_v == b->alpha_v &&
           a->exponent == b->exponent && a->ior == b->ior && a->distribution == b->distribution &&
           a->variant == b->variant && memcmp(&a->eta, &b->eta, sizeof a->eta) == 0 &&
           memcmp(&a->k, &b->k, sizeof a->k) == 0;
}

static const struct material_side *side_of(const struct satin_scene *scene, size_t i) {
    const struct material *m = &scene->material[i / 2];
    return i % 2 ? &m->back : &m->front;
}

// Takes the table of an equal side before side i; false if there is none.
static bool share_table(const struct satin_scene *scene, struct shade_tables *t, size_t i) {
    const struct material_side *side = side_of(scene, i);
    if (!side->base.model || shape_textured(side)) return false;
    for (size_t j = 0; j < i; j++) {
        const struct material_side *other = side_of(scene, j);
        if (!t->owned[j] || shape_textured(other) || !alike(&side->base, &other->base)) continue;
        t->table[i] = t->table[j];
        t->channels[i] = t->channels[j];
        return true;
    }
    return false;
}

// One flag per material: whether a shape has it.
static bool *used_materials(const struct satin_scene *scene) {
    bool *used = calloc((size_t)scene->material_count + 1, sizeof *used);
    for (uint32_t i = 0; used && i < scene->shape_count; i++) used[scene->shape[i].material] = true;
    return used;
}

satin_status shade_tables_build(const struct satin_scene *scene, const satin_options *options,
                                struct parallel *pool, struct log log, struct shade_tables *out) {
    struct shade_tables t = {.count = 2 * (size_t)scene->material_count};
    if (!options->radiance_cache) t.count = 0;
    bool *used = used_materials(scene);
    t.table = calloc(t.count + 1, sizeof *t.table);
    t.owned = calloc(t.count + 1, sizeof *t.owned);
    t.channels = calloc(t.count + 1, sizeof *t.channels);
    if (options->radiance_cache && options->radiance_diffuse) t.order = options->radiance_order;
    satin_status status = SATIN_OK;
    if (!used || !t.table || !t.owned || !t.channels)
        status = log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for BRDF tables");
    for (size_t i = 0; i < t.count && status == SATIN_OK; i++) {
        const struct material *m = &scene->material[i / 2];
        if (!used[i / 2] || (i % 2 && !m->two_sided) || share_table(scene, &t, i)) continue;
        status = build_side(side_of(scene, i), options, pool, &t.table[i]);
        t.owned[i] = true;
        if (status != SATIN_OK && status != SATIN_CANCELLED)
            log_fail(log, status, "cannot represent BRDF '%s' in harmonics", m->name);
        if (!t.table[i]) continue;
        struct brdf_table_info info = brdf_table_info(t.table[i]);
        t.channels[i] = info.channels;
        if (info.order > t.order) t.order = info.order;
    }
    free(used);
    if (status != SATIN_OK)
        shade_tables_free(&t);
    else
        *out = t;
    return status;
}

void shade_tables_free(struct shade_tables *tables) {
    for (size_t i = 0; tables->table && tables->owned && i < tables->count; i++)
        if (tables->owned[i]) brdf_table_free(tables->table[i]);
    free(tables->table);
    free(tables->owned);
    free(tables->channels);
    *tables = (struct shade_tables){0};
}
