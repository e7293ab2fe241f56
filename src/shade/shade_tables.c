// SPDX-License-Identifier: Apache-2.0
// BRDF tables for the scene's glossy materials [K05 figure 3.5, preprocessing].
#include <stdlib.h>

#include "shade/shade.h"

static bool rough_textured(const struct material_side *side) {
    return side->slot[BRDF_SLOT_ALPHA_U] || side->slot[BRDF_SLOT_ALPHA_V] ||
           side->slot[BRDF_SLOT_EXPONENT];
}

static satin_status build_side(const struct material_side *side, const satin_options *o,
                               struct parallel *pool, struct brdf_table **out) {
    if (!side->base.model || !(brdf_lobes(&side->base) & BRDF_GLOSSY) || rough_textured(side))
        return SATIN_OK;
    satin_status status = brdf_table_build(&side->base, o->radiance_basis, o->radiance_order,
                                           o->radiance_error, pool, out);
    if (status == SATIN_OK && brdf_table_info(*out).order == 0) {
        brdf_table_free(*out);
        *out = NULL;
    }
    return status;
}

satin_status shade_tables_build(const struct satin_scene *scene, const satin_options *options,
                                struct parallel *pool, struct log log, struct shade_tables *out) {
    struct shade_tables t = {.count = 2 * (size_t)scene->material_count};
    if (!options->radiance_cache) t.count = 0;
    t.table = calloc(t.count + 1, sizeof *t.table);
    t.channels = calloc(t.count + 1, sizeof *t.channels);
    if (options->radiance_cache && options->radiance_diffuse) t.order = options->radiance_order;
    if (!t.table || !t.channels) {
        shade_tables_free(&t);
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for BRDF tables");
    }
    for (size_t i = 0; i < t.count; i++) {
        const struct material *m = &scene->material[i / 2];
        if (i % 2 && !m->two_sided) continue;
        satin_status status = build_side(i % 2 ? &m->back : &m->front, options, pool, &t.table[i]);
        if (status != SATIN_OK) {
            shade_tables_free(&t);
            return log_fail(log, status, "cannot represent BRDF '%s' in harmonics", m->name);
        }
        if (!t.table[i]) continue;
        struct brdf_table_info info = brdf_table_info(t.table[i]);
        t.channels[i] = info.channels;
        if (info.order > t.order) t.order = info.order;
    }
    *out = t;
    return SATIN_OK;
}

void shade_tables_free(struct shade_tables *tables) {
    for (size_t i = 0; i < tables->count && tables->table; i++) brdf_table_free(tables->table[i]);
    free(tables->table);
    free(tables->channels);
    *tables = (struct shade_tables){0};
}
