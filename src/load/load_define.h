// SPDX-License-Identifier: Apache-2.0
// Private to load/: the parameters of a scene file, from `<default name="spp" value="16"/>` and `-D
// spp=64`, and their use as `$spp` in attributes.
#ifndef LOAD_DEFINE_H
#define LOAD_DEFINE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/arena.h"
#include "satin/types.h"

enum {
    LOAD_DEFINE_MAX = 256,      // parameters; each `$` is compared with all of them
    LOAD_ATTRIBUTE_MAX = 65536  // bytes of an attribute after substitution, which might grow
                                // exponentially
};

struct load_define {
    const char *name, *value;
    bool given;  // set by the caller: a <default> does not replace it, and it must be used
    bool used;
};

struct load_defines {
    struct load_define item[LOAD_DEFINE_MAX];
    int count;
};

// Adds a parameter, unless there is one of that name. False if the table is full. The pointers are
// kept.
bool load_define_add(struct load_defines *defines, const char *name, const char *value, bool given);

// Copies `text` to the arena, with every `$name` replaced by the longest parameter name that
// matches, and `\$` by a dollar sign. SATIN_ERROR_INPUT if a parameter is undefined or the text
// becomes too long: then *problem is the text from the failing `$` on, or NULL if it is too long.
satin_status load_define_expand(struct load_defines *defines, struct arena *arena, const char *text,
                                const char **out, const char **problem);

#endif
