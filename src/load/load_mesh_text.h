// SPDX-License-Identifier: Apache-2.0
// Private to load/: a cursor over the text of a mesh file.
#ifndef LOAD_MESH_TEXT_H
#define LOAD_MESH_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct mesh_text {
    const char *at, *end;
    int line;  // line number of `at`, from 1
};

// Skips spaces, tabs and carriage returns, and a line end after a backslash.
void load_mesh_text_skip_blanks(struct mesh_text *text);
// Skips line ends too.
void load_mesh_text_skip_space(struct mesh_text *text);
// Advances to the start of the next line, or to the end.
void load_mesh_text_next_line(struct mesh_text *text);

// Reads the word at the cursor, up to a blank or line end. Returns its length, 0 if there is none.
size_t load_mesh_text_word(struct mesh_text *text, const char **word);
// Whether a word is `name`.
bool load_mesh_text_is(const char *word, size_t length, const char *name);

// Reads a decimal number at the cursor, accurate to about an ulp of a double. A number that is too
// large gives infinity. A number must be followed by a blank, a line end, '#' or the end of the
// text. False, with the cursor unchanged, if there is none.
bool load_mesh_text_number(struct mesh_text *text, double *out);
// Reads decimal digits with an optional sign. Saturates far beyond 2^32.
bool load_mesh_text_integer(struct mesh_text *text, int64_t *out);

#endif
