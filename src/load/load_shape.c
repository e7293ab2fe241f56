// SPDX-License-Identifier: Apache-2.0
// Adds shapes to the scene: each with its surface, its BRDF and its light. An OBJ with BRDFs for
// the materials that it names, as Mitsuba 0.6 reads it, becomes a shape for each of them.
#include <stdio.h>
#include <string.h>

#include "base/array.h"
#include "load/load_attribute.h"
#include "load/load_plugins_shape.h"
#include "load/load_state.h"

// The least area of an emitter: the cube of its size is in the range of float.
#define EMITTER_AREA_MIN 1e-24f

enum { SHAPES_MAX = 1 << 20 };  // each shape takes some kilobytes, whatever it is

// The only child of a tag, or NULL. A second one is an error.
static satin_status only_child(struct load_state *loader, const struct params *p, enum xml_tag tag,
                               struct xml_node **out) {
    struct xml_node *at = NULL;
    *out = load_params_child(&loader->xml, p->node, tag, &at);
    if (!*out || !load_params_child(&loader->xml, p->node, tag, &at)) return SATIN_OK;
    log_error_at(loader->log, at->place, "shape '%s' has two <%s>s", p->plugin->name,
                 load_xml_tag_name(tag));
    return SATIN_ERROR_INPUT;
}

const char *load_shape_name(struct load_state *loader, const struct xml_node *node,
                            const char *plugin) {
    char name[64];
    if (node->id) return load_keep_text(loader, node->id);
    snprintf(name, sizeof name, "%s-%llu", plugin, (unsigned long long)loader->shape_elements);
    return load_keep_text(loader, name);
}

satin_status load_shape_reserve(struct load_state *loader, const struct params *p) {
    if (loader->shape_count >= SHAPES_MAX)
        return load_refuse(loader, p, "the scene has too many shapes");
    void *items = loader->shape;
    if (!array_reserve(&items, &loader->shape_capacity, loader->shape_count + 1,
                       sizeof *loader->shape))
        return load_no_memory(loader);
    loader->shape = items;
    return SATIN_OK;
}

// Collects the mesh attributes to which the shape's textures refer.
static satin_status want_attributes(struct load_state *loader, const struct params *p,
                                    const struct shape *shape) {
    const struct texture *radiance = shape->light >= 0 ? loader->light[shape->light].texture : NULL;
    loader->wanted.count = 0;
    if (load_attribute_want_all(&loader->wanted, &loader->material[shape->material]) &&
        load_attribute_want(&loader->wanted, radiance))
        return SATIN_OK;
    return load_refuse(loader, p, "its textures refer to more than 8 mesh attributes");
}

// Refuses a shape without an attribute that a texture needs. If the loader is lenient, one that
// does not emit becomes grey.
static satin_status check_attributes(struct load_state *loader, const struct params *p,
                                     struct shape *shape) {
    const char *missing = load_attribute_missing(&loader->wanted, &shape->mesh);
    if (!missing) return SATIN_OK;
    if (loader->lenient && shape->light < 0) {
        log_warning_at(loader->each, p->node->place,
                       "shape '%s' has no attribute '%s' for its texture: it is grey",
                       p->plugin->name, missing);
        return load_material_of(loader, NULL, PLAIN_GREY, &shape->material);
    }
    log_error_at(loader->log, p->node->place, "shape '%s' has no attribute '%s' for its texture",
                 p->plugin->name, missing);
    return SATIN_ERROR_INPUT;
}

// Reads or makes the surface, with its attributes. *left_out is set to whether its file is spared.
static satin_status build_surface(struct load_state *loader, const struct params *p,
                                  struct shape *shape, bool *left_out) {
    struct load_spared spared;
    satin_status status = want_attributes(loader, p, shape);
    if (status != SATIN_OK) return status;
    load_spare_file(loader, p, "the shape is left out", &spared);
    status = p->plugin->build(loader, p, shape);
    *left_out = load_spare_end(loader, &spared, &status);
    if (*left_out) return SATIN_OK;
    return status == SATIN_OK ? check_attributes(loader, p, shape) : status;
}

