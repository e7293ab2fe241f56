// SPDX-License-Identifier: Apache-2.0
// Materials from <bsdf>s: those that contain others (twosided, blendbsdf, mask, bumpmap, normalmap)
// and may nest in any order, and the list of the scene's materials. A material is a tree of sides
// for the front and one for the back, whose leaves are BRDFs.
#include <string.h>

#include "base/array.h"
#include "load/load_plugins_bsdf.h"

enum { BSDF_DEPTH_MAX = 32 };  // of nested <bsdf>s; a deeper nesting is a reference to itself

static satin_status material_error(struct load_state *loader, const struct params *p,
                                   const char *text) {
    log_error_at(loader->log, p->node->place, "%s %s", p->plugin->name, text);
    return SATIN_ERROR_INPUT;
}

// The material of a shape without a <bsdf>.
static satin_status default_material(struct load_state *loader, enum plain_material plain,
                                     struct material *out) {
    static const char *const names[] = {"default", "black", "null"};
    *out = (struct material){.name = names[plain]};
    out->front.index = loader->scene->side_count++;
    out->front.base.model = brdf_find(plain == PLAIN_NULL ? "null" : "diffuse");
    out->front.base.diffuse = rgb_grey(plain == PLAIN_GREY ? 0.5f : 0.0f);
    out->front.base.transmittance = rgb_grey(1.0f);  // of PLAIN_NULL
    if (brdf_prepare(&out->front.base, &loader->scene->arena, NULL) != SATIN_OK)
        return load_no_memory(loader);
    out->back = out->front;
    return SATIN_OK;
}

// Builds the nested <bsdf>s, of which there must be `least` to `most`. *count is their number.
static satin_status build_nested(struct load_state *loader, const struct params *p, int least,
                                 int most, struct material *out, int *count) {
    struct xml_node *at = NULL, *child;
    int n = 0;
    while ((child = load_params_child(&loader->xml, p->node, XML_BSDF, &at)) && n < most) {
        satin_status status = load_material_build(loader, child, &out[n]);
        if (status != SATIN_OK) return status;
        n++;
    }
    // Each <ref> that leads nowhere is a grey one.
    for (; n < least && load_ref_missing(loader, p->node); n++) {
        satin_status status = default_material(loader, PLAIN_GREY, &out[n]);
        if (status != SATIN_OK) return status;
    }
    *count = n;
    if (n >= least && !child) return SATIN_OK;
    return material_error(loader, p,
                          most > 2       ? "takes 1 to 16 <bsdf>s"
                          : least < most ? "takes one or two <bsdf>s"
                          : most == 1    ? "takes one <bsdf>"
                                         : "takes two <bsdf>s");
}

// ---- Trees of sides -----------------------------------------------------------------------------

static int count_components(const struct material_side *side) {
    return side->component[0]
               ? count_components(side->component[0]) + count_components(side->component[1])
               : 1;
}

typedef satin_status (*leaf_fn)(struct load_state *loader, const struct params *p,
                                struct material_side *leaf, const void *ctx);

// Copies the tree, with its leaves changed by fn.
static satin_status change_leaves(struct load_state *loader, const struct params *p,
                                  struct material_side *side, leaf_fn fn, const void *ctx) {
    if (!side->component[0]) return fn(loader, p, side, ctx);
    for (int i = 0; i < 2; i++) {
        struct material_side *copy = arena_alloc(&loader->scene->arena, sizeof *copy);
        if (!copy) return load_no_memory(loader);
        *copy = *side->component[i];
        side->component[i] = copy;
        satin_status status = change_leaves(loader, p, copy, fn, ctx);
        if (status != SATIN_OK) return status;
    }
    return SATIN_OK;
}

// ---- twosided -----------------------------------------------------------------------------------

// Makes a leaf one side of a two-sided material. BRDFs that transmit are refused; the bump or
// normal map of a back is its own. If a material is two-sided already, its front is used for either
// side, as in Mitsuba.
static satin_status make_side(struct load_state *loader, const struct params *p,
                              struct material_side *leaf, const void *ctx) {
    (void)ctx;
    for (int i = 0; i < BRDF_BUMPS_MAX; i++) leaf->bump[i].outside = false;
    if (!brdf_transmits(&leaf->base)) return SATIN_OK;
    log_error_at(loader->log, p->node->place, "'%s' transmits, so it cannot be twosided",
                 leaf->base.model->name);
    return SATIN_ERROR_INPUT;
}

