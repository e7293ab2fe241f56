// SPDX-License-Identifier: Apache-2.0
// Private to scene/: warnings of one run of the loader. Those of one kind, which differ by names in
// quotes, numbers and places alone, become one line with a count.
#ifndef SCENE_WARNINGS_H
#define SCENE_WARNINGS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"

struct scene_warning;

struct scene_warnings {
    struct log to;                // the caller's
    bool strict;                  // warnings are errors
    bool failed;                  // some warning was one
    struct scene_warning *first;  // of each kind, in order
    size_t count, capacity;
};

// The log for a loader: keeps warnings until scene_warnings_tell or an error, which it passes on
// after them.
struct log scene_warnings_log(struct scene_warnings *warnings);
// The same for warnings that are passed on as they come, none of them counted.
struct log scene_warnings_each(struct scene_warnings *warnings);
// Passes on what is kept, and frees it.
void scene_warnings_tell(struct scene_warnings *warnings);

#endif
