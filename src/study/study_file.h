// SPDX-License-Identifier: Apache-2.0
// Private to study/: what a study's file says. All texts and arrays are in the study's arena, or in
// the tree of the file.
#ifndef STUDY_FILE_H
#define STUDY_FILE_H

#include "base/arena.h"
#include "satin/options.h"
#include "satin/scene.h"
#include "toml/toml.h"

// An option by name, and where the file sets it; without a file, the study itself does.
struct study_setting {
    const char *name, *value;
    struct log_place at;
};

// Options that are set in order.
struct study_settings {
    struct study_setting *setting;
    size_t count;
};

struct study_scene {
    const char *name, *path;
    const char *sensor;     // its id, or its index from 0; NULL: the first one
    const char *reference;  // path of an image, or NULL: one is rendered
    satin_define *define;
    struct log_place *define_at;  // of each
    size_t defines;
    struct log_place at;
    uint64_t hash;  // of everything that the scene is read from; set when the study is planned
};

// A value of an axis: of one option, or of several that change together.
struct study_value {
    const char *label;
    struct study_settings set;
};

struct study_axis {
    size_t column;
    struct study_value *value;
    size_t count;
};

// What is varied: an option, or a name that the file gives to several options, with the values of
// the axis that has it.
struct study_column {
    const char *name;
    bool is_option;
    const struct study_value *value;
    size_t values;
};

// A combination of options. cell[i] is what the tables say of column i, or NULL until the study is
// planned.
struct study_point {
    const char *name;  // or NULL
    const char **cell;
    struct study_settings set;
    struct log_place at;
};

struct study {
    struct arena arena;
    struct toml_node *root;
    uint64_t hash;  // of the file

    const char *title, *question;
    struct study_scene *scene;
    size_t scenes;
    uint64_t *seed;
    size_t seeds;
    struct study_settings set;  // of every point
    struct study_column *column;
    size_t columns, column_capacity;
    struct study_point *point;
    size_t points, point_capacity;

    // The reference that is rendered: `pieces` images of independent seeds, with so many samples
    // per pixel together.
    struct study_settings reference;
    uint64_t reference_spp;
    size_t reference_pieces;

    bool mask_emission;
    bool first_pass_view;  // whether the first pass is rendered directly too
    int picture_width;     // of pictures in the page, or 0: by their number
};

// The largest number of renders of a study.
enum { STUDY_RENDERS_MAX = 100000 };

// Reads the file. SATIN_ERROR_INPUT, logged as file:line:column with the key, if it is wrong;
// SATIN_ERROR_MEMORY, logged. study_file_free must follow in any case; `path` must stay valid until
// then.
satin_status study_file_read(struct log log, const char *path, struct study *out);
void study_file_free(struct study *study);

// ---- Columns of study.csv (study_columns.c) -----------------------------------------------------

// Names, ended by NULL: before those of what varies; after them; and the last ones, between which
// and the former are the seconds of stages.
extern const char *const study_columns_before[], *const study_columns_after[],
                                                     *const study_columns_last[];
// Whether every study.csv has a column of that name, so that nothing else may have it.
bool study_columns_have(const char *name);

// ---- Reading (study_axes.c reads what varies) ---------------------------------------------------

struct study_reader {
    struct toml_reader toml;
    struct study *out;
};

// The array of `count` zeroed elements from the arena, or NULL with the status set.
void *study_array(struct study_reader *r, size_t count, size_t size);
// Whether a node is of that kind; if not, `expected` is logged.
bool study_is(struct study_reader *r, const struct toml_node *node, enum toml_kind kind,
              const char *expected);
// Whether all keys of a table are among `known`, which NULL ends.
bool study_keys_known(struct study_reader *r, const struct toml_node *table,
                      const char *const *known);
// Whether a node is a value of that option; errors name the node.
bool study_is_option_value(struct study_reader *r, const struct toml_node *node, const char *name);
// Checks an option and its value, and appends it; `out` has space for it. An option that varies
// must not change what the true image is.
bool study_take_option(struct study_reader *r, const struct toml_node *node, bool varies,
                       struct study_settings *out);
// Reads all options of a table.
bool study_take_options(struct study_reader *r, const struct toml_node *table, bool varies,
                        struct study_settings *out);
// Read [vary] or [[vary]], and [[point]].
bool study_take_vary(struct study_reader *r, const struct toml_node *node);
bool study_take_points(struct study_reader *r, const struct toml_node *node);
// Makes one point if there is none, and gives all points equal samples or an equal time.
bool study_finish_points(struct study_reader *r, const struct toml_node *root);

#endif
