// SPDX-License-Identifier: Apache-2.0
// The identity of a render: all that its image depends on, as words. Checkpoints, frames and ranks
// of other renders are recognised by it, and the first word that differs is named.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/text.h"
#include "render/options_table.h"
#include "render/render.h"
#include "render/render_state.h"

// Options that do not affect the image.
static bool affects_image(const char *option) { return !text_same_name(option, "threads"); }

char *render_identity(const struct render *r) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    const uint64_t records =
        fileio_hash_large(FILEIO_HASH, r->second_pass.file_bytes, r->second_pass.file_size);
    // The sensor and the definitions are part of the scene's hash too, but come first, so that they
    // are named if they differ.
    fprintf(out, "version=%s sensor=%d definitions=%s scene=%016llx records=%016llx ",
            SATIN_VERSION, r->scene.sensor_index,
            r->scene.definitions ? r->scene.definitions : "none", (unsigned long long)r->scene.hash,
            (unsigned long long)records);
    satin_options options = r->options;
    if (options.time > 0.0) render_timed_identity(r, &options);
    options_print_words(out, &options, affects_image);
    // The size of the film changes the views.
    if (r->frames.view) fprintf(out, " views=%016llx", (unsigned long long)render_views_hash(r));
    const satin_animation *a = r->callbacks.animation;
    if (a && a->motion) fprintf(out, " motion=%016llx", (unsigned long long)a->motion);
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

bool render_identity_next(const char **text, struct identity_word *word) {
    while (**text == ' ') ++*text;
    *word = (struct identity_word){*text, strcspn(*text, " "), strcspn(*text, "= ")};
    *text += word->length;
    return word->length > 0;
}

bool render_identity_is(const struct identity_word *word, const char *name) {
    return strlen(name) == word->name && strncmp(word->at, name, word->name) == 0;
}

// Goes behind the next words that differ.
static bool next_difference(const char **here, const char **there, struct identity_word *a,
                            struct identity_word *b) {
    bool left = true, right = true;
    while (left && right) {
        left = render_identity_next(here, a);
        right = render_identity_next(there, b);
        if (left && right && (a->length != b->length || memcmp(a->at, b->at, a->length) != 0))
            return true;
    }
    return left || right;
}

bool render_identity_differ(const char **here, const char **there, struct identity_word *a,
                            struct identity_word *b) {
    if (!next_difference(here, there, a, b)) return false;
    // The size of the image follows from its crop.
    struct identity_word c = *a, d = *b;
    const char *later_here = *here, *later_there = *there;
    while (render_identity_is(&c, "width") || render_identity_is(&c, "height") ||
           render_identity_is(&c, "crop-x") || render_identity_is(&c, "crop-y"))
        if (!next_difference(&later_here, &later_there, &c, &d)) return true;
    if (!render_identity_is(&c, "crop-width")) return true;
    *a = c;
    *b = d;
    return true;
}

bool render_describe_difference(const char *here, const char *there, char *out, size_t size) {
    struct identity_word a, b;
    if (!render_identity_differ(&here, &there, &a, &b)) return false;
    const bool alike = a.name == b.name && strncmp(a.at, b.at, a.name) == 0;
    const char *const hashes[] = {"scene", "records", "views", "motion"};
    const char *const names[] = {"scene", "records", "camera path", "motion of objects"};
    snprintf(out, size, "another version");
    if (!alike) return true;
    snprintf(out, size, "%.*s instead of %.*s", (int)b.length, b.at, (int)a.length, a.at);
    for (size_t i = 0; i < sizeof hashes / sizeof *hashes; i++)
        if (render_identity_is(&a, hashes[i])) snprintf(out, size, "another %s", names[i]);
    return true;
}
