// SPDX-License-Identifier: Apache-2.0
// Poses: where the objects and lights of a frame are, and how bright. A pose is applied to the
// parameters of its element before anything is built from them, so the scene is that of a file with
// these values.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/fileio.h"
#include "base/text.h"
#include "load/load_state.h"

struct load_pose {
    const satin_pose *pose;
    struct mat4 move;  // from the left of to_world
    bool moves, dims;  // whether it is not the place, or the intensity, that the scene has
    bool used, lit;    // whether an element of its id was built, and a light
};

// The motion of a pose: scaled and rotated about its pivot, then translated.
static struct mat4 pose_matrix(const satin_pose *pose) {
    const vec3 pivot = v3_of_doubles(pose->pivot), axis = v3_of_doubles(pose->axis);
    const float scale = (float)pose->scale;
    const struct mat4 from = mat4_translate(v3_neg(pivot)),
                      grow = mat4_scale(v3(scale, scale, scale)),
                      rotate = v3_max_abs(axis) > 0.0f ? mat4_rotate(axis, (float)pose->angle)
                                                       : mat4_identity(),
                      to = mat4_translate(v3_add(pivot, v3_of_doubles(pose->translate)));
    const struct mat4 grown = mat4_mul(&grow, &from), rotated = mat4_mul(&rotate, &grown);
    return mat4_mul(&to, &rotated);
}

satin_status load_poses_begin(struct load_state *loader, const satin_scene_request *request) {
    if (!request->pose_count) return SATIN_OK;
    loader->pose = array_new(request->pose_count, sizeof *loader->pose);
    if (!loader->pose) return load_no_memory(loader);
    for (size_t i = 0; i < request->pose_count; i++) {
        const satin_pose *pose = &request->poses[i];
        struct load_pose *out = &loader->pose[loader->pose_count++];
        *out = (struct load_pose){.pose = pose, .move = pose_matrix(pose)};
        const double translate[3] = {0.0, 0.0, 0.0};
        out->moves = memcmp(pose->translate, translate, sizeof translate) != 0 ||
                     pose->angle != 0.0 || pose->scale != 1.0;
        out->dims = pose->intensity != 1.0;
    }
    return SATIN_OK;
}

uint64_t load_poses_hash(const struct load_state *loader, uint64_t hash) {
    for (size_t i = 0; i < loader->pose_count; i++) {
        const struct load_pose *p = &loader->pose[i];
        if (!p->moves && !p->dims) continue;
        hash = fileio_hash(hash, p->pose->id, strlen(p->pose->id) + 1);
        hash = fileio_hash(hash, &p->move, sizeof p->move);
        hash = fileio_hash(hash, &p->pose->intensity, sizeof p->pose->intensity);
    }
    return hash;
}

// The pose of an element, or NULL.
static struct load_pose *find_pose(const struct load_state *loader, const struct xml_node *node) {
    for (size_t i = 0; i < loader->pose_count && node->id; i++)
        if (strcmp(loader->pose[i].pose->id, node->id) == 0) return &loader->pose[i];
    return NULL;
}

bool load_pose_gone(const struct load_state *loader, const struct xml_node *node) {
    const struct load_pose *pose = find_pose(loader, node);
    return pose && pose->pose->scale == 0.0;
}

static struct param_value *transform_of(struct params *p, const char *name) {
    return &p->value[load_param(p, name) - p->value];
}

// Moves the parameters that place a shape or a light.
static void move_params(const struct load_pose *pose, struct params *p) {
    static const char *const directions[] = {"direction", "sun_direction"};
    if (load_params_has(p, "to_world")) {
        struct mat4 *m = &transform_of(p, "to_world")->m;
        *m = mat4_mul(&pose->move, m);
    }
    if (load_params_has(p, "position")) {
        struct param_value *at = transform_of(p, "position");
        at->v = mat4_point(&pose->move, at->v);
    }
    for (int i = 0; i < 2; i++)
        if (load_params_has(p, directions[i])) {
            struct param_value *at = transform_of(p, directions[i]);
            at->v = mat4_vector(&pose->move, at->v);
        }
}

satin_status load_pose_apply(struct load_state *loader, struct params *p) {
    struct load_pose *pose = find_pose(loader, p->node);
    if (!pose || (p->plugin->tag != XML_SHAPE && p->plugin->tag != XML_EMITTER)) return SATIN_OK;
    pose->used = true;
    if (!pose->moves || load_pose_gone(loader, p->node)) return SATIN_OK;
    if (!load_params_has(p, "to_world"))
        return load_refuse(loader, p, "it has no to_world by which it could be moved");
    move_params(pose, p);
    return SATIN_OK;
}

satin_status load_pose_dim(struct load_state *loader, const struct xml_node *node,
                           struct light *light) {
    struct load_pose *pose = find_pose(loader, node);
    if (!pose) return SATIN_OK;
    pose->lit = true;
    if (!pose->dims) return SATIN_OK;
    const float by = (float)pose->pose->intensity;
    light->value = rgb_scale(light->value, by);
    light->sun_value = rgb_scale(light->sun_value, by);
    if (!light->texture || (light->kind != LIGHT_AREA && light->kind != LIGHT_BEAM))
        return SATIN_OK;
    struct texture *scaled = arena_alloc(&loader->scene->arena, sizeof *scaled);
    if (!scaled) return load_no_memory(loader);
    load_texture_scale(light->texture, rgb_grey(by), scaled);
    light->texture = scaled;
    return SATIN_OK;
}

// Where the scene has the element of that id; the root if it has none.
static struct log_place where_defined(const struct load_state *loader, const char *id) {
    for (size_t i = 0; i < loader->xml.id_count; i++)
        if (strcmp(loader->xml.id[i].id, id) == 0) return loader->xml.id[i].node->place;
    return loader->xml.root->place;
}

satin_status load_poses_check(struct load_state *loader) {
    for (size_t i = 0; i < loader->pose_count; i++) {
        const struct load_pose *pose = &loader->pose[i];
        const char *id = pose->pose->id;
        if (pose->used && pose->dims && !pose->lit) {
            log_error_at(loader->log, where_defined(loader, id),
                         "'%s' emits no light, so it has no intensity", id);
            return SATIN_ERROR_INPUT;
        }
        if (pose->used) continue;
        struct text_nearest nearest = {.word = id};
        for (size_t k = 0; k < loader->xml.id_count; k++) {
            const enum xml_tag tag = loader->xml.id[k].node->tag;
            if (tag == XML_SHAPE || tag == XML_EMITTER)
                text_nearest_try(&nearest, loader->xml.id[k].id);
        }
        if (nearest.best)
            log_error_at(loader->log, loader->xml.root->place,
                         "the scene has no shape or emitter '%s' (did you mean '%s'?)", id,
                         nearest.best);
        else
            log_error_at(loader->log, loader->xml.root->place,
                         "the scene has no shape or emitter '%s'", id);
        return SATIN_ERROR_INPUT;
    }
    return SATIN_OK;
}
