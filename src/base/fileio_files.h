// SPDX-License-Identifier: Apache-2.0
// Identifies files by device and inode, whatever their names are, so that other spellings of a
// path, symbolic links and hard links are recognised. A file that was read must not be written to.
#ifndef BASE_FILEIO_FILES_H
#define BASE_FILEIO_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

// The files that were read; a zero struct holds none.
struct fileio_files {
    struct fileio_id {
        dev_t device;
        ino_t inode;
    } * id;
    size_t count, capacity;
};

// Adds the file of that name, if it exists. False if there is no memory.
bool fileio_files_add(struct fileio_files *files, const char *path);
// Whether the name leads to one of the files.
bool fileio_files_have(const struct fileio_files *files, const char *path);
void fileio_files_free(struct fileio_files *files);

// Whether two names lead to one file or, if it does not exist, to the same directory entry. Never
// true of character devices, as writing to them loses no data.
bool fileio_same(const char *a, const char *b);

#endif
