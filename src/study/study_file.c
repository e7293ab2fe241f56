// SPDX-License-Identifier: Apache-2.0
// Reads the file of a study: scenes, reference, seeds and options. Every error names the file, the
// line and the key.
#include "study/study_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/text.h"

enum { FILE_BYTES_MAX = 1 << 20, SEEDS_MAX = 1000, PIECES_MAX = 1000, NAME_BYTES_MAX = 100 };
// Independent images of a reference, unless the file has another number. Their variance estimates
// that of their mean; with 8 of them its relative error is a half per pixel, and far less in the
// sum over an image.
enum { PIECES_DEFAULT = 8, PIECES_SPPM = 2, SEEDS_DEFAULT = 4 };

// ---- Errors -------------------------------------------------------------------------------------

static void fail_without_memory(struct toml_reader *r) {
    if (r->status == SATIN_OK)
        r->status = log_fail(r->log, SATIN_ERROR_MEMORY, "not enough memory for the study");
}

void *study_array(struct study_reader *r, size_t count, size_t size) {
    void *made = arena_array(&r->out->arena, count, size);
    if (!made) fail_without_memory(&r->toml);
    return made;
}

bool study_is(struct study_reader *r, const struct toml_node *node, enum toml_kind kind,
              const char *expected) {
    return node->kind == kind || toml_wrong(&r->toml, node, "it must be %s", expected);
}

bool study_keys_known(struct study_reader *r, const struct toml_node *table,
                      const char *const *known) {
    const char *meant;
    const struct toml_node *unknown = toml_find_unknown(table, known, &meant);
    if (!unknown) return true;
    satin_option_info info;
    for (int k = 0; satin_options_describe(&satin_options_default, k, &info); k++)
        if (text_same_name(info.name, unknown->key))
            return toml_wrong(&r->toml, unknown,
                              "unknown key; options of renders stand in [set] or [vary]");
    return toml_unknown_key(&r->toml, unknown, meant);
}

// ---- Options ------------------------------------------------------------------------------------

struct option_error {
    struct study_reader *reader;
    const struct toml_node *node;
};

static void log_option_error(void *user, satin_log_severity severity, const char *message) {
    struct option_error *error = user;
    if (severity == SATIN_LOG_ERROR) toml_wrong(&error->reader->toml, error->node, "%s", message);
}

// Whether an option may be set where it stands.
static bool is_allowed(struct study_reader *r, const struct toml_node *node, bool varies) {
    static const char *const truth[] = {"width",         "height",      "max-depth",
                                        "hide-emitters", "crop-x",      "crop-y",
                                        "crop-width",    "crop-height", NULL};
    if (text_same_name(node->key, "seed"))
        return toml_wrong(&r->toml, node, "the key 'seeds' of the study chooses the seeds");
    if (text_same_name(node->key, "layers"))
        return toml_wrong(&r->toml, node,
                          "a study compares the whole light, and needs its own layers");
    if (varies && text_is_one_of(node->key, truth))
        return toml_wrong(&r->toml, node,
                          "it cannot vary, because it changes the true image and a scene has one "
                          "reference; it may stand in [set]");
    return true;
}

bool study_is_option_value(struct study_reader *r, const struct toml_node *node, const char *name) {
    satin_options scratch = satin_options_default;
    struct option_error error = {r, node};
    if (!node->text) return toml_wrong(&r->toml, node, "it must be one value");
    return satin_options_set(&scratch, name, node->text, log_option_error, &error) == SATIN_OK;
}

bool study_take_option(struct study_reader *r, const struct toml_node *node, bool varies,
                       struct study_settings *out) {
    if (!is_allowed(r, node, varies) || !study_is_option_value(r, node, node->key)) return false;
    out->setting[out->count++] = (struct study_setting){node->key, node->text, node->at};
    return true;
}

bool study_take_options(struct study_reader *r, const struct toml_node *table, bool varies,
                        struct study_settings *out) {
    if (!study_is(r, table, TOML_TABLE, "a table of options")) return false;
    out->setting = study_array(r, table->count, sizeof *out->setting);
    if (!out->setting) return false;
    for (size_t i = 0; i < table->count; i++)
        if (!study_take_option(r, &table->child[i], varies, out)) return false;
    return true;
}

