// SPDX-License-Identifier: Apache-2.0
// Identifies files whatever their names are.
#include "base/fileio_files.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/array.h"
#include "base/fileio_output.h"

bool fileio_files_add(struct fileio_files *files, const char *path) {
    struct stat st;
    if (stat(path, &st) != 0) return true;
    void *items = files->id;
    if (!array_reserve(&items, &files->capacity, files->count + 1, sizeof *files->id)) return false;
    files->id = items;
    files->id[files->count++] = (struct fileio_id){st.st_dev, st.st_ino};
    return true;
}

bool fileio_files_have(const struct fileio_files *files, const char *path) {
    struct stat st;
    if (stat(path, &st) != 0) return false;
    for (size_t i = 0; i < files->count; i++)
        if (files->id[i].device == st.st_dev && files->id[i].inode == st.st_ino) return true;
    return false;
}

void fileio_files_free(struct fileio_files *files) {
    free(files->id);
    *files = (struct fileio_files){0};
}

static bool same_inode(const struct stat *a, const struct stat *b) {
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

// Splits a path, in place: returns the last name and sets *folder to the folder that holds it.
static const char *cut_folder(char *path, const char **folder) {
    char *slash = strrchr(path, '/');
    *folder = !slash ? "." : slash == path ? "/" : path;
    if (slash) *slash = 0;
    return slash ? slash + 1 : path;
}

// Compares two names of files that do not exist: they are the same if writing to either would make
// the same file.
static bool same_entry(const char *a, const char *b) {
    char *path[2] = {fileio_follow(a), fileio_follow(b)};
    bool same = false;
    if (path[0] && path[1]) {
        const char *folder[2];
        const char *name[2] = {cut_folder(path[0], &folder[0]), cut_folder(path[1], &folder[1])};
        struct stat st[2];
        same = strcmp(name[0], name[1]) == 0 && stat(folder[0], &st[0]) == 0 &&
               stat(folder[1], &st[1]) == 0 && same_inode(&st[0], &st[1]);
    }
    free(path[0]);
    free(path[1]);
    return same;
}

bool fileio_same(const char *a, const char *b) {
    struct stat st[2];
    const bool there[2] = {stat(a, &st[0]) == 0, stat(b, &st[1]) == 0};
    if (there[0] != there[1]) return false;
    if (!there[0]) return same_entry(a, b);
    return same_inode(&st[0], &st[1]) && !S_ISCHR(st[0].st_mode);
}
