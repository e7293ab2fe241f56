// SPDX-License-Identifier: Apache-2.0
// Private to animation/: values of a file in TOML. Each function that takes one returns false after
// it has logged an error, at the value or the table.
#ifndef ANIMATION_READER_H
#define ANIMATION_READER_H

#include "animation/animation.h"
#include "toml/toml.h"

bool animation_no_memory(struct toml_reader *r);  // false
// Checks that a table has no other keys than `known`, which ends with NULL.
bool animation_check_keys(struct toml_reader *r, const struct toml_node *table,
                          const char *const *known);
// The number of a frame.
bool animation_take_frame(struct toml_reader *r, const struct toml_node *node, double *out);
// Three coordinates. A key that is missing is an error, unless there is a default.
bool animation_take_vector(struct toml_reader *r, const struct toml_node *table, const char *key,
                           const double *otherwise, double out[3]);
// A number, which is `otherwise` if the key is missing.
bool animation_take_value(struct toml_reader *r, const struct toml_node *table, const char *key,
                          double otherwise, bool negative, double *out);

// ---- animation_object.c
// Takes the tables [[object]].
bool animation_take_objects(struct toml_reader *r, const struct toml_node *list,
                            struct animation_path *out);
void animation_objects_free(struct animation_path *path);

#endif
