// SPDX-License-Identifier: Apache-2.0
// Objects and lights that move: the tables [[object]] of the file, and their poses in a frame.
#include <stdlib.h>
#include <string.h>

#include "animation/animation_reader.h"
#include "base/array.h"
#include "base/fileio.h"

enum { OBJECTS_MAX = 1000, KEYFRAMES_MAX = 100000 };

// ---- Reading ------------------------------------------------------------------------------------

static bool take_object_key(struct toml_reader *r, const struct toml_node *table,
                            struct animation_object *o, size_t i) {
    static const char *const known[] = {"frame", "translate", "angle", "scale", "intensity", NULL};
    static const double nowhere[3] = {0.0, 0.0, 0.0};
    const struct toml_node *frame = toml_find(table, "frame");
    if (!animation_check_keys(r, table, known)) return false;
    if (!frame) return toml_wrong(r, table, "the keyframe needs the key 'frame'");
    if (!animation_take_frame(r, frame, &o->at[i])) return false;
    if (i > 0 && !(o->at[i] > o->at[i - 1]))
        return toml_wrong(r, frame, "frame %.0f does not come after frame %.0f", o->at[i],
                          o->at[i - 1]);
    const struct toml_node *angle = toml_find(table, "angle");
    if (angle && o->axis[0] == 0.0 && o->axis[1] == 0.0 && o->axis[2] == 0.0)
        return toml_wrong(r, angle, "the object needs an axis for it, as in axis = [0, 1, 0]");
    return animation_take_vector(r, table, "translate", nowhere, o->translate[i]) &&
           animation_take_value(r, table, "angle", 0.0, true, &o->angle[i]) &&
           animation_take_value(r, table, "scale", 1.0, false, &o->scale[i]) &&
           animation_take_value(r, table, "intensity", 1.0, false, &o->intensity[i]);
}

static bool allocate_object_keys(struct animation_object *o, size_t count) {
    o->count = count;
    o->at = array_new(count, sizeof *o->at);
    o->translate = array_new(count, sizeof *o->translate);
    o->knot = array_new(count, sizeof *o->knot);
    o->angle = array_new(count, sizeof *o->angle);
    o->scale = array_new(count, sizeof *o->scale);
    o->intensity = array_new(count, sizeof *o->intensity);
    return o->at && o->translate && o->knot && o->angle && o->scale && o->intensity;
}

// A list of tables [[key]] of a bounded number, checked.
static bool check_list(struct toml_reader *r, const struct toml_node *list, const char *name,
                       size_t most) {
    bool tables = list->kind == TOML_ARRAY && list->count > 0;
    for (size_t i = 0; tables && i < list->count; i++) tables = list->child[i].kind == TOML_TABLE;
    if (!tables) return toml_wrong(r, list, "it must be written as [[%s]]", name);
    return list->count <= most || toml_wrong(r, list, "there can be %zu of them at most", most);
}

static bool take_id(struct toml_reader *r, const struct toml_node *table,
                    const struct animation_path *path, char **out) {
    const struct toml_node *id = toml_find(table, "id");
    if (!id) return toml_wrong(r, table, "the object needs the key 'id'");
    if (id->kind != TOML_TEXT) return toml_wrong(r, id, "it must be a text");
    for (size_t i = 0; i < path->object_count; i++)
        if (strcmp(path->object[i].id, id->text) == 0)
            return toml_wrong(r, id, "there is another object '%s'", id->text);
    *out = strdup(id->text);
    return *out || animation_no_memory(r);
}

static bool take_object(struct toml_reader *r, const struct toml_node *table,
                        struct animation_path *path) {
    static const char *const known[] = {"id", "pivot", "axis", "keyframe", NULL};
    static const double zero[3] = {0.0, 0.0, 0.0};
    struct animation_object *o = &path->object[path->object_count];
    const struct toml_node *keys = toml_find(table, "keyframe");
    if (!animation_check_keys(r, table, known) || !take_id(r, table, path, &o->id)) return false;
    path->object_count++;
    if (!animation_take_vector(r, table, "pivot", zero, o->pivot) ||
        !animation_take_vector(r, table, "axis", zero, o->axis))
        return false;
    if (!keys) return toml_wrong(r, table, "the object needs an [[object.keyframe]]");
    if (!check_list(r, keys, "object.keyframe", KEYFRAMES_MAX)) return false;
    if (!allocate_object_keys(o, keys->count)) return animation_no_memory(r);
    for (size_t i = 0; i < keys->count; i++)
        if (!take_object_key(r, &keys->child[i], o, i)) return false;
    animation_knots(o->count, o->translate, o->knot);
    return true;
}

bool animation_take_objects(struct toml_reader *r, const struct toml_node *list,
                            struct animation_path *out) {
    if (!check_list(r, list, "object", OBJECTS_MAX)) return false;
    out->object = array_new(list->count, sizeof *out->object);
    if (!out->object) return animation_no_memory(r);
    memset(out->object, 0, list->count * sizeof *out->object);
    for (size_t i = 0; i < list->count; i++)
        if (!take_object(r, &list->child[i], out)) return false;
    return true;
}

void animation_objects_free(struct animation_path *path) {
    for (size_t i = 0; i < path->object_count; i++) {
        struct animation_object *o = &path->object[i];
        free(o->id);
        free(o->at);
        free(o->translate);
        free(o->knot);
        free(o->angle);
        free(o->scale);
        free(o->intensity);
    }
    free(path->object);
}

// ---- Poses --------------------------------------------------------------------------------------

void animation_poses_at_rest(const struct animation_path *path, satin_pose *pose) {
    for (size_t i = 0; i < path->object_count; i++)
        pose[i] = (satin_pose){.id = path->object[i].id, .scale = 1.0, .intensity = 1.0};
}

void animation_poses(const struct animation_path *path, int number, satin_pose *pose) {
    animation_poses_at_rest(path, pose);
    for (size_t i = 0; i < path->object_count; i++) {
        const struct animation_object *o = &path->object[i];
        const double first = o->at[0], last = o->at[o->count - 1];
        const double x = number < first ? first : number > last ? last : number;
        memcpy(pose[i].pivot, o->pivot, sizeof o->pivot);
        memcpy(pose[i].axis, o->axis, sizeof o->axis);
        animation_point(o->count, o->at, o->translate, o->knot, x, pose[i].translate);
        pose[i].angle = animation_value(o->count, o->at, o->angle, x);
        pose[i].scale = animation_value(o->count, o->at, o->scale, x);
        pose[i].intensity = animation_value(o->count, o->at, o->intensity, x);
    }
}

uint64_t animation_motion_hash(const struct animation_path *path) {
    uint64_t hash = path->object_count ? FILEIO_HASH : 0;
    for (size_t i = 0; i < path->object_count; i++) {
        const struct animation_object *o = &path->object[i];
        hash = fileio_hash(hash, o->id, strlen(o->id) + 1);
        hash = fileio_hash(hash, o->pivot, sizeof o->pivot);
        hash = fileio_hash(hash, o->axis, sizeof o->axis);
        hash = fileio_hash(hash, &o->count, sizeof o->count);
        hash = fileio_hash(hash, o->at, o->count * sizeof *o->at);
        hash = fileio_hash(hash, o->translate, o->count * sizeof *o->translate);
        hash = fileio_hash(hash, o->angle, o->count * sizeof *o->angle);
        hash = fileio_hash(hash, o->scale, o->count * sizeof *o->scale);
        hash = fileio_hash(hash, o->intensity, o->count * sizeof *o->intensity);
    }
    return hash;
}
