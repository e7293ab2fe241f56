// SPDX-License-Identifier: Apache-2.0
// Private to load/: warnings of one call of the loader. Warnings of one kind, which differ only in
// quoted names, numbers and places, become one line with a count.
#ifndef LOAD_WARNINGS_H
#define LOAD_WARNINGS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"

struct load_warning;

struct load_warnings {
    struct log to;               // the log of the caller
    bool strict;                 // whether warnings are errors
    bool failed;                 // whether there was a warning, if they are errors
    struct load_warning *first;  // of each kind, in order
    size_t count, capacity;
};

// The log for a loader. It keeps warnings until load_warnings_report, or until an error, which it
// passes on after them.
struct log load_warnings_log(struct load_warnings *warnings);
// A log for warnings that are passed on at once and not counted.
struct log load_warnings_each(struct load_warnings *warnings);
// Passes on the warnings that were kept, and frees them.
void load_warnings_report(struct load_warnings *warnings);

#endif