// ---- Scenes -------------------------------------------------------------------------------------

static const char *path_beside(struct study_reader *r, const struct toml_node *node) {
    char *path = fileio_beside(node->at.file, node->text);
    char *copy = path ? arena_text(&r->out->arena, path, strlen(path)) : NULL;
    free(path);
    if (!copy) fail_without_memory(&r->toml);
    return copy;
}

// The name of a scene: that of its file or, if it is scene.xml, that of its folder.
static const char *name_of_scene(struct study_reader *r, const char *path) {
    const char *end = path + strlen(path), *slash = strrchr(path, '/');
    const char *begin = slash ? slash + 1 : path;
    if (strcmp(begin, "scene.xml") == 0 && slash && slash > path) {
        end = slash;
        for (begin = slash; begin > path && begin[-1] != '/';) begin--;
    } else if (end - begin > 4 && strcmp(end - 4, ".xml") == 0) {
        end -= 4;
    }
    return arena_text(&r->out->arena, begin, (size_t)(end - begin));
}

static bool take_defines(struct study_reader *r, const struct toml_node *table,
                         struct study_scene *out) {
    if (!study_is(r, table, TOML_TABLE, "a table of names and values")) return false;
    out->define = study_array(r, table->count, sizeof *out->define);
    out->define_at = study_array(r, table->count, sizeof *out->define_at);
    if (!out->define || !out->define_at) return false;
    for (size_t i = 0; i < table->count; i++) {
        const struct toml_node *child = &table->child[i];
        if (!child->text) return toml_wrong(&r->toml, child, "it must be one value");
        const bool flag = child->kind == TOML_FLAG;
        const char *value = !flag ? child->text : child->text[1] == 'n' ? "true" : "false";
        out->define_at[out->defines] = child->at;
        out->define[out->defines++] = (satin_define){child->key, value};
    }
    return true;
}

// Whether files can be called after a scene.
static bool is_file_name(const char *name) {
    for (const char *c = name; *c; c++)
        if (*c == '/' || (unsigned char)*c < ' ') return false;
    return *name && *name != '.' && strlen(name) <= NAME_BYTES_MAX;
}

// `name` is NULL if the file of the study gives the scene none.
static bool add_scene(struct study_reader *r, const struct toml_node *file,
                      const struct toml_node *name) {
    struct study *s = r->out;
    const struct toml_node *named = name ? name : file;
    if (!study_is(r, file, TOML_TEXT, "the name of a scene's file")) return false;
    struct study_scene *scene = &s->scene[s->scenes];
    *scene = (struct study_scene){.path = path_beside(r, file), .at = file->at};
    if (!scene->path) return false;
    scene->name = name ? name->text : name_of_scene(r, scene->path);
    if (!scene->name) {
        fail_without_memory(&r->toml);
        return false;
    }
    if (!is_file_name(scene->name))
        return toml_wrong(&r->toml, named,
                          "a scene's name has 1 to %d bytes, does not begin with a dot, and has "
                          "no slash and no line end",
                          NAME_BYTES_MAX);
    for (size_t i = 0; i < s->scenes; i++)
        if (strcmp(s->scene[i].name, scene->name) == 0)
            return toml_wrong(&r->toml, named,
                              "two scenes are called '%s'; give them names in [[scene]]",
                              scene->name);
    s->scenes++;
    return true;
}

static bool add_scene_table(struct study_reader *r, const struct toml_node *table) {
    static const char *const known[] = {"file", "name", "sensor", "reference", "define", NULL};
    if (!study_is(r, table, TOML_TABLE, "a table [[scene]]")) return false;
    if (!study_keys_known(r, table, known)) return false;
    const struct toml_node *file = toml_find(table, "file"), *name = toml_find(table, "name");
    const struct toml_node *sensor = toml_find(table, "sensor");
    const struct toml_node *reference = toml_find(table, "reference");
    const struct toml_node *define = toml_find(table, "define");
    if (!file) return toml_wrong(&r->toml, table, "the scene needs a key 'file'");
    if (name && !study_is(r, name, TOML_TEXT, "a text")) return false;
    if (!add_scene(r, file, name)) return false;
    struct study_scene *scene = &r->out->scene[r->out->scenes - 1];
    if (sensor) {
        if (sensor->kind != TOML_NUMBER &&
            !study_is(r, sensor, TOML_TEXT, "a sensor's id or index"))
            return false;
        scene->sensor = sensor->text;
    }
    if (reference) {
        if (!study_is(r, reference, TOML_TEXT, "the name of an image")) return false;
        scene->reference = path_beside(r, reference);
        if (!scene->reference) return false;
    }
    return !define || take_defines(r, define, scene);
}

