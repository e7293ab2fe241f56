// SPDX-License-Identifier: Apache-2.0
// <shape>s of shapes: merge adds them to the scene; a shapegroup does not, but each instance shows
// a group by a transform. Names and rules are Mitsuba 3's: groups contain no lights and no
// instances.
#include <string.h>

#include "base/array.h"
#include "load/load_state.h"

enum { GROUP_NESTING_MAX = 16 };
#define GROUP_EMPTY UINT32_MAX  // instead of 1 + the index of a group: it has no shapes

static const struct param_spec instance_to_world = {
    "to_world",
    PARAM_TRANSFORM,
    "1",
    0,
    0,
    NULL,
    "The transform from the group's space to world space."};

static const struct param_spec *const instance_params[] = {&instance_to_world, NULL};

const struct plugin_spec load_group_plugins[] = {
    {XML_SHAPE, "merge", "several shapes that form one", NULL, 1u << XML_SHAPE, NULL, false},
    {XML_SHAPE, "shapegroup", "shapes that are visible through instances only", NULL,
     1u << XML_SHAPE, NULL, false},
    {XML_SHAPE, "instance", "a shapegroup, placed by a transform", instance_params, 1u << XML_SHAPE,
     NULL, false},
    {0}};

static satin_status add_children(struct load_state *loader, const struct params *p) {
    if (loader->shape_depth == GROUP_NESTING_MAX)
        return load_refuse(loader, p, "shapes are nested too deep, or contain themselves");
    loader->shape_depth++;
    satin_status status = SATIN_OK;
    struct xml_node *at = NULL, *child;
    while (status == SATIN_OK && (child = load_params_child(&loader->xml, p->node, XML_SHAPE, &at)))
        status = load_shape_add(loader, child);
    loader->shape_depth--;
    return status;
}

// Builds a group at the first reference to it.
static satin_status add_group(struct load_state *loader, const struct params *p) {
    if (p->node->group) return SATIN_OK;
    if (loader->open_group) return load_refuse(loader, p, "it cannot be part of another group");
    void *items = loader->group;
    if (!array_reserve(&items, &loader->group_capacity, loader->group_count + 1,
                       sizeof *loader->group))
        return load_no_memory(loader);
    loader->group = items;
    struct shape_group group = {.first = (uint32_t)loader->shape_count};
    loader->open_group = (uint32_t)loader->group_count + 1;
    satin_status status = add_children(loader, p);
    p->node->group = loader->open_group;
    loader->open_group = 0;
    group.count = (uint32_t)loader->shape_count - group.first;
    if (status != SATIN_OK) return status;
    if (!group.count) {
        p->node->group = GROUP_EMPTY;
        return SATIN_OK;
    }
    loader->group[loader->group_count++] = group;
    return SATIN_OK;
}

static satin_status add_instance(struct load_state *loader, const struct params *p) {
    if (loader->open_group) return load_refuse(loader, p, "it cannot be part of a group");
    struct xml_node *at = NULL, *group = load_params_child(&loader->xml, p->node, XML_SHAPE, &at);
    if (!group && load_ref_missing(loader, p->node)) return SATIN_OK;
    if (!group || load_params_child(&loader->xml, p->node, XML_SHAPE, &at) ||
        strcmp(group->type, "shapegroup") != 0)
        return load_refuse(loader, p, "it takes one shapegroup");
    satin_status status = group->group ? SATIN_OK : load_shape_add(loader, group);
    if (status != SATIN_OK) return status;
    if (load_pose_gone(loader, p->node)) return SATIN_OK;
    struct shape shape = {.kind = SHAPE_INSTANCE,
                          .has_id = p->node->id != NULL,
                          .instance_of = group->group - 1,
                          .light = -1};
    if (!scene_shape_transform(&shape, &load_param(p, "to_world")->m))
        return load_refuse(loader, p, "to_world is singular");
    if (group->group == GROUP_EMPTY) return SATIN_OK;
    shape.name = load_shape_name(loader, p->node, p->plugin->name);
    if (!shape.name) return load_no_memory(loader);
    shape.material = loader->shape[loader->group[shape.instance_of].first].material;
    status = load_shape_reserve(loader, p);
    if (status == SATIN_OK) loader->shape[loader->shape_count++] = shape;
    return status;
}

satin_status load_group_add(struct load_state *loader, const struct params *p) {
    if (p->plugin == &load_group_plugins[0]) return add_children(loader, p);
    return p->plugin == &load_group_plugins[1] ? add_group(loader, p) : add_instance(loader, p);
}
