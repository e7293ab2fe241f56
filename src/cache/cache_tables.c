// SPDX-License-Identifier: Apache-2.0
// BRDF tables for the scene's glossy materials [K05 figure 3.5, preprocessing].
#include <stdlib.h>
#include <string.h>

#include "cache/cache.h"

// Whether the glossy lobe has the colour of a texture, and not as a factor.
static bool is_tinted_by_texture(const struct material_side *side) {
    if (side->slot[BRDF_SLOT_DIFFUSE] && brdf_tinted(&side->base)) return true;
    return !brdf_is_factored(&side->base) &&
           (side->slot[BRDF_SLOT_SPECULAR] || side->slot[BRDF_SLOT_COAT_SPECULAR]);
}

bool cache_shape_textured(const struct material_side *side) {
    for (int i = BRDF_SLOT_ETA; i < BRDF_SLOT_COUNT; i++)
        if (side->slot[i]) return true;
    return is_tinted_by_texture(side);
}

// Whether textures change only the roughness, equally along both axes; and its range.
static bool textures_roughness_only(const struct material_side *side, struct brdf_roughness *over) {
    const bool two = side->base.model->slots >> BRDF_SLOT_ALPHA_V & 1;
    if (is_tinted_by_texture(side)) return false;
    if (side->base.anisotropic != 0.0f) return false;
    if (two && side->slot[BRDF_SLOT_ALPHA_U] != side->slot[BRDF_SLOT_ALPHA_V]) return false;
    for (int i = BRDF_SLOT_ETA; i < BRDF_SLOT_COUNT; i++)
        if (side->slot[i] && i != BRDF_SLOT_ALPHA_U && i != BRDF_SLOT_ALPHA_V &&
            i != BRDF_SLOT_EXPONENT)
            return false;
    over->slot = side->slot[BRDF_SLOT_ALPHA_U] ? BRDF_SLOT_ALPHA_U : BRDF_SLOT_EXPONENT;
    return side->slot[over->slot] &&
           scene_texture_range(side->slot[over->slot], &over->lo, &over->hi);
}

enum table_choice { BY_ERROR, CACHED, SAMPLED };

// The choice for a material in the option material_cache: the first word with its name.
static enum table_choice material_choice(const satin_options *o, const char *name) {
    size_t length = strlen(name);
    for (const char *at = o->material_cache; *at;) {
        size_t word = strcspn(at, ",");
        if (strncmp(at, name, length) == 0 && at[length] == '=')
            return at[length + 2] == 'n' ? CACHED : SAMPLED;
        at += word + (at[word] == ',');
    }
    return BY_ERROR;
}

static satin_status build_side(const struct material_side *side, const satin_options *o,
                               enum table_choice choice, struct parallel *pool,
                               struct brdf_range **out) {
    struct brdf_roughness over;
    const struct brdf_fit fit = {o->radiance_basis, o->radiance_order, o->radiance_error,
                                 .always = choice == CACHED};
    if (choice == SAMPLED) return SATIN_OK;
    if (!side->base.model || !(brdf_lobes(&side->base) & BRDF_GLOSSY) || side->base.asymmetric)
        return SATIN_OK;
    const bool textured = cache_shape_textured(side);
    if (textured && !textures_roughness_only(side, &over)) return SATIN_OK;
    satin_status status = brdf_range_build(&side->base, textured ? &over : NULL, &fit, pool, out);
    if (status == SATIN_OK && brdf_range_describe(*out).order == 0) {
        brdf_range_free(*out);
        *out = NULL;
    }
    return status;
}

// State for visiting the materials; `first` has the side of each index that is built.
struct builder {
    const satin_options *options;
    struct parallel *pool;
    struct log log;
    const char *material;
    enum table_choice choice;
    const struct material_side **first;
    enum table_choice *choices;  // of the sides in `first`
    struct cache_tables tables;
    satin_status status;
};

// Uses the table of an equal side. False if there is none.
static bool take_equal_table(struct builder *b, const struct material_side *side) {
    if (cache_shape_textured(side)) return false;
    for (size_t j = 0; j < b->tables.count; j++) {
        const struct material_side *other = b->first[j];
        if (!other || !b->tables.owned[j] || cache_shape_textured(other)) continue;
        if (b->choices[j] != b->choice) continue;
        if (!brdf_same_shape(&side->base, &other->base)) continue;
        b->tables.table[side->index] = b->tables.table[j];
        b->tables.channels[side->index] = b->tables.channels[j];
        return true;
    }
    return false;
}

static void build_table(void *ctx, const struct material_side *side) {
    struct builder *b = ctx;
    struct cache_tables *t = &b->tables;
    size_t i = side->index;
    if (b->status != SATIN_OK || b->first[i]) return;
    b->first[i] = side;
    b->choices[i] = b->choice;
    if (take_equal_table(b, side)) return;
    b->status = build_side(side, b->options, b->choice, b->pool, &t->table[i]);
    t->owned[i] = true;
    if (b->status != SATIN_OK && b->status != SATIN_CANCELLED)
        log_fail(b->log, b->status, "cannot represent BRDF '%s' in harmonics", b->material);
    if (!t->table[i]) return;
    struct brdf_table_info info = brdf_range_describe(t->table[i]);
    t->channels[i] = info.channels;
    if (info.order > t->order) t->order = info.order;
}

// One flag per material: whether a shape has it.
static bool *used_materials(const struct satin_scene *scene) {
    bool *used = calloc((size_t)scene->material_count + 1, sizeof *used);
    for (uint32_t i = 0; used && i < scene->shape_count; i++) used[scene->shape[i].material] = true;
    return used;
}

satin_status cache_tables_build(const struct satin_scene *scene, const satin_options *options,
                                struct parallel *pool, struct log log, struct cache_tables *out) {
    struct builder b = {.options = options, .pool = pool, .log = log};
    struct cache_tables *t = &b.tables;
    t->count = options->radiance_cache ? scene->side_count : 0;
    bool *used = used_materials(scene);
    t->table = calloc(t->count + 1, sizeof *t->table);
    t->owned = calloc(t->count + 1, sizeof *t->owned);
    t->channels = calloc(t->count + 1, sizeof *t->channels);
    b.first = calloc(t->count + 1, sizeof *b.first);
    b.choices = calloc(t->count + 1, sizeof *b.choices);
    if (options->radiance_cache && options->radiance_diffuse) t->order = options->radiance_order;
    if (!used || !t->table || !t->owned || !t->channels || !b.first || !b.choices)
        b.status = log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for BRDF tables");
    for (uint32_t i = 0; t->count && i < scene->material_count && b.status == SATIN_OK; i++) {
        b.material = scene->material[i].name;
        b.choice = material_choice(options, b.material);
        if (used[i]) scene_material_visit(&scene->material[i], build_table, &b);
    }
    free(used);
    free(b.first);
    free(b.choices);
    if (b.status != SATIN_OK)
        cache_tables_free(t);
    else
        *out = *t;
    return b.status;
}

const struct brdf_range *cache_table(const struct cache_tables *tables,
                                     const struct material_side *side, int *channels) {
    if (side->index >= tables->count) return NULL;
    *channels = tables->channels[side->index];
    return tables->table[side->index];
}

void cache_tables_free(struct cache_tables *tables) {
    for (size_t i = 0; tables->table && tables->owned && i < tables->count; i++)
        if (tables->owned[i]) brdf_range_free(tables->table[i]);
    free(tables->table);
    free(tables->owned);
    free(tables->channels);
    *tables = (struct cache_tables){0};
}