static bool take_scenes(struct study_reader *r) {
    const struct toml_node *root = r->out->root;
    const struct toml_node *list = toml_find(root, "scenes"), *table = toml_find(root, "scene");
    if (list && !study_is(r, list, TOML_ARRAY, "a list of files")) return false;
    if (table && !study_is(r, table, TOML_ARRAY, "written as [[scene]]")) return false;
    const size_t count = (list ? list->count : 0) + (table ? table->count : 0);
    if (count == 0)
        return toml_wrong(&r->toml, list ? list : root, "the study needs scenes = [\"...\"]");
    r->out->scene = study_array(r, count, sizeof *r->out->scene);
    if (!r->out->scene) return false;
    for (size_t i = 0; list && i < list->count; i++)
        if (!add_scene(r, &list->child[i], NULL)) return false;
    for (size_t i = 0; table && i < table->count; i++)
        if (!add_scene_table(r, &table->child[i])) return false;
    return true;
}

// ---- Seeds and reference ------------------------------------------------------------------------

// A whole number in a range.
static bool take_count(struct study_reader *r, const struct toml_node *node, double least,
                       double most, uint64_t *out) {
    if (!study_is(r, node, TOML_NUMBER, "a number")) return false;
    if (!(node->number >= least && node->number <= most) || node->number != floor(node->number))
        return toml_wrong(&r->toml, node, "%s is not a whole number in %.0f..%.0f", node->text,
                          least, most);
    *out = (uint64_t)node->number;
    return true;
}

// A number of seeds, which are then 1, 2, ..., or a list of them.
static bool take_seeds(struct study_reader *r, const struct toml_node *node) {
    struct study *s = r->out;
    const bool list = node && node->kind == TOML_ARRAY;
    uint64_t count = SEEDS_DEFAULT;
    if (list) count = node->count;
    if (node && !list && !take_count(r, node, 1, SEEDS_MAX, &count)) return false;
    if (count < 1 || count > SEEDS_MAX)
        return toml_wrong(&r->toml, node, "it must have 1 to %d seeds", SEEDS_MAX);
    s->seed = study_array(r, count, sizeof *s->seed);
    if (!s->seed) return false;
    for (; s->seeds < count; s->seeds++) {
        uint64_t *seed = &s->seed[s->seeds];
        *seed = s->seeds + 1;
        if (list && !take_count(r, &node->child[s->seeds], 0, 9e15, seed)) return false;
        for (size_t i = 0; i < s->seeds; i++)
            if (s->seed[i] == *seed)
                return toml_wrong(&r->toml, node, "the seed %llu is there twice",
                                  (unsigned long long)*seed);
    }
    return true;
}

static bool all_have_references(const struct study *s) {
    for (size_t i = 0; i < s->scenes; i++)
        if (!s->scene[i].reference) return false;
    return true;
}

// The number of pieces of a reference with these settings, which may be NULL. Each piece of
// integrator sppm has a bias of its own, which falls with its passes.
static uint64_t usual_pieces(const struct toml_node *set) {
    const struct toml_node *integrator = set ? toml_find(set, "integrator") : NULL;
    const bool sppm =
        integrator && integrator->kind == TOML_TEXT && strcmp(integrator->text, "sppm") == 0;
    return sppm ? PIECES_SPPM : PIECES_DEFAULT;
}

