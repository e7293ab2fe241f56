// SPDX-License-Identifier: Apache-2.0
// The only table of options: by it every field of satin_options is parsed, printed and documented.
#ifndef OPTIONS_TABLE_H
#define OPTIONS_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/log.h"
#include "satin/options.h"

enum option_kind {
    OPTION_CHOICE,  // an enum; the range lists its words in the order of the values
    OPTION_BOOL,
    OPTION_INT,     // int
    OPTION_COUNT,   // int64_t
    OPTION_BYTES,   // int64_t, a number of bytes
    OPTION_SEED,    // uint64_t
    OPTION_FLOAT,   // float
    OPTION_DOUBLE,  // double
    OPTION_TEXT     // char[OPTION_TEXT_SIZE]; the range describes its form
};

enum { OPTION_TEXT_SIZE = 256 };

struct option {
    const char *name;  // that of the field, with '-' for '_'
    enum option_kind kind;
    size_t offset;    // of the field in satin_options
    bool by_quality;  // whether quality decides it
    // The range, as it is parsed and printed: "a|b|c" for choices, else "low..high", both ends
    // included, or "low.." without a highest value.
    const char *range;
    const char *doc;  // meaning, unit, and the meaning of special values
};

extern const struct option options_table[];
extern const int options_table_count;

// The option of this name ('-' and '_' are equal), or NULL.
const struct option *options_find(const char *name);
// The current name of an option that was called `name` in an earlier version, or NULL.
const char *options_renamed(const char *name);
// Sets the option's field from text. False, with nothing changed, if the value is not in range.
bool option_parse(const struct option *option, const char *value, satin_options *options);
// The highest value of a number; INFINITY if there is none.
double option_highest(const struct option *option);
// Prints the field's value as text that option_parse reads back as the same value.
void option_print(const struct option *option, const satin_options *options, char *out,
                  size_t bytes);

// ---- options.c
// Prints the options as `name=value` words with a space between, in the notation of --set: all, or
// if `chosen` is not NULL those for which it is true.
void options_print_words(FILE *out, const satin_options *options, bool (*chosen)(const char *name));
// Checks that every field is in its range. SATIN_ERROR_INPUT, with one logged line, if one is not.
satin_status options_check(const satin_options *options, struct log log);

#endif
