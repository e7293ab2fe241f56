// SPDX-License-Identifier: Apache-2.0
// Whole files read and written, names relative to other files, and hashes.
#ifndef BASE_FILEIO_H
#define BASE_FILEIO_H

#include <stddef.h>

#include "base/log.h"

// Reads a regular file of at most `max_bytes` into *data, from malloc, with a 0 byte after the end;
// the caller frees it. SATIN_ERROR_INPUT if the file is missing, unreadable, a directory or too
// large, which is logged at `place`, the line that names the file (a zero place logs the path
// alone).
satin_status fileio_read(struct log log, struct log_place place, const char *path, size_t max_bytes,
                         char **data, size_t *size);

// Reads a file of any kind until its end: also a pipe, whose writer it waits for, and a device. In
// all else it is fileio_read.
satin_status fileio_read_stream(struct log log, struct log_place place, const char *path,
                                size_t max_bytes, char **data, size_t *size);

// Writes `size` bytes to `path`, as fileio_output.h describes. SATIN_ERROR_IO, logged, on failure.
satin_status fileio_write(struct log log, const char *path, const void *data, size_t size);

// `name` relative to the folder of the file `base`, unless `name` is absolute. From malloc; the
// caller frees it.
char *fileio_beside(const char *base, const char *name);

// The FNV-1a hash of `size` bytes, continued from `hash`; the first call gets FILEIO_HASH.
#define FILEIO_HASH 0xcbf29ce484222325ull
uint64_t fileio_hash(uint64_t hash, const void *data, size_t size);
// Another hash, for files of many megabytes: FNV-1a over words in four independent lanes, which the
// processor computes at the same time.
uint64_t fileio_hash_large(uint64_t hash, const void *data, size_t size);

#endif
