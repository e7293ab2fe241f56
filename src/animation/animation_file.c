// SPDX-License-Identifier: Apache-2.0
// Reads a camera path. Every error names the file, the line and the key.
#include <stdlib.h>
#include <string.h>

#include "animation/animation_reader.h"
#include "base/array.h"
#include "base/fileio.h"
#include "base/mat4.h"

enum {
    PATH_BYTES_MAX = 1 << 24,
    FRAMES_MAX = 100000  // of a path
};

// The keyframes, or the frames of a list.
struct path_keys {
    size_t count;
    double *at;  // numbers of the frames
    double (*origin)[3], (*target)[3];
    double *up[3];  // by coordinate
    double *fov;    // 0: none has one
    double *origin_knot, *target_knot;
    struct log_place *place;
};

struct path_reader {
    struct toml_reader reader;
    struct path_keys keys;
    struct animation_path *out;
};

// ---- Keyframes and lists ------------------------------------------------------------------------

#define FOV_MIN 1e-5  // of a view in degrees, as satin/animation.h has it

// The angle of view, which all frames have or none has.
static bool take_fov(struct path_reader *r, const struct toml_node *table, size_t i) {
    const struct toml_node *node = toml_find(table, "fov");
    const struct path_keys *keys = &r->keys;
    keys->fov[i] = 0.0;
    if (i > 0 && (keys->fov[0] > 0.0) != (node != NULL))
        return toml_wrong(&r->reader, node ? node : table,
                          "all of them need the key 'fov', or none");
    if (!node) return true;
    if (node->kind != TOML_NUMBER || !(node->number >= FOV_MIN && node->number < 180.0))
        return toml_wrong(&r->reader, node, "it must be an angle in [1e-05, 180) degrees");
    keys->fov[i] = node->number;
    return true;
}

static bool allocate_keys(struct path_keys *keys, size_t count) {
    keys->at = array_new(count, sizeof *keys->at);
    keys->origin = array_new(count, sizeof *keys->origin);
    keys->target = array_new(count, sizeof *keys->target);
    for (int k = 0; k < 3; k++) keys->up[k] = array_new(count, sizeof *keys->up[k]);
    keys->fov = array_new(count, sizeof *keys->fov);
    keys->origin_knot = array_new(count, sizeof *keys->origin_knot);
    keys->target_knot = array_new(count, sizeof *keys->target_knot);
    keys->place = array_new(count, sizeof *keys->place);
    return keys->at && keys->origin && keys->target && keys->up[0] && keys->up[1] && keys->up[2] &&
           keys->fov && keys->origin_knot && keys->target_knot && keys->place;
}

static void free_keys(struct path_keys *keys) {
    free(keys->at);
    free(keys->origin);
    free(keys->target);
    for (int k = 0; k < 3; k++) free(keys->up[k]);
    free(keys->fov);
    free(keys->origin_knot);
    free(keys->target_knot);
    free(keys->place);
}

// Takes entry i of the list, whose frame has this number.
static bool take_key(struct path_reader *r, const struct toml_node *table, size_t i) {
    static const double upwards[3] = {0.0, 1.0, 0.0};
    const struct path_keys *keys = &r->keys;
    double up[3];
    if (!animation_take_vector(&r->reader, table, "origin", NULL, keys->origin[i]) ||
        !animation_take_vector(&r->reader, table, "target", NULL, keys->target[i]) ||
        !animation_take_vector(&r->reader, table, "up", upwards, up) || !take_fov(r, table, i))
        return false;
    for (int k = 0; k < 3; k++) keys->up[k][i] = up[k];
    keys->place[i] = table->at;
    return true;
}

static bool take_keyframe(struct path_reader *r, const struct toml_node *table, size_t i) {
    static const char *const known[] = {"frame", "origin", "target", "up", "fov", NULL};
    const struct path_keys *keys = &r->keys;
    const struct toml_node *frame = toml_find(table, "frame");
    if (!animation_check_keys(&r->reader, table, known)) return false;
    if (!frame) return toml_wrong(&r->reader, table, "the keyframe needs the key 'frame'");
    if (!animation_take_frame(&r->reader, frame, &keys->at[i])) return false;
    if (i > 0 && !(keys->at[i] > keys->at[i - 1]))
        return toml_wrong(&r->reader, frame, "frame %.0f does not come after frame %.0f",
                          keys->at[i], keys->at[i - 1]);
    if (keys->at[i] - keys->at[0] >= FRAMES_MAX)
        return toml_wrong(&r->reader, frame, "a path has at most %d frames", FRAMES_MAX);
    return take_key(r, table, i);
}

static bool take_frame(struct path_reader *r, const struct toml_node *table, size_t i) {
    static const char *const known[] = {"origin", "target", "up", "fov", NULL};
    r->keys.at[i] = r->out->number + (double)i;
    return animation_check_keys(&r->reader, table, known) && take_key(r, table, i);
}

// ---- Views --------------------------------------------------------------------------------------