static bool take_reference(struct study_reader *r, const struct toml_node *table) {
    static const char *const known[] = {"spp", "pieces", "set", NULL};
    struct study *s = r->out;
    if (!table && all_have_references(s)) return true;
    if (!table)
        return toml_wrong(&r->toml, s->root,
                          "the study needs a reference: reference.spp = 1024, or a reference in "
                          "every [[scene]]");
    if (!study_is(r, table, TOML_TABLE, "a table with spp") || !study_keys_known(r, table, known))
        return false;
    const struct toml_node *spp = toml_find(table, "spp"), *pieces = toml_find(table, "pieces");
    const struct toml_node *set = toml_find(table, "set");
    uint64_t count = usual_pieces(set);
    if (!spp) return toml_wrong(&r->toml, table, "it needs the key 'spp'");
    if (!take_count(r, spp, 2, 1e9, &s->reference_spp)) return false;
    if (pieces && !take_count(r, pieces, 2, PIECES_MAX, &count)) return false;
    if (pieces && count > s->reference_spp)
        return toml_wrong(&r->toml, pieces, "each piece needs a sample, and spp is %llu",
                          (unsigned long long)s->reference_spp);
    if (count > s->reference_spp) count = s->reference_spp;
    s->reference_pieces = count;
    for (size_t i = 0; set && i < set->count; i++)
        if (set->child[i].key && text_same_name(set->child[i].key, "spp"))
            return toml_wrong(&r->toml, &set->child[i],
                              "the key 'spp' of the reference has its number of samples");
    return !set || study_take_options(r, set, true, &s->reference);
}

// ---- The whole ----------------------------------------------------------------------------------

static bool take_text(struct study_reader *r, const char *key, const char **out) {
    const struct toml_node *node = toml_find(r->out->root, key);
    if (!node) return true;
    if (!study_is(r, node, TOML_TEXT, "a text")) return false;
    *out = node->text;
    return true;
}

static bool take_boolean(struct study_reader *r, const char *key, bool *out) {
    const struct toml_node *node = toml_find(r->out->root, key);
    if (!node) return true;
    if (!study_is(r, node, TOML_FLAG, "true or false")) return false;
    *out = node->text[1] == 'n';
    return true;
}

static bool take_all(struct study_reader *r) {
    static const char *const known[] = {
        "title", "question",      "scenes",          "scene",         "reference",
        "seeds", "equal-samples", "equal-time",      "set",           "vary",
        "point", "mask-emission", "first-pass-view", "picture-width", NULL};
    struct study *s = r->out;
    uint64_t width = 0;
    const struct toml_node *root = s->root, *set = toml_find(root, "set");
    const struct toml_node *vary = toml_find(root, "vary"), *point = toml_find(root, "point");
    const struct toml_node *picture = toml_find(root, "picture-width");
    if (!study_keys_known(r, root, known)) return false;
    if (!take_text(r, "title", &s->title) || !take_text(r, "question", &s->question)) return false;
    if (!take_boolean(r, "mask-emission", &s->mask_emission)) return false;
    if (!take_boolean(r, "first-pass-view", &s->first_pass_view)) return false;
    if (picture && !take_count(r, picture, 16, 4096, &width)) return false;
    s->picture_width = (int)width;
    if (!take_scenes(r) || !take_seeds(r, toml_find(root, "seeds"))) return false;
    if (!take_reference(r, toml_find(root, "reference"))) return false;
    if (set && !study_take_options(r, set, false, &s->set)) return false;
    if (vary && !study_take_vary(r, vary)) return false;
    if (point && !study_take_points(r, point)) return false;
    return study_finish_points(r, root);
}

satin_status study_file_read(struct log log, const char *path, struct study *out) {
    char *text = NULL;
    size_t size = 0;
    *out = (struct study){.mask_emission = true, .first_pass_view = true};
    struct study_reader r = {.toml = {.log = log}, .out = out};
    r.toml.status = fileio_read(log, (struct log_place){0}, path, FILE_BYTES_MAX, &text, &size);
    if (r.toml.status == SATIN_OK) {
        out->hash = fileio_hash(FILEIO_HASH, text, size);
        r.toml.status = toml_parse(log, path, text, size, &out->root);
    }
    free(text);
    if (r.toml.status == SATIN_OK) take_all(&r);
    return r.toml.status;
}

void study_file_free(struct study *study) {
    toml_free(study->root);
    arena_free(&study->arena);
    *study = (struct study){0};
}
