// SPDX-License-Identifier: Apache-2.0
// Parameters of a scene file and their substitution, by Mitsuba 3's rules: the longest name wins,
// a value is not searched for further parameters, a backslash makes a dollar sign a plain one.
#include "scene/scene_define.h"

#include <string.h>

bool scene_define_add(struct scene_defines *defines, const char *name, const char *value,
                      bool given) {
    for (int i = 0; i < defines->count; i++)
        if (strcmp(defines->item[i].name, name) == 0) return true;
    if (defines->count == SCENE_DEFINE_MAX) return false;
    defines->item[defines->count++] = (struct scene_define){name, value, given, false};
    return true;
}

static struct scene_define *longest_match(struct scene_defines *defines, const char *text,
                                          size_t *length) {
    struct scene_define *best = NULL;
    *length = 0;
    for (int i = 0; i < defines->count; i++) {
        size_t n = strlen(defines->item[i].name);
        if (n <= *length || strncmp(defines->item[i].name, text, n) != 0) continue;
        best = &defines->item[i];
        *length = n;
    }
    return best;
}

// Appends to `buffer` unless it would overflow; *used only grows then.
static bool append(char *buffer, size_t *used, const char *text, size_t length) {
    if (length > SCENE_ATTRIBUTE_MAX - *used) return false;
    memcpy(buffer + *used, text, length);
    *used += length;
    return true;
}

satin_status scene_define_expand(struct scene_defines *defines, struct arena *arena,
                                 const char *text, const char **out, const char **problem) {
    char buffer[SCENE_ATTRIBUTE_MAX];
    size_t used = 0;
    *problem = NULL;
    while (*text) {
        size_t plain = strcspn(text, "\\$");
        if (plain == 0 && text[0] == '\\') {
            if (text[1] == '$') text++;
            plain = 1;
        }
        if (plain > 0) {
            if (!append(buffer, &used, text, plain)) return SATIN_ERROR_INPUT;
            text += plain;
            continue;
        }
        size_t length;
        struct scene_define *define = longest_match(defines, text + 1, &length);
        if (!define) {
            *problem = text;
            return SATIN_ERROR_INPUT;
        }
        define->used = true;
        if (!append(buffer, &used, define->value, strlen(define->value))) return SATIN_ERROR_INPUT;
        text += 1 + length;
    }
    char *copy = arena_text(arena, buffer, used);
    if (!copy) return SATIN_ERROR_MEMORY;
    *out = copy;
    return SATIN_OK;
}
