// SPDX-License-Identifier: Apache-2.0
// Which file is which, whatever its name: by device and inode, so that other spellings of a path,
// symbolic links and hard links are found out. What was read must not be written to.
#ifndef BASE_FILEIO_FILES_H
#define BASE_FILEIO_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

// Files that were read; a zero struct holds none.
struct fileio_files {
    struct fileio_id {
        dev_t device;
        ino_t inode;
    } * id;
    size_t count, capacity;
};

// Adds the file of that name, if there is one; false without memory.
bool fileio_files_add(struct fileio_files *files, const char *path);
// Whether the name leads to one of the files.
bool fileio_files_have(const struct fileio_files *files, const char *path);
void fileio_files_free(struct fileio_files *files);

// Whether two names lead to one file, or to the directory entry of one that is not there yet.
// Character devices, which nothing is lost on, are never the same.
bool fileio_same(const char *a, const char *b);

#endif
