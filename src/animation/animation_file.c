// SPDX-License-Identifier: Apache-2.0
// Reads a camera path. Every error names the file, the line and the key.
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "animation/animation.h"
#include "base/array.h"
#include "base/fileio.h"
#include "base/mat4.h"
#include "base/text.h"
#include "toml/toml.h"

enum {
    PATH_BYTES_MAX = 1 << 24,
    FRAMES_MAX = 100000,  // of a path
    NUMBER_MAX = 999999   // of a frame
};
// Coordinates beyond this are not passed to the ray tracer either.
static const double COORDINATE_MAX = 1e18;

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
    struct log log;
    struct path_keys keys;
    struct animation_path *out;
    satin_status status;  // of the first failure, which is logged
};

// ---- Values -------------------------------------------------------------------------------------

__attribute__((format(printf, 3, 4))) static bool path_wrong(struct path_reader *r,
                                                             const struct toml_node *node,
                                                             const char *format, ...) {
    char text[256];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    log_error_at(r->log, node->at, "%s%s%s", node->key ? node->key : "", node->key ? ": " : "",
                 text);
    r->status = SATIN_ERROR_INPUT;
    return false;
}

static bool path_no_memory(struct path_reader *r) {
    r->status = log_fail(r->log, SATIN_ERROR_MEMORY, "not enough memory for the camera path");
    return false;
}

static bool check_keys(struct path_reader *r, const struct toml_node *table,
                       const char *const *known) {
    const char *meant;
    const struct toml_node *unknown = toml_find_unknown(table, known, &meant);
    if (!unknown) return true;
    if (meant) return path_wrong(r, unknown, "unknown key (did you mean '%s'?)", meant);
    return path_wrong(r, unknown, "unknown key");
}

// The number of a frame.
static bool take_number(struct path_reader *r, const struct toml_node *node, double *out) {
    if (node->kind != TOML_NUMBER) return path_wrong(r, node, "it must be a number");
    if (!(node->number >= 0.0 && node->number <= NUMBER_MAX) || node->number != floor(node->number))
        return path_wrong(r, node, "%s is not a whole number in 0..%d", node->text, NUMBER_MAX);
    *out = node->number;
    return true;
}

// Three coordinates. A key that is missing is an error, unless there is a default.
static bool take_vector(struct path_reader *r, const struct toml_node *table, const char *key,
                        const double *otherwise, double out[3]) {
    const struct toml_node *node = toml_find(table, key);
    if (!node && !otherwise) return path_wrong(r, table, "it needs the key '%s'", key);
    for (int k = 0; k < 3 && !node; k++) out[k] = otherwise[k];
    if (!node) return true;
    if (node->kind != TOML_ARRAY || node->count != 3)
        return path_wrong(r, node, "it must be three numbers, as in [0, 1, 0]");
    for (size_t k = 0; k < 3; k++) {
        const struct toml_node *number = &node->child[k];
        if (number->kind != TOML_NUMBER) return path_wrong(r, number, "it must be a number");
        if (!(fabs(number->number) <= COORDINATE_MAX))
            return path_wrong(r, number, "%s is too large", number->text);
        out[k] = number->number;
    }
    return true;
}

// The angle of view, which all frames have or none has.
static bool take_fov(struct path_reader *r, const struct toml_node *table, size_t i) {
    const struct toml_node *node = toml_find(table, "fov");
    const struct path_keys *keys = &r->keys;
    keys->fov[i] = 0.0;
    if (i > 0 && (keys->fov[0] > 0.0) != (node != NULL))
        return path_wrong(r, node ? node : table, "all of them need the key 'fov', or none");
    if (!node) return true;
    if (node->kind != TOML_NUMBER || !(node->number > 0.0 && node->number < 180.0))
        return path_wrong(r, node, "it must be an angle between 0 and 180 degrees");
    keys->fov[i] = node->number;
    return true;
}

// ---- Keyframes and lists ------------------------------------------------------------------------

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
    if (!take_vector(r, table, "origin", NULL, keys->origin[i]) ||
        !take_vector(r, table, "target", NULL, keys->target[i]) ||
        !take_vector(r, table, "up", upwards, up) || !take_fov(r, table, i))
        return false;
    for (int k = 0; k < 3; k++) keys->up[k][i] = up[k];
    keys->place[i] = table->at;
    return true;
}

static bool take_keyframe(struct path_reader *r, const struct toml_node *table, size_t i) {
    static const char *const known[] = {"frame", "origin", "target", "up", "fov", NULL};
    const struct path_keys *keys = &r->keys;
    const struct toml_node *frame = toml_find(table, "frame");
    if (!check_keys(r, table, known)) return false;
    if (!frame) return path_wrong(r, table, "the keyframe needs the key 'frame'");
    if (!take_number(r, frame, &keys->at[i])) return false;
    if (i > 0 && !(keys->at[i] > keys->at[i - 1]))
        return path_wrong(r, frame, "frame %.0f does not come after frame %.0f", keys->at[i],
                          keys->at[i - 1]);
    if (keys->at[i] - keys->at[0] >= FRAMES_MAX)
        return path_wrong(r, frame, "a path has at most %d frames", FRAMES_MAX);
    return take_key(r, table, i);
}

