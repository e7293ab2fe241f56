// SPDX-License-Identifier: Apache-2.0
// Output files: symbolic links are followed, a new name is opened with O_EXCL and renamed at the
// end.
#include "base/fileio_output.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/fileio.h"
#include "base/fileio_temporary.h"

enum {
    LINKS_MAX = 40  // the kernel's own limit
};

static const char not_regular[] = "it is not a regular file";

// ---- The target ---------------------------------------------------------------------------------

// The number of the open file that a name such as /dev/fd/3 stands for, or -1.
static int open_file_number(const char *name) {
    int number;
    char rest;
    if (sscanf(name, "/dev/fd/%9d%c", &number, &rest) == 1) return number;
    if (sscanf(name, "/proc/self/fd/%9d%c", &number, &rest) == 1) return number;
    return -1;
}

char *fileio_follow(const char *path) {
    char to[PATH_MAX];
    char *name = strdup(path);
    for (int links = 0; name && open_file_number(name) < 0; links++) {
        const ssize_t n = readlink(name, to, sizeof to - 1);
        if (n < 0 && (errno == EINVAL || errno == ENOENT)) break;  // not a link, or missing
        if (n >= 0 && links == LINKS_MAX) errno = ELOOP;
        if (n < 0 || links == LINKS_MAX) {
            free(name);
            return NULL;
        }
        to[n] = 0;
        char *next = fileio_beside(name, to);
        free(name);
        name = next;
    }
    return name;
}

// ---- The new file -------------------------------------------------------------------------------

// Opens a file that did not exist before. Returns NULL or what went wrong.
static const char *create(struct fileio_output *out) {
    out->fd = fileio_temporary_open(out->target, &out->temporary);
    return out->fd < 0 ? strerror(errno) : NULL;
}

// Writes to a duplicate of an open file, at its current offset. This also works for files that
// cannot be opened by name, such as a socket that is standard output.
static const char *duplicate(int number, struct fileio_output *out) {
    const int flags = fcntl(number, F_GETFL);
    if (flags < 0) return strerror(errno);
    if ((flags & O_ACCMODE) == O_RDONLY) return "it is not open for writing";
    out->fd = fcntl(number, F_DUPFD_CLOEXEC, 0);
    return out->fd < 0 ? strerror(errno) : NULL;
}

// Makes the new file with the permissions of the file that it will replace. A file without write
// permission is not replaced.
static const char *create_over(const struct stat *st, struct fileio_output *out) {
    if (access(out->target, W_OK) != 0) return strerror(errno);
    const char *problem = create(out);
    // A file system without permissions fails here, which does not matter.
    if (!problem && fchmod(out->fd, st->st_mode & 0777) != 0) errno = 0;
    return problem;
}

