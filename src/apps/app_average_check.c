// SPDX-License-Identifier: Apache-2.0
// satin average: whether images are independent renders of one image, by what their headers say of
// scene, seed and options.
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app_average_check.h"
#include "base/text.h"
#include "satin/options.h"

// The value of a word `name=value` in the text of options, of *length bytes; NULL if there is none.
static const char *option_value(const char *options, const char *name, size_t *length) {
    const size_t n = strlen(name);
    for (const char *at = options; *at; at += strspn(at, " ")) {
        const size_t word = strcspn(at, " ");
        if (word > n && strncmp(at, name, n) == 0 && at[n] == '=') {
            *length = word - n - 1;
            return at + n + 1;
        }
        at += word;
    }
    return NULL;
}

static bool is_same(const char *a, const char *b, const char *name) {
    size_t m, n;
    const char *one = option_value(a, name, &m), *two = option_value(b, name, &n);
    if (!one || !two) return true;
    return m == n && memcmp(one, two, n) == 0;
}

static bool has_limit(const char *options) {
    size_t n;
    const char *time = option_value(options, "time", &n);
    return time && strtod(time, NULL) > 0.0;
}

// The first option by which the images are not renders of one image. False if there is none. What a
// time limit decides itself may differ, and pixels and channels are compared elsewhere.
static bool differing_option(const char *a, const char *b, satin_option_info *out) {
    static const char *const free_options[] = {"seed",       "threads",     "memory", "time",
                                               "width",      "height",      "crop-x", "crop-y",
                                               "crop-width", "crop-height", "layers", NULL};
    static const char *const timed[] = {"integrator", "first-pass", "final-gather", "quality",
                                        NULL};
    const bool limits = has_limit(a) && has_limit(b);
    for (int i = 0; satin_options_describe(&satin_options_default, i, out); i++) {
        if (text_is_one_of(out->name, free_options)) continue;
        if (limits && !text_is_one_of(out->name, timed)) continue;
        if (!is_same(a, b, out->name)) return true;
    }
    return false;
}

static void warn_of_option(const struct averaged_image *a, const struct averaged_image *b) {
    satin_option_info option;
    size_t m = 0, n = 0;
    if (!differing_option(a->options, b->options, &option)) return;
    const char *one = option_value(a->options, option.name, &m),
               *two = option_value(b->options, option.name, &n);
    fprintf(stderr, "satin: warning: %s was rendered with %s=%.*s, and %s with %s=%.*s\n", b->path,
            option.name, (int)n, two, a->path, option.name, (int)m, one);
}

void app_average_check(const struct averaged_image *image, int count) {
    const struct averaged_image *last = &image[count - 1];
    for (int i = 0; i < count - 1; i++) {
        const struct averaged_image *one = &image[i];
        if (one->scene && last->scene && strcmp(one->scene, last->scene) != 0) {
            fprintf(stderr, "satin: warning: %s and %s are of different scenes\n", last->path,
                    one->path);
            return;
        }
    }
    if (!last->options) return;
    bool warned = false;
    for (int i = 0; i < count - 1 && !warned; i++) {
        const char *options = image[i].options;
        size_t length;
        // A mean has no seed.
        warned = options && option_value(options, "seed", &length) &&
                 option_value(last->options, "seed", &length) &&
                 is_same(options, last->options, "seed");
        if (!warned) continue;
        const bool equal = strcmp(options, last->options) == 0;
        fprintf(stderr, "satin: warning: %s and %s have the same %sseed%s\n", last->path,
                image[i].path, equal ? "options and " : "",
                equal ? "" : ", so their noise is not independent");
    }
    if (image[0].options) warn_of_option(&image[0], last);
}

void app_average_common_options(char *options, const char *other) {
    char *end = options;
    for (const char *at = options; *at; at += strspn(at, " ")) {
        const size_t word = strcspn(at, " "), name = strcspn(at, "= ");
        size_t length;
        char key[64];
        snprintf(key, sizeof key, "%.*s", (int)name, at);
        const char *value = option_value(other, key, &length);
        const bool same =
            value && name + 1 + length == word && memcmp(value, at + name + 1, length) == 0;
        const char *next = at + word;
        if (same && end != options) *end++ = ' ';
        if (same) memmove(end, at, word);
        if (same) end += word;
        at = next;
    }
    *end = '\0';
}