// The shape of an element, as yet without a surface.
static satin_status begin_shape(struct load_state *loader, const struct params *p,
                                struct shape *out) {
    *out = (struct shape){.has_id = p->node->id != NULL,
                          .name = load_shape_name(loader, p->node, p->plugin->name),
                          .flip_normals = load_param(p, "flip_normals")->b,
                          .group = loader->open_group,
                          .light = -1};
    return out->name ? SATIN_OK : load_no_memory(loader);
}

// Checks a shape that is whole, and adds it.
static satin_status finish_shape(struct load_state *loader, const struct params *p,
                                 struct shape *shape) {
    const bool flat = shape->kind == SHAPE_DISK || strcmp(p->plugin->name, "rectangle") == 0;
    shape->area = scene_shape_area(shape);
    if (shape->kind == SHAPE_CURVES && shape->light >= 0)
        return load_refuse(loader, p, "curves cannot emit");
    if (shape->kind == SHAPE_CURVES &&
        scene_material_transmits(&loader->material[shape->material], true))
        return load_refuse(loader, p, "curves cannot transmit light");
    if (shape->light >= 0 && !flat && loader->light[shape->light].kind == LIGHT_BEAM)
        return load_refuse(loader, p, "a directionalarea emitter needs a rectangle or a disk");
    if (shape->light >= 0 && !(shape->area >= EMITTER_AREA_MIN))
        return load_refuse(loader, p, "it emits but has no area");
    if (shape->kind != SHAPE_CURVES && !(shape->area > 0.0f))
        log_warning_at(loader->log, p->node->place, "shape '%s' has no area and is not seen",
                       p->plugin->name);
    satin_status status = load_shape_reserve(loader, p);
    if (status == SATIN_OK) loader->shape[loader->shape_count++] = *shape;
    return status;
}

// ---- OBJ with several BRDFs ---------------------------------------------------------------------

// The BRDFs of an OBJ: those of materials by their names, and the last one of all other faces,
// which may be NULL.
struct obj_brdfs {
    const char **name;
    struct xml_node **node, *other;
    size_t count;
};

// The number of BRDFs in an element.
static size_t count_brdfs(const struct load_state *loader, const struct xml_node *node) {
    size_t count = 0;
    for (struct xml_node *at = NULL; load_params_child(&loader->xml, node, XML_BSDF, &at);) count++;
    return count;
}

static satin_status find_brdfs(struct load_state *loader, const struct params *p, size_t most,
                               struct obj_brdfs *out) {
    struct arena *arena = &loader->scene->arena;
    *out = (struct obj_brdfs){.name = arena_array(arena, most, sizeof *out->name),
                              .node = arena_array(arena, most, sizeof(struct xml_node *))};
    if (!out->name || !out->node) return load_no_memory(loader);
    struct xml_node *at = NULL, *brdf;
    while ((brdf = load_params_child(&loader->xml, p->node, XML_BSDF, &at))) {
        const bool named = at->name && at->name[0];
        bool twice = !named && out->other;
        for (size_t i = 0; i < out->count && named; i++)
            twice = twice || strcmp(out->name[i], at->name) == 0;
        if (twice) {
            log_error_at(loader->log, at->place,
                         named ? "shape 'obj' has two <bsdf>s of the name '%s'"
                               : "shape 'obj' has two <bsdf>s",
                         at->name);
            return SATIN_ERROR_INPUT;
        }
        if (!named) {
            out->other = brdf;
        } else {
            out->name[out->count] = at->name;
            out->node[out->count++] = brdf;
        }
    }
    return SATIN_OK;
}

// Adds the shape of one material.
static satin_status add_obj_mesh(struct load_state *loader, const struct params *p,
                                 struct shape shape, struct xml_node *brdf, const char *material) {
    char name[256];
    if (!shape.mesh.triangle_count) return SATIN_OK;
    satin_status status = load_material_of(loader, brdf, PLAIN_GREY, &shape.material);
    if (status == SATIN_OK) status = want_attributes(loader, p, &shape);
    if (status == SATIN_OK) status = check_attributes(loader, p, &shape);
    if (status != SATIN_OK || load_pose_gone(loader, p->node)) return status;
    snprintf(name, sizeof name, "%.127s-%.127s", shape.name, material ? material : "other");
    shape.name = load_keep_text(loader, name);
    return shape.name ? finish_shape(loader, p, &shape) : load_no_memory(loader);
}

