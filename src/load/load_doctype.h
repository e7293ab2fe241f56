// SPDX-License-Identifier: Apache-2.0
// Private to load/: declarations of a document's type, and the entities that they would have been
// for.
#ifndef LOAD_DOCTYPE_H
#define LOAD_DOCTYPE_H

#include <stdbool.h>
#include <stddef.h>

// Overwrites <!DOCTYPE ...> before the root element with blanks; lines stay where they are.
void load_doctype_blank(char *data, size_t size);

// The first entity in `text` that XML itself does not know; *name is where its & stands. Returns
// the length up to its ;, or 0 if there is none.
size_t load_entity_find(const char *text, size_t size, const char **name);

#endif
