// SPDX-License-Identifier: Apache-2.0
// Whole files in and out, names of files beside others, hashes.
#ifndef BASE_FILEIO_H
#define BASE_FILEIO_H

#include <stddef.h>

#include "base/log.h"

// Reads a regular file of at most `max_bytes` into *data (malloc, with a 0 byte after the end; the
// caller frees). SATIN_ERROR_INPUT if it is missing, unreadable, a directory or too large, logged
// at `place` (the line that asked for it; a zero place logs the path alone).
satin_status fileio_read(struct log log, struct log_place place, const char *path, size_t max_bytes,
                         char **data, size_t *size);

// Writes `size` bytes to `path`, as fileio_output.h describes. SATIN_ERROR_IO, logged, on failure.
satin_status fileio_write(struct log log, const char *path, const void *data, size_t size);

// `name` relative to the folder of the file `base`, unless name is absolute; malloc, the caller
// frees.
char *fileio_beside(const char *base, const char *name);

// FNV-1a over `size` bytes, continuing from `hash` (start with FILEIO_HASH).
#define FILEIO_HASH 0xcbf29ce484222325ull
uint64_t fileio_hash(uint64_t hash, const void *data, size_t size);
// Another hash, for files of many megabytes: FNV-1a over words in four lanes, which do not wait
// for each other.
uint64_t fileio_hash_large(uint64_t hash, const void *data, size_t size);

#endif