// Sets the views of all frames from the keyframes.
static bool make_views(struct path_reader *r) {
    const struct path_keys *keys = &r->keys;
    struct animation_path *out = r->out;
    out->number = (int)keys->at[0];
    out->count = (int)(keys->at[keys->count - 1] - keys->at[0]) + 1;
    out->view = array_new((size_t)out->count, sizeof *out->view);
    bool ok = out->view || animation_no_memory(&r->reader);
    animation_knots(keys->count, keys->origin, keys->origin_knot);
    animation_knots(keys->count, keys->target, keys->target_knot);
    size_t key = 0;  // the last keyframe up to the frame
    for (int i = 0; i < out->count && ok; i++) {
        const double at = out->number + i;
        satin_view *view = &out->view[i];
        while (key + 1 < keys->count && keys->at[key + 1] <= at) key++;
        animation_point(keys->count, keys->at, keys->origin, keys->origin_knot, at, view->origin);
        animation_point(keys->count, keys->at, keys->target, keys->target_knot, at, view->target);
        for (int k = 0; k < 3; k++)
            view->up[k] = animation_value(keys->count, keys->at, keys->up[k], at);
        view->fov = animation_value(keys->count, keys->at, keys->fov, at);
        struct mat4 to_world;
        if (mat4_look_at(v3_of_doubles(view->origin), v3_of_doubles(view->target),
                         v3_of_doubles(view->up), &to_world))
            continue;
        ok = false;
        r->reader.status = SATIN_ERROR_INPUT;
        log_error_at(r->reader.log, keys->place[key],
                     "frame %.0f has no view: origin and target coincide, or up is along the view",
                     at);
    }
    return ok;
}

static bool take_first(struct path_reader *r, const struct toml_node *root) {
    const struct toml_node *first = toml_find(root, "first");
    double number = 1.0;
    if (first && !animation_take_frame(&r->reader, first, &number)) return false;
    r->out->number = (int)number;
    return true;
}

// The list of keyframes or frames, its form checked.
static bool check_tables(struct path_reader *r, const struct toml_node *list) {
    bool tables = list->kind == TOML_ARRAY && list->count > 0;
    for (size_t i = 0; tables && i < list->count; i++) tables = list->child[i].kind == TOML_TABLE;
    if (!tables) return toml_wrong(&r->reader, list, "it must be written as [[%s]]", list->key);
    return list->count <= FRAMES_MAX ||
           toml_wrong(&r->reader, list, "a path has at most %d frames", FRAMES_MAX);
}

// Takes the keyframes, or the frames of a list.
static bool take_list(struct path_reader *r, const struct toml_node *list, bool keyframes) {
    if (!check_tables(r, list)) return false;
    r->keys.count = list->count;
    if (!allocate_keys(&r->keys, list->count)) return animation_no_memory(&r->reader);
    for (size_t i = 0; i < list->count; i++) {
        const struct toml_node *table = &list->child[i];
        if (!(keyframes ? take_keyframe(r, table, i) : take_frame(r, table, i))) return false;
    }
    return make_views(r);
}

static bool take_path(struct path_reader *r, const struct toml_node *root) {
    static const char *const known[] = {"keyframe", "frame", "sensors", "first", "object", NULL};
    const struct toml_node *keyframe = toml_find(root, "keyframe"),
                           *frame = toml_find(root, "frame"), *sensors = toml_find(root, "sensors"),
                           *first = toml_find(root, "first"), *object = toml_find(root, "object");
    if (!animation_check_keys(&r->reader, root, known)) return false;
    if (!keyframe + !frame + !sensors != 2)
        return toml_wrong(&r->reader, root,
                          "a camera path has either [[keyframe]], [[frame]] or sensors = true");
    if (keyframe && first)
        return toml_wrong(&r->reader, first, "the keyframes have the numbers of the frames");
    if (!take_first(r, root)) return false;
    if (object && !animation_take_objects(&r->reader, object, r->out)) return false;
    if (!sensors) return take_list(r, keyframe ? keyframe : frame, keyframe != NULL);
    r->out->sensors = true;
    return (sensors->kind == TOML_FLAG && strcmp(sensors->text, "on") == 0) ||
           toml_wrong(&r->reader, sensors, "it must be true");
}

satin_status animation_read(struct log log, const char *file, struct animation_path *out) {
    char *text = NULL;
    size_t size = 0;
    struct toml_node *root = NULL;
    *out = (struct animation_path){0};
    struct path_reader r = {.reader = {.log = log}, .out = out};
    satin_status status =
        fileio_read(log, (struct log_place){0}, file, PATH_BYTES_MAX, &text, &size);
    if (status == SATIN_OK) status = toml_parse(log, file, text, size, &root);
    if (status == SATIN_OK && !take_path(&r, root)) status = r.reader.status;
    if (status != SATIN_OK) animation_path_free(out);
    free_keys(&r.keys);
    toml_free(root);
    free(text);
    return status;
}

void animation_path_free(struct animation_path *path) {
    free(path->view);
    animation_objects_free(path);
    *path = (struct animation_path){0};
}
