// SPDX-License-Identifier: Apache-2.0
// Files written. A regular file is written under a new name in its folder and renamed when all of
// it is on the disk, so it appears whole or not at all. Symbolic links are followed: the link stays
// and the file that it leads to is replaced, or made. A character device, a named pipe and an open
// file (/dev/stdout, /dev/fd/3) are written to directly. Everything else is refused.
#ifndef BASE_FILEIO_OUTPUT_H
#define BASE_FILEIO_OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/log.h"

// A file that is being written; its fields are private, but for `temporary`.
struct fileio_output {
    const char *path;  // as the caller names it, not owned
    char *target;      // the name that its symbolic links lead to
    char *temporary;   // the new name; NULL: the target is written to directly
    int fd;
    int error;  // errno of the first write that failed, or 0
};

// The name that the symbolic links of `path` lead to, which need not exist; malloc, the caller
// frees; NULL with errno.
char *fileio_follow(const char *path);

// What an output must be able to do.
enum fileio_need {
    FILEIO_APPEND,  // take bytes in order
    FILEIO_SEEK     // take bytes at any offset: a regular file
};

// Opens an output; `path` must live as long as *out. SATIN_ERROR_IO with one logged line if nothing
// can be written there. A named pipe waits for its reader.
satin_status fileio_output_open(struct log log, const char *path, enum fileio_need need,
                                struct fileio_output *out);
// Whether fileio_output_open would succeed, found out by making the new file and removing it;
// devices and pipes are not opened. SATIN_ERROR_INPUT with one logged line if not, or
// SATIN_ERROR_MEMORY.
satin_status fileio_output_check(struct log log, const char *path, enum fileio_need need);

// Writes all `size` bytes, at the end or at an offset. False, with out->error set, if that fails.
bool fileio_output_append(struct fileio_output *out, const void *data, size_t size);
bool fileio_output_write_at(struct fileio_output *out, const void *data, size_t size,
                            uint64_t offset);

// Flushes the file to disk and renames it to its final name, which may be that of a regular file
// but of nothing else. If this or an earlier write fails: logs, removes the new file, returns
// SATIN_ERROR_IO.
satin_status fileio_output_commit(struct log log, struct fileio_output *out);
// Removes the new file instead. What went to a device or pipe stays there.
void fileio_output_discard(struct fileio_output *out);

#endif
