// SPDX-License-Identifier: Apache-2.0
// The one table of options: it parses, prints and documents every field of satin_options.
#ifndef OPTIONS_TABLE_H
#define OPTIONS_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "satin/options.h"

enum option_kind {
    OPTION_CHOICE,  // an enum; the range lists its words from value 0 on
    OPTION_BOOL,
    OPTION_INT,     // int
    OPTION_COUNT,   // int64_t
    OPTION_SEED,    // uint64_t
    OPTION_FLOAT,   // float
    OPTION_DOUBLE,  // double
    OPTION_TEXT     // char[OPTION_TEXT_SIZE]; the range says its form
};

enum { OPTION_TEXT_SIZE = 256 };

struct option {
    const char *name;  // of the field, with '-' for '_'
    enum option_kind kind;
    size_t offset;    // of the field in satin_options
    bool by_quality;  // a quality preset decides it
    // What is read is what is printed: "a|b|c" for choices, else "low..high", both ends included,
    // or "low.." without a highest value.
    const char *range;
    const char *doc;  // one sentence: meaning, unit, what the special values mean
};

extern const struct option options_table[];
extern const int options_table_count;

// The option of this name ('-' and '_' are the same), or NULL.
const struct option *options_find(const char *name);
// The name that an option has now which was called `name` in earlier versions, or NULL.
const char *options_renamed(const char *name);
// Sets the option's field from text; false, and nothing changed, if the value is not in its range.
bool option_parse(const struct option *option, const char *value, satin_options *options);
// The highest value of a number; INFINITY: there is none.
double option_highest(const struct option *option);
// The field's value as text that option_parse reads back to the same value.
void option_print(const struct option *option, const satin_options *options, char *out,
                  size_t bytes);

#endif
