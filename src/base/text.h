// SPDX-License-Identifier: Apache-2.0
// Words and numbers that users type: strict numbers, names compared loosely, the nearest name.
#ifndef BASE_TEXT_H
#define BASE_TEXT_H

#include <stdbool.h>

// Reads all of `text` as one finite decimal number with a point, whatever the locale. False, with
// *out unchanged, if it is anything else. Surrounding blanks are not allowed.
bool text_double(const char *text, double *out);

// Whether two names are the same, where '-' equals '_' and letter case does not matter.
bool text_same_name(const char *a, const char *b);
// Whether a name is the same as one of a list that ends with NULL.
bool text_is_one_of(const char *name, const char *const *list);

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
