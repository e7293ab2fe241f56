// SPDX-License-Identifier: Apache-2.0
// A TOML file as a tree of plain structs, for the files that the command reads: studies and camera
// paths.
#ifndef TOML_TOML_H
#define TOML_TOML_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/log.h"

enum toml_kind { TOML_TABLE, TOML_ARRAY, TOML_TEXT, TOML_NUMBER, TOML_FLAG, TOML_OTHER };

// A table, an array or a value. The children of a table have keys and are in the order of the file.
struct toml_node {
    enum toml_kind kind;
    char *key;            // NULL in an array
    char *text;           // a value as text: numbers with all their digits, flags as on or off
    double number;        // of a number
    struct log_place at;  // of a key if it has one, else of the value
    struct toml_node *child;
    size_t count;
};

// Parses `size` bytes. SATIN_ERROR_INPUT, logged with the line, if they are not TOML, if a key has
// more than 64 dots or if brackets are nested deeper than 64; SATIN_ERROR_MEMORY, logged. The
// caller frees *root with toml_free. `path` must stay valid as long as the tree.
satin_status toml_parse(struct log log, const char *path, const char *text, size_t size,
                        struct toml_node **root);
void toml_free(struct toml_node *root);  // NULL is allowed

// The child of a table with that key, or NULL.
const struct toml_node *toml_find(const struct toml_node *table, const char *key);
// The first child of a table whose key is none of `known`, which ends with NULL; NULL: there is
// none. *meant is set to the known key of which it may be a slip, or NULL.
const struct toml_node *toml_find_unknown(const struct toml_node *table, const char *const *known,
                                          const char **meant);

// ---- Errors in what a file says (toml_reader.c) -------------------------------------------------

struct toml_reader {
    struct log log;
    satin_status status;  // of the first error
};

// Logs `file:line:column: KEY: ...`, without the key if the node has none, and returns false.
bool toml_wrong(struct toml_reader *r, const struct toml_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// Logs what toml_find_unknown has found, and returns false.
bool toml_unknown_key(struct toml_reader *r, const struct toml_node *unknown, const char *meant);

#endif
