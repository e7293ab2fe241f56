// SPDX-License-Identifier: Apache-2.0
// Output files. A regular file is written under a new name in its folder and renamed when all of it
// is on the disk, so it appears whole or not at all. What a process that was killed has left
// of it is removed when the file is written again on the same machine. A symbolic link is followed:
// the link stays, and the file that it leads to is replaced or made. A character device, a named
// pipe and an open file (/dev/stdout, /dev/fd/3) are written to directly. Everything else is
// refused.
#ifndef BASE_FILEIO_OUTPUT_H
#define BASE_FILEIO_OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/log.h"

// An output that is being written; all fields but `temporary` and `unflushed` are private.
struct fileio_output {
    const char *path;  // the caller's name of it, not owned
    char *target;      // the name that its symbolic links lead to
    char *temporary;   // the new name, or NULL if the target is written to directly
    int fd;
    int error;  // errno of the first write that failed, or 0
    // May be set once the output is open: the file is renamed before it is on the disk. Its readers
    // do not notice, but a failure of the whole machine may leave it empty.
    bool unflushed;
};

// The path to which the symbolic links of `path` lead, which need not exist. From malloc, the
// caller frees it; NULL with errno set on failure.
char *fileio_follow(const char *path);

// The operations that an output must support.
enum fileio_need {
    FILEIO_APPEND,  // take bytes in order
    FILEIO_SEEK     // take bytes at any offset: a regular file
};

// Opens an output; `path` must stay valid as long as *out. SATIN_ERROR_IO, with one logged line, if
// it cannot be written. Opening a named pipe waits for its reader.
satin_status fileio_output_open(struct log log, const char *path, enum fileio_need need,
                                struct fileio_output *out);
// Checks whether fileio_output_open would succeed, by making the new file and removing it; devices
// and pipes are not opened. If not, returns SATIN_ERROR_INPUT with one logged line, or
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
// Does that, and sets *fd to a descriptor of the file, for reading and writing, which has had the
// lock on it since it was opened, or to -1 if that is not a new regular file. The caller closes it.
satin_status fileio_output_commit_locked(struct log log, struct fileio_output *out, int *fd);
// Removes the new file instead. Data that was written to a device or a pipe stays there.
void fileio_output_discard(struct fileio_output *out);

#endif
