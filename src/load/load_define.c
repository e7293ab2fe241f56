// SPDX-License-Identifier: Apache-2.0
// Parameters of a scene file and their substitution, by Mitsuba 3's rules: the longest matching
// name is used, values are not searched for further parameters, and a backslash before a dollar
// sign makes it literal.
#include "load/load_define.h"

#include <string.h>

bool load_define_add(struct load_defines *defines, const char *name, const char *value,
                     bool given) {
    for (int i = 0; i < defines->count; i++)
        if (strcmp(defines->item[i].name, name) == 0) return true;
    if (defines->count == LOAD_DEFINE_MAX) return false;
    defines->item[defines->count++] = (struct load_define){name, value, given, false};
    return true;
}

static struct load_define *longest_match(struct load_defines *defines, const char *text,
                                         size_t *length) {
    struct load_define *best = NULL;
    *length = 0;
    for (int i = 0; i < defines->count; i++) {
        size_t n = strlen(defines->item[i].name);
        if (n <= *length || strncmp(defines->item[i].name, text, n) != 0) continue;
        best = &defines->item[i];
        *length = n;
    }
    return best;
}

// Appends to `buffer`. If that would overflow, only *used grows.
static bool append_text(char *buffer, size_t *used, const char *text, size_t length) {
    if (length > LOAD_ATTRIBUTE_MAX - *used) return false;
    memcpy(buffer + *used, text, length);
    *used += length;
    return true;
}

satin_status load_define_expand(struct load_defines *defines, struct arena *arena, const char *text,
                                const char **out, const char **problem) {
    char buffer[LOAD_ATTRIBUTE_MAX];
    size_t used = 0;
    *problem = NULL;
    while (*text) {
        size_t plain = strcspn(text, "\\$");
        if (plain == 0 && text[0] == '\\') {
            if (text[1] == '$') text++;
            plain = 1;
        }
        if (plain > 0) {
            if (!append_text(buffer, &used, text, plain)) return SATIN_ERROR_INPUT;
            text += plain;
            continue;
        }
        size_t length;
        struct load_define *define = longest_match(defines, text + 1, &length);
        if (!define) {
            *problem = text;
            return SATIN_ERROR_INPUT;
        }
        define->used = true;
        if (!append_text(buffer, &used, define->value, strlen(define->value)))
            return SATIN_ERROR_INPUT;
        text += 1 + length;
    }
    char *copy = arena_text(arena, buffer, used);
    if (!copy) return SATIN_ERROR_MEMORY;
    *out = copy;
    return SATIN_OK;
}
