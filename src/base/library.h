// SPDX-License-Identifier: Apache-2.0
// Shared libraries that are opened when they are first needed.
#ifndef BASE_LIBRARY_H
#define BASE_LIBRARY_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>

// Finds the first of `count` paths that can be read, relative to the folder of the library and then
// to that of the program that holds this code. False if none can; then `path` is undefined.
bool library_find(const char *const *paths, size_t count, char path[PATH_MAX]);

// Opens a library and never closes it, as threads that it started could still run its code. NULL on
// failure; dlerror() returns the reason.
void *library_open(const char *path);

#endif