static satin_status build_twosided(struct load_state *loader, const struct params *p,
                                   struct material *out) {
    struct material side[2];
    int count;
    satin_status status = build_nested(loader, p, 1, 2, side, &count);
    for (int i = 0; i < count && status == SATIN_OK; i++) {
        if (side[i].front.component[0] && side[i].front.holes)
            return material_error(loader, p, "cannot wrap a mask; wrap it by one");
        status = change_leaves(loader, p, &side[i].front, make_side, NULL);
    }
    if (status != SATIN_OK) return status;
    out->front = side[0].front;
    out->back = side[count - 1].front;
    out->two_sided = true;
    out->tangent = side[0].tangent || side[count - 1].tangent;
    return SATIN_OK;
}

// ---- blendbsdf ----------------------------------------------------------------------------------

static satin_status make_one_sided(struct load_state *loader, const struct params *p,
                                   struct material_side *leaf, const void *ctx) {
    (void)loader, (void)p, (void)ctx;
    leaf->one_sided = true;
    return SATIN_OK;
}

// The weight of a blend's second component, constant or textured.
struct blend_weight_value {
    float value;
    const struct texture *texture;
};

static satin_status find_weight(struct load_state *loader, const struct param_value *value,
                                float constant, struct blend_weight_value *out) {
    *out = (struct blend_weight_value){.value = clampf(constant, 0.0f, 1.0f)};
    return value->texture ? load_texture_of(loader, value->texture, &out->texture) : SATIN_OK;
}

static bool is_hole(const struct material_side *side) { return side->holes && !side->component[0]; }

static satin_status make_pointwise(struct load_state *loader, const struct params *p,
                                   struct material_side *leaf, const void *ctx) {
    (void)loader, (void)p, (void)ctx;
    leaf->pointwise = true;
    return SATIN_OK;
}

// Blends a and b in one node, which may be a or b.
static satin_status join_sides(struct load_state *loader, const struct params *p,
                               const struct material_side *a, const struct material_side *b,
                               const struct blend_weight_value *weight, struct material_side *out) {
    if (is_hole(a) && is_hole(b)) {
        *out = *a;
        return SATIN_OK;
    }
    struct material_side *component = arena_array(&loader->scene->arena, 2, sizeof *component);
    if (!component) return load_no_memory(loader);
    component[0] = *a;
    component[1] = *b;
    *out = (struct material_side){.component = {&component[0], &component[1]},
                                  .blend = weight->texture,
                                  .weight = weight->value,
                                  .holes = a->holes || b->holes};
    if (count_components(out) > MATERIAL_COMPONENTS_MAX)
        return material_error(loader, p, "blends more than 16 BRDFs");
    return weight->texture ? change_leaves(loader, p, out, make_pointwise, NULL) : SATIN_OK;
}

// Blends two materials, which may get a back. `out` may be one of them.
static satin_status blend_two(struct load_state *loader, const struct params *p,
                              struct material component[2], const struct blend_weight_value *weight,
                              struct material *out) {
    satin_status status = SATIN_OK;
    out->two_sided = component[0].two_sided || component[1].two_sided;
    out->tangent = component[0].tangent || component[1].tangent;
    for (int i = 0; i < 2 && out->two_sided && status == SATIN_OK; i++) {
        if (component[i].two_sided) continue;
        component[i].back = component[i].front;
        status = change_leaves(loader, p, &component[i].back, make_one_sided, NULL);
    }
    if (status == SATIN_OK)
        status =
            join_sides(loader, p, &component[0].front, &component[1].front, weight, &out->front);
    if (status != SATIN_OK) return status;
    out->back = out->front;
    if (!out->two_sided) return SATIN_OK;
    return join_sides(loader, p, &component[0].back, &component[1].back, weight, &out->back);
}

static satin_status build_blend(struct load_state *loader, const struct params *p,
                                struct material *out) {
    struct material component[2];
    struct blend_weight_value weight;
    int count;
    satin_status status = build_nested(loader, p, 2, 2, component, &count);
    if (status == SATIN_OK)
        status = find_weight(loader, load_param(p, "weight"), load_param(p, "weight")->f, &weight);
    return status == SATIN_OK ? blend_two(loader, p, component, &weight, out) : status;
}

