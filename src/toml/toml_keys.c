// SPDX-License-Identifier: Apache-2.0
// Keys that a table may not have.
#include <string.h>

#include "base/text.h"
#include "toml/toml.h"

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
