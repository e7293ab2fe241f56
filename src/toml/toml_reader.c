// SPDX-License-Identifier: Apache-2.0
// Errors in what a file says, at the node that is wrong, and keys that a table may not have.
#include <string.h>

#include "base/text.h"
#include "toml/toml.h"

bool toml_wrong(struct toml_reader *r, const struct toml_node *node, const char *format, ...) {
    va_list args;
    va_start(args, format);
    log_error_at_args(r->log, node->at, node->key, format, args);
    va_end(args);
    if (r->status == SATIN_OK) r->status = SATIN_ERROR_INPUT;
    return false;
}

const struct toml_node *toml_find_unknown(const struct toml_node *table, const char *const *known,
                                          const char **meant) {
    for (size_t i = 0; i < table->count; i++) {
        struct text_nearest search = {.word = table->child[i].key};
        bool found = false;
        for (const char *const *k = known; *k && !found; k++) {
            found = strcmp(*k, search.word) == 0;
            text_nearest_try(&search, *k);
        }
        if (found) continue;
        *meant = search.best;
        return &table->child[i];
    }
    return NULL;
}

bool toml_unknown_key(struct toml_reader *r, const struct toml_node *unknown, const char *meant) {
    if (meant) return toml_wrong(r, unknown, "unknown key (did you mean '%s'?)", meant);
    return toml_wrong(r, unknown, "unknown key");
}
