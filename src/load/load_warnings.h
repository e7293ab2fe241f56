// SPDX-License-Identifier: Apache-2.0
// Private to load/: warnings of one run of the loader. Those of one kind, which differ by names in
// quotes, numbers and places alone, become one line with a count.
#ifndef LOAD_WARNINGS_H
#define LOAD_WARNINGS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"

struct load_warning;

struct load_warnings {
    struct log to;               // the caller's
    bool strict;                 // warnings are errors
    bool failed;                 // some warning was one
    struct load_warning *first;  // of each kind, in order
    size_t count, capacity;
};

// The log for a loader: keeps warnings until load_warnings_report or an error, which it passes on
// after them.
struct log load_warnings_log(struct load_warnings *warnings);
// A log for warnings that are passed on as they come, none of them counted.
struct log load_warnings_each(struct load_warnings *warnings);
// Passes on what is kept, and frees it.
void load_warnings_report(struct load_warnings *warnings);

#endif
