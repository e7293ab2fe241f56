// SPDX-License-Identifier: Apache-2.0
// The names under which output files are written before they are complete: that of the target, then
// `.tmp`, the hash of the machine's name and a random number. A process has a lock on each such
// file that it writes. So what a process that was killed has left can be distinguished from what
// another one writes, and is removed when its target is written again on this machine.
#include "base/fileio_temporary.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/fileio.h"

enum {
    TRIES = 16,               // attempts at a new name with a random number of 32 bits
    SUFFIX_BYTES = 4 + 8 + 8  // `.tmp` and two numbers of 32 bits in hexadecimal digits
};

// Writes `.tmp` and the number of this machine.
static void print_mark(char out[SUFFIX_BYTES + 1]) {
    char name[HOST_NAME_MAX + 1] = "";
    gethostname(name, HOST_NAME_MAX);
    const uint64_t hash = fileio_hash(FILEIO_HASH, name, strlen(name));
    snprintf(out, SUFFIX_BYTES + 1, ".tmp%08x", (unsigned)(hash >> 32));
}

// The number of bytes of the target's name that its temporary names begin with, as names may become
// too long; *folder is that of its folder with the slash.
static size_t bytes_kept(const char *target, size_t *folder) {
    const char *slash = strrchr(target, '/');
    *folder = slash ? (size_t)(slash - target) + 1 : 0;
    const size_t base = strlen(target + *folder), most = NAME_MAX - SUFFIX_BYTES;
    return *folder + (base < most ? base : most);
}

static char *new_name(const char *target) {
    uint32_t number;
    size_t folder;
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) return NULL;
    const size_t n = bytes_kept(target, &folder), size = n + SUFFIX_BYTES + 1;
    char mark[SUFFIX_BYTES + 1], *name = malloc(size);
    print_mark(mark);
    if (name) snprintf(name, size, "%.*s%s%08x", (int)n, target, mark, number);
    return name;
}

// Locks a new file. False if another process has taken it for one that was left.
static bool lock_own(int fd) {
    struct stat st;
    // Where there are no locks, nothing is removed either.
    if (flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
    return fstat(fd, &st) == 0 && st.st_nlink > 0;
}

int fileio_temporary_open(const char *target, char **name) {
    int fd = -1, error = EEXIST;
    *name = NULL;
    for (int i = 0; i < TRIES && fd < 0 && error == EEXIST; i++) {
        free(*name);
        *name = new_name(target);
        if (*name) fd = open(*name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        error = errno;
        if (fd >= 0 && !lock_own(fd)) {
            close(fd);
            fd = -1;
            error = EEXIST;
        }
    }
    if (fd >= 0) return fd;
    free(*name);
    *name = NULL;
    errno = error;
    return -1;
}

// Whether the name is one that this machine gives to unfinished files of a target, whose names
// begin with these bytes.
static bool is_temporary(const char *name, const char *base, size_t kept, const char *mark) {
    const size_t marked = kept + strlen(mark);
    return strncmp(name, base, kept) == 0 && strncmp(name + kept, mark, strlen(mark)) == 0 &&
           strspn(name + marked, "0123456789abcdef") == 8 && name[marked + 8] == 0;
}

// Removes a file that no process has locked.
static void remove_unlocked(int folder, const char *name) {
    const int fd = openat(folder, name, O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    struct stat st;
    if (fd < 0) return;
    if (fstat(fd, &st) == 0 && S_ISREG(st.st_mode) && flock(fd, LOCK_EX | LOCK_NB) == 0)
        unlinkat(folder, name, 0);
    close(fd);
}

void fileio_temporary_clean(const char *target) {
    size_t length;
    const size_t kept = bytes_kept(target, &length);
    char mark[SUFFIX_BYTES + 1];
    char *folder = length ? strndup(target, length) : strdup(".");
    DIR *list = folder ? opendir(folder) : NULL;
    print_mark(mark);
    for (struct dirent *entry; list && (entry = readdir(list));)
        if (is_temporary(entry->d_name, target + length, kept - length, mark))
            remove_unlocked(dirfd(list), entry->d_name);
    if (list) closedir(list);
    free(folder);
}