// ---- mixturebsdf --------------------------------------------------------------------------------

static const struct param_spec mixture_weights = {"weights",
                                                  PARAM_STRING,
                                                  NULL,
                                                  0,
                                                  PARAM_REQUIRED,
                                                  NULL,
                                                  "A list of one weight for each BRDF. If they sum "
                                                  "to less than 1, the rest is black; if to more, "
                                                  "they are divided by their sum."};
param_list bsdf_mixture_params = {&mixture_weights, NULL};

// Reads the weights of `count` BRDFs, and returns their sum, or a negative number if they are
// wrong.
static double read_weights(struct load_state *loader, const struct params *p, int count,
                           double *weight) {
    const struct param_value *text = load_param(p, "weights");
    double sum = 0.0;
    if (load_param_words(text->s) != count) {
        log_error_at(loader->log, text->place, "mixturebsdf has %d <bsdf>s, but %d weights", count,
                     load_param_words(text->s));
        return -1.0;
    }
    if (!load_param_numbers(loader->log, text->place, text->s, count, weight)) return -1.0;
    for (int i = 0; i < count; i++) {
        sum += weight[i];
        if (weight[i] >= 0.0 && weight[i] <= 1e6) continue;
        log_error_at(loader->log, text->place, "a weight is %g, but must be 0 to 1e6", weight[i]);
        return -1.0;
    }
    return sum;
}

// Builds a mixture of version 0.6 as blends of each BRDF with those before it. Of weights that sum
// to less than 1, the rest is black; larger ones are divided by their sum.
static satin_status build_mixture(struct load_state *loader, const struct params *p,
                                  struct material *out) {
    struct material component[MATERIAL_COMPONENTS_MAX], both[2];
    double weight[MATERIAL_COMPONENTS_MAX], sum = 0.0;
    int count;
    satin_status status = build_nested(loader, p, 1, MATERIAL_COMPONENTS_MAX, component, &count);
    if (status != SATIN_OK) return status;
    const double all = read_weights(loader, p, count, weight);
    if (all < 0.0) return SATIN_ERROR_INPUT;
    if (all > 1.0 + 1e-5)
        log_warning_at(loader->log, p->node->place,
                       "mixturebsdf: the weights sum to %g; they are divided by that", all);
    *out = component[0];
    for (int i = 0; i < count && status == SATIN_OK; i++) {
        sum += weight[i];
        const float of_next = sum > 0.0 ? (float)(weight[i] / sum) : 0.0f;
        if (i == 0) continue;
        both[0] = *out;
        both[1] = component[i];
        status = blend_two(loader, p, both, &(struct blend_weight_value){.value = of_next}, out);
    }
    if (status != SATIN_OK || all > 1.0 - 1e-5) return status;
    both[0] = *out;
    status = default_material(loader, PLAIN_BLACK, &both[1]);
    if (status != SATIN_OK) return status;
    return blend_two(loader, p, both, &(struct blend_weight_value){.value = (float)(1.0 - all)},
                     out);
}

// ---- mask ---------------------------------------------------------------------------------------

// Builds a blend of a null BRDF and the nested BRDF.
static satin_status build_mask(struct load_state *loader, const struct params *p,
                               struct material *out) {
    const struct param_value *opacity = load_param(p, "opacity");
    struct material_side hole = {.index = loader->scene->side_count++, .holes = true};
    struct blend_weight_value weight;
    int count;
    hole.base.model = brdf_find("null");
    hole.base.transmittance = rgb_grey(1.0f);
    if (brdf_prepare(&hole.base, &loader->scene->arena, NULL) != SATIN_OK)
        return load_no_memory(loader);
    satin_status status = build_nested(loader, p, 1, 1, out, &count);
    if (status == SATIN_OK)
        status = find_weight(loader, opacity, rgb_mean(opacity->color), &weight);
    if (status == SATIN_OK)
        status = join_sides(loader, p, &hole, &out->front, &weight, &out->front);
    if (status != SATIN_OK) return status;
    if (out->two_sided) return join_sides(loader, p, &hole, &out->back, &weight, &out->back);
    out->back = out->front;
    return SATIN_OK;
}