static bool take_frame(struct path_reader *r, const struct toml_node *table, size_t i) {
    static const char *const known[] = {"origin", "target", "up", "fov", NULL};
    r->keys.at[i] = r->out->number + (double)i;
    return check_keys(r, table, known) && take_key(r, table, i);
}

// ---- Views --------------------------------------------------------------------------------------

static vec3 vector_of(const double v[3]) { return v3((float)v[0], (float)v[1], (float)v[2]); }

// Sets the views of all frames from the keyframes.
static bool make_views(struct path_reader *r) {
    const struct path_keys *keys = &r->keys;
    struct animation_path *out = r->out;
    out->number = (int)keys->at[0];
    out->count = (int)(keys->at[keys->count - 1] - keys->at[0]) + 1;
    out->view = array_new((size_t)out->count, sizeof *out->view);
    bool ok = out->view || path_no_memory(r);
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
        if (mat4_look_at(vector_of(view->origin), vector_of(view->target), vector_of(view->up),
                         &to_world))
            continue;
        ok = false;
        r->status = SATIN_ERROR_INPUT;
        log_error_at(r->log, keys->place[key],
                     "frame %.0f has no view: origin and target coincide, or up is along the view",
                     at);
    }
    return ok;
}

static bool take_first(struct path_reader *r, const struct toml_node *root) {
    const struct toml_node *first = toml_find(root, "first");
    double number = 1.0;
    if (first && !take_number(r, first, &number)) return false;
    r->out->number = (int)number;
    return true;
}

// The list of keyframes or frames, its form checked.
static bool check_tables(struct path_reader *r, const struct toml_node *list) {
    bool tables = list->kind == TOML_ARRAY && list->count > 0;
    for (size_t i = 0; tables && i < list->count; i++) tables = list->child[i].kind == TOML_TABLE;
    if (!tables) return path_wrong(r, list, "it must be written as [[%s]]", list->key);
    return list->count <= FRAMES_MAX ||
           path_wrong(r, list, "a path has at most %d frames", FRAMES_MAX);
}

// Takes the keyframes, or the frames of a list.
static bool take_list(struct path_reader *r, const struct toml_node *list, bool keyframes) {
    if (!check_tables(r, list)) return false;
    r->keys.count = list->count;
    if (!allocate_keys(&r->keys, list->count)) return path_no_memory(r);
    for (size_t i = 0; i < list->count; i++) {
        const struct toml_node *table = &list->child[i];
        if (!(keyframes ? take_keyframe(r, table, i) : take_frame(r, table, i))) return false;
    }
    return make_views(r);
}

static bool take_path(struct path_reader *r, const struct toml_node *root) {
    static const char *const known[] = {"keyframe", "frame", "sensors", "first", NULL};
    const struct toml_node *keyframe = toml_find(root, "keyframe"),
                           *frame = toml_find(root, "frame"), *sensors = toml_find(root, "sensors"),
                           *first = toml_find(root, "first");
    if (!check_keys(r, root, known)) return false;
    if (!keyframe + !frame + !sensors != 2)
        return path_wrong(r, root,
                          "a camera path has either [[keyframe]], [[frame]] or sensors = true");
    if (keyframe && first)
        return path_wrong(r, first, "the keyframes have the numbers of the frames");
    if (!take_first(r, root)) return false;
    if (!sensors) return take_list(r, keyframe ? keyframe : frame, keyframe != NULL);
    r->out->sensors = true;
    return (sensors->kind == TOML_FLAG && strcmp(sensors->text, "on") == 0) ||
           path_wrong(r, sensors, "it must be true");
}

satin_status animation_read(struct log log, const char *file, struct animation_path *out) {
    char *text = NULL;
    size_t size = 0;
    struct toml_node *root = NULL;
    *out = (struct animation_path){0};
    struct path_reader r = {.log = log, .out = out};
    satin_status status =
        fileio_read(log, (struct log_place){0}, file, PATH_BYTES_MAX, &text, &size);
    if (status == SATIN_OK) status = toml_parse(log, file, text, size, &root);
    if (status == SATIN_OK && !take_path(&r, root)) status = r.status;
    if (status != SATIN_OK) animation_path_free(out);
    free_keys(&r.keys);
    toml_free(root);
    free(text);
    return status;
}

void animation_path_free(struct animation_path *path) {
    free(path->view);
    *path = (struct animation_path){0};
}
