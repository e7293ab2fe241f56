// SPDX-License-Identifier: Apache-2.0
// Words and numbers that users type: strict numbers, names compared loosely, the nearest name.
#ifndef BASE_TEXT_H
#define BASE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

// Reads all of `text` as one finite decimal number with a point, whatever the locale. False, with
// *out unchanged, if it is anything else. Surrounding blanks are not allowed.
bool text_double(const char *text, double *out);

// Whether two names are the same, where '-' equals '_' and letter case does not matter.
bool text_same_name(const char *a, const char *b);
// Whether a name is the same as one of a list that ends with NULL.
bool text_is_one_of(const char *name, const char *const *list);

// ---- text_utf8.c
// The bytes of the character of UTF-8 at the beginning of a text that is not empty; 0: there is
// none.
size_t text_utf8_bytes(const char *text);
// U+FFFD, which stands for a byte that is not UTF-8.
#define TEXT_REPLACEMENT "\xef\xbf\xbd"
// Prints a text as a JSON string, in quotes, that may stand in a script of a page.
void text_print_json(FILE *out, const char *text);

// ---- text.c
// Searches the candidate with the fewest edits (insert, delete, replace, swap of neighbours) to
// `word`. Start with {word}. After all candidates were tried, `best` is the first of the nearest
// ones, or NULL if none is near enough (edits <= 1 + a third of its letters).
struct text_nearest {
    const char *word;
    const char *best;
    int edits;
};
void text_nearest_try(struct text_nearest *search, const char *candidate);

#endif