// ---- coating, roughcoating ----------------------------------------------------------------------

static satin_status build_coat(struct load_state *loader, const struct params *p,
                               struct material *out) {
    struct bsdf_coat coat;
    int count;
    satin_status status = load_bsdf_coat_read(loader, p, &coat);
    if (status == SATIN_OK) status = build_nested(loader, p, 1, 1, out, &count);
    if (status == SATIN_OK)
        status = change_leaves(loader, p, &out->front, load_bsdf_coat_side, &coat);
    if (status == SATIN_OK && out->two_sided)
        return change_leaves(loader, p, &out->back, load_bsdf_coat_side, &coat);
    out->back = out->front;
    return status;
}

// ---- bumpmap, normalmap -------------------------------------------------------------------------

static satin_status set_bump(struct load_state *loader, const struct params *p,
                             struct material_side *leaf, const void *ctx) {
    const struct material_bump *bump = ctx;
    if (leaf->holes) return SATIN_OK;
    if (scene_bump_used(&leaf->bump[1]))
        return material_error(loader, p, "cannot wrap two more bumpmaps or normalmaps");
    leaf->bump[1] = leaf->bump[0];
    leaf->bump[0] = *bump;
    return SATIN_OK;
}

// A colour instead of a normal map: one normal everywhere.
static satin_status constant_normal(struct load_state *loader, rgb value,
                                    const struct texture **out) {
    struct texture *texture = arena_alloc(&loader->scene->arena, sizeof *texture);
    if (!texture) return load_no_memory(loader);
    *texture = (struct texture){.kind = TEXTURE_CONSTANT, .value = value, .mean = value};
    *out = texture;
    return SATIN_OK;
}

static satin_status build_bump_or_normal(struct load_state *loader, const struct params *p,
                                         bool heights, struct material *out) {
    struct material_bump bump = {.outside = true,
                                 .upright = load_param(p, "flip_invalid_normals")->b,
                                 .shadows = load_param(p, "use_shadowing_function")->b};
    struct xml_node *at = NULL, *map = load_params_child(&loader->xml, p->node, XML_TEXTURE, &at);
    const bool constant =
        !heights && load_param(p, "normalmap")->given && !load_param(p, "normalmap")->texture;
    if (!map && heights) return material_error(loader, p, "needs a <texture>");
    if (!map && !constant)
        return material_error(loader, p, "needs a <texture> or the parameter 'normalmap'");
    if (map && (constant || load_params_child(&loader->xml, p->node, XML_TEXTURE, &at)))
        return material_error(loader, p, "takes one <texture>");
    if (heights) bump.scale = load_param(p, "scale")->f;
    satin_status status =
        map ? load_texture_of(loader, map, heights ? &bump.height : &bump.normal)
            : constant_normal(loader, load_param(p, "normalmap")->color, &bump.normal);
    if (status == SATIN_OK && heights &&
        scene_texture_unscaled(bump.height)->kind == TEXTURE_ATTRIBUTE)
        return material_error(loader, p, "cannot take heights from a mesh attribute");
    int count;
    if (status == SATIN_OK) status = build_nested(loader, p, 1, 1, out, &count);
    if (status == SATIN_OK) status = change_leaves(loader, p, &out->front, set_bump, &bump);
    if (status == SATIN_OK && out->two_sided)
        status = change_leaves(loader, p, &out->back, set_bump, &bump);
    if (status == SATIN_OK && !out->two_sided) out->back = out->front;
    out->tangent = true;
    return status;
}

// ---- Any <bsdf> ---------------------------------------------------------------------------------

static bool is_anisotropic(const struct material_side *side) {
    bool two = side->base.model->slots >> BRDF_SLOT_ALPHA_V & 1;
    if (side->base.model->data) return !side->base.isotropic;
    return (two && side->slot[BRDF_SLOT_ALPHA_U] != side->slot[BRDF_SLOT_ALPHA_V]) ||
           (two && side->base.alpha_u != side->base.alpha_v) || side->slot[BRDF_SLOT_ANISOTROPIC] ||
           side->base.anisotropic != 0.0f;
}