static satin_status add_obj(struct load_state *loader, const struct params *p, size_t brdf_count) {
    struct obj_brdfs brdfs;
    struct load_spared spared;
    struct shape shape;
    satin_status status = find_brdfs(loader, p, brdf_count, &brdfs);
    if (status == SATIN_OK) status = begin_shape(loader, p, &shape);
    if (status != SATIN_OK) return status;
    struct mesh *mesh = arena_array(&loader->scene->arena, brdfs.count + 1, sizeof *mesh);
    if (!mesh) return load_no_memory(loader);
    const struct obj_materials materials = {brdfs.name, brdfs.count, brdfs.other != NULL};
    loader->wanted.count = 0;
    load_spare_file(loader, p, "the shape is left out", &spared);
    status = load_shape_obj(loader, p, &materials, &shape, mesh);
    if (load_spare_end(loader, &spared, &status)) return SATIN_OK;
    for (size_t i = 0; i <= brdfs.count && status == SATIN_OK; i++) {
        const bool last = i == brdfs.count;
        shape.mesh = mesh[i];
        if (!last && !mesh[i].triangle_count && !p->node->library)
            log_warning_at(loader->log, p->node->place, "no face of the file has the material '%s'",
                           brdfs.name[i]);
        status = add_obj_mesh(loader, p, shape, last ? brdfs.other : brdfs.node[i],
                              last ? NULL : brdfs.name[i]);
    }
    return status;
}

// ---- All shapes ---------------------------------------------------------------------------------

satin_status load_shape_add(struct load_state *loader, struct xml_node *node) {
    struct params p;
    if (load_left_out(loader, node, "the shape is left out")) return SATIN_OK;
    satin_status status = load_params(loader, node, &p);
    if (status != SATIN_OK) return status;
    // Nested references to shapes that add nothing could multiply without end.
    if (loader->shape_elements++ == SHAPES_MAX)
        return load_refuse(loader, &p, "the scene has too many shapes");
    if (!p.plugin->build) return load_group_add(loader, &p);
    struct xml_node *bsdf, *emitter;
    struct shape shape;
    bool left_out = false;
    status = only_child(loader, &p, XML_EMITTER, &emitter);
    if (status != SATIN_OK) return status;
    const bool obj = !emitter && strcmp(p.plugin->name, "obj") == 0;
    size_t brdf_count = count_brdfs(loader, node);
    if (obj && !brdf_count && node->mitsuba06 && !node->medium) {
        status = load_mesh_mtl(loader, &p);
        if (status != SATIN_OK) return status;
        brdf_count = count_brdfs(loader, node);
        node->library = brdf_count > 0;
    }
    if (obj && (brdf_count > 1 || node->library)) return add_obj(loader, &p, brdf_count);
    status = only_child(loader, &p, XML_BSDF, &bsdf);
    if (status == SATIN_OK) status = begin_shape(loader, &p, &shape);
    if (status != SATIN_OK) return status;
    if (emitter && shape.group) return load_refuse(loader, &p, "it cannot emit in a shapegroup");
    const enum plain_material plain = emitter                           ? PLAIN_BLACK
                                      : node->medium && node->mitsuba06 ? PLAIN_NULL
                                                                        : PLAIN_GREY;
    status = load_material_of(loader, bsdf, plain, &shape.material);
    // The material is there, so that all materials have the same numbers in all frames.
    if (status == SATIN_OK && load_pose_gone(loader, node)) return SATIN_OK;
    if (status == SATIN_OK && emitter)
        status = load_emitter_add(loader, emitter, node, &shape.light);
    if (status == SATIN_OK) status = build_surface(loader, &p, &shape, &left_out);
    if (left_out && shape.light >= 0) loader->light_count--;
    return status == SATIN_OK && !left_out ? finish_shape(loader, &p, &shape) : status;
}