// Opens *out, whose path is set. Returns NULL or what went wrong. With `check_only` devices and
// pipes are not opened.
static const char *open_output(struct fileio_output *out, enum fileio_need need, bool check_only) {
    struct stat st;
    out->target = fileio_follow(out->path);
    if (!out->target) return strerror(errno);
    const int number = open_file_number(out->target);
    if (number >= 0) return need == FILEIO_SEEK ? not_regular : duplicate(number, out);
    // The name of a file must not be empty.
    if (!*out->target) return strerror(ENOENT);
    if (lstat(out->target, &st) != 0) return errno == ENOENT ? create(out) : strerror(errno);
    if (S_ISREG(st.st_mode)) return create_over(&st, out);
    if (S_ISDIR(st.st_mode)) return "it is a directory";
    if (need == FILEIO_SEEK || !(S_ISCHR(st.st_mode) || S_ISFIFO(st.st_mode))) return not_regular;
    if (check_only) return access(out->target, W_OK) != 0 ? strerror(errno) : NULL;
    out->fd = open(out->target, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    return out->fd < 0 ? strerror(errno) : NULL;
}

satin_status fileio_output_open(struct log log, const char *path, enum fileio_need need,
                                struct fileio_output *out) {
    *out = (struct fileio_output){.path = path, .fd = -1};
    const char *problem = open_output(out, need, false);
    if (!problem && out->temporary) fileio_temporary_clean(out->target);
    if (!problem) return SATIN_OK;
    log_message(log, SATIN_LOG_ERROR, "%s: cannot write: %s", path, problem);
    fileio_output_discard(out);
    return SATIN_ERROR_IO;
}

satin_status fileio_output_check(struct log log, const char *path, enum fileio_need need) {
    struct fileio_output out = {.path = path, .fd = -1};
    errno = 0;
    const char *problem = open_output(&out, need, true);
    const bool memory = problem && errno == ENOMEM;
    if (problem) log_message(log, SATIN_LOG_ERROR, "%s: cannot write: %s", path, problem);
    fileio_output_discard(&out);
    if (memory) return SATIN_ERROR_MEMORY;
    return problem ? SATIN_ERROR_INPUT : SATIN_OK;
}

// ---- Writing ------------------------------------------------------------------------------------

static bool write_all(struct fileio_output *out, const char *data, size_t size, bool at,
                      uint64_t offset) {
    while (size > 0 && !out->error) {
        const ssize_t n =
            at ? pwrite(out->fd, data, size, (off_t)offset) : write(out->fd, data, size);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            out->error = n < 0 ? errno : EIO;
            break;
        }
        data += n;
        size -= (size_t)n;
        offset += (uint64_t)n;
    }
    return !out->error;
}

bool fileio_output_append(struct fileio_output *out, const void *data, size_t size) {
    return write_all(out, data, size, false, 0);
}

bool fileio_output_write_at(struct fileio_output *out, const void *data, size_t size,
                            uint64_t offset) {
    return write_all(out, data, size, true, offset);
}

// ---- The end ------------------------------------------------------------------------------------

// Checks again that a rename may replace the target, which may have changed since it was opened.
static const char *replaceable(const char *target) {
    struct stat st;
    if (lstat(target, &st) != 0) return errno == ENOENT ? NULL : strerror(errno);
    return S_ISREG(st.st_mode) ? NULL : not_regular;
}

// Sets *locked to a descriptor of the new file, or -1 if there is none: its lock remains, so that
// no process removes the file before it has its name.
static const char *commit(struct fileio_output *out, int *locked) {
    *locked = -1;
    if (out->error) return strerror(out->error);
    if (out->temporary && !out->unflushed && fsync(out->fd) != 0) return strerror(errno);
    if (out->temporary) *locked = fcntl(out->fd, F_DUPFD_CLOEXEC, 0);
    if (out->temporary && *locked < 0) return strerror(errno);
    const int fd = out->fd;
    out->fd = -1;
    // Some file systems report only here that a write has failed.
    if (close(fd) != 0) return strerror(errno);
    if (!out->temporary) return NULL;
    const char *problem = replaceable(out->target);
    if (problem) return problem;
    if (rename(out->temporary, out->target) != 0) return strerror(errno);
    free(out->temporary);
    out->temporary = NULL;
    return NULL;
}

satin_status fileio_output_commit_locked(struct log log, struct fileio_output *out, int *fd) {
    const char *problem = commit(out, fd);
    if (problem) log_message(log, SATIN_LOG_ERROR, "%s: cannot write: %s", out->path, problem);
    fileio_output_discard(out);
    if (!problem) return SATIN_OK;
    if (*fd >= 0) close(*fd);
    *fd = -1;
    return SATIN_ERROR_IO;
}

satin_status fileio_output_commit(struct log log, struct fileio_output *out) {
    int fd;
    const satin_status status = fileio_output_commit_locked(log, out, &fd);
    if (fd >= 0) close(fd);
    return status;
}

void fileio_output_discard(struct fileio_output *out) {
    if (out->temporary) unlink(out->temporary);
    if (out->fd >= 0) close(out->fd);
    free(out->temporary);
    free(out->target);
    *out = (struct fileio_output){.fd = -1};
}