static satin_status build_plain(struct load_state *loader, const struct params *p,
                                struct material *out) {
    satin_status status = load_side_build(loader, p, &out->front);
    out->back = out->front;
    out->tangent = is_anisotropic(&out->front);
    return status;
}

static satin_status build_any(struct load_state *loader, const struct params *p,
                              struct material *out) {
    const char *name = p->plugin->name;
    if (p->plugin->build) return build_plain(loader, p, out);
    if (strcmp(name, "twosided") == 0) return build_twosided(loader, p, out);
    if (strcmp(name, "blendbsdf") == 0) return build_blend(loader, p, out);
    if (strcmp(name, "mixturebsdf") == 0) return build_mixture(loader, p, out);
    if (strcmp(name, "mask") == 0) return build_mask(loader, p, out);
    if (p->plugin->params == bsdf_coat_params || p->plugin->params == bsdf_roughcoat_params)
        return build_coat(loader, p, out);
    return build_bump_or_normal(loader, p, strcmp(name, "bumpmap") == 0, out);
}

static void find_filtered(void *ctx, const struct material_side *side) {
    bool *found = ctx;
    for (int i = 0; i < BRDF_SLOT_NUMBERS; i++)
        *found = *found || (side->slot[i] && side->slot[i]->filtered);
}

// Builds a replacement for an unknown BRDF: the BRDF that it contains, or a grey diffuse one.
static satin_status build_stand_in(struct load_state *loader, struct xml_node *node,
                                   struct material *out) {
    struct xml_node *at = NULL, *inner = load_params_child(&loader->xml, node, XML_BSDF, &at);
    if (!inner || load_params_child(&loader->xml, node, XML_BSDF, &at)) {
        satin_status status = default_material(loader, PLAIN_GREY, out);
        out->two_sided = true;
        return status;
    }
    if (loader->bsdf_depth == BSDF_DEPTH_MAX) {
        log_error_at(loader->log, node->place,
                     "BRDF '%s' contains itself, or over 32 BRDFs in each other", node->type);
        return SATIN_ERROR_INPUT;
    }
    loader->bsdf_depth++;
    satin_status status = load_material_build(loader, inner, out);
    loader->bsdf_depth--;
    return status;
}

satin_status load_material_build(struct load_state *loader, struct xml_node *node,
                                 struct material *out) {
    *out = (struct material){0};
    struct params p;
    if (load_left_out(loader, node, "it is grey, or what it wraps"))
        return build_stand_in(loader, node, out);
    satin_status status = load_params(loader, node, &p);
    if (status != SATIN_OK) return status;
    if (loader->bsdf_depth == BSDF_DEPTH_MAX)
        return material_error(loader, &p, "contains itself, or over 32 BRDFs in each other");
    struct load_spared spared;
    load_spare_file(loader, &p, "the BRDF is grey", &spared);
    loader->bsdf_depth++;
    status = build_any(loader, &p, out);
    loader->bsdf_depth--;
    if (load_spare_end(loader, &spared, &status)) return build_stand_in(loader, node, out);
    if (status == SATIN_OK) scene_material_visit(out, find_filtered, &out->filtered);
    if (status == SATIN_OK &&
        !(out->name = load_keep_text(loader, node->id ? node->id : p.plugin->name)))
        return load_no_memory(loader);
    return status;
}

// Adds a material to the scene. *known is set to 1 + its index.
static satin_status add_material(struct load_state *loader, const struct material *material,
                                 uint32_t *known) {
    void *items = loader->material;
    if (!array_reserve(&items, &loader->material_capacity, loader->material_count + 1,
                       sizeof *material))
        return load_no_memory(loader);
    loader->material = items;
    loader->material[loader->material_count++] = *material;
    *known = (uint32_t)loader->material_count;
    return SATIN_OK;
}

satin_status load_material_of(struct load_state *loader, struct xml_node *node,
                              enum plain_material plain, uint32_t *index) {
    uint32_t *known = node ? &node->material : &loader->plain[plain];
    struct material material;
    satin_status status = SATIN_OK;
    if (!*known) {
        status = node ? load_material_build(loader, node, &material)
                      : default_material(loader, plain, &material);
        if (status == SATIN_OK) status = add_material(loader, &material, known);
    }
    if (status == SATIN_OK) *index = *known - 1;
    return status;
}
