// SPDX-License-Identifier: Apache-2.0
// Reads and writes whole files, resolves names relative to other files, and computes hashes.
#include "base/fileio.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/fileio_output.h"

static satin_status read_failed(struct log log, struct log_place place, const char *path,
                                const char *why) {
    if (place.file)
        log_error_at(log, place, "cannot read '%s': %s", path, why);
    else
        log_message(log, SATIN_LOG_ERROR, "%s: cannot read: %s", path, why);
    return SATIN_ERROR_INPUT;
}

static bool read_all(int fd, char *buffer, size_t size) {
    for (size_t got = 0; got < size;) {
        ssize_t n = read(fd, buffer + got, size - got);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        got += (size_t)n;
    }
    return true;
}

satin_status fileio_read(struct log log, struct log_place place, const char *path, size_t max_bytes,
                         char **data, size_t *size) {
    // Non-blocking, so that a named pipe without a writer does not hang but is refused below.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) return read_failed(log, place, path, strerror(errno));
    struct stat st;
    satin_status status = SATIN_OK;
    char *buffer = NULL;
    if (fstat(fd, &st) != 0)
        status = read_failed(log, place, path, strerror(errno));
    else if (S_ISDIR(st.st_mode))
        status = read_failed(log, place, path, "it is a directory");
    else if (!S_ISREG(st.st_mode))
        status = read_failed(log, place, path, "it is not a regular file");
    else if ((unsigned long long)st.st_size > max_bytes)
        status = read_failed(log, place, path, "it is too large");
    else if (!(buffer = malloc((size_t)st.st_size + 1)))
        status = log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory to read it", path);
    else if (!read_all(fd, buffer, (size_t)st.st_size))
        status = read_failed(log, place, path, "it ends early");
    close(fd);
    if (status != SATIN_OK) {
        free(buffer);
        return status;
    }
    buffer[st.st_size] = 0;
    *data = buffer;
    *size = (size_t)st.st_size;
    return SATIN_OK;
}

// Reads at most `max_bytes` until the end, to *data from malloc with space for one byte more.
// Returns NULL, or why it failed; a text of length 0 means lack of memory.
static const char *read_to_end(int fd, size_t max_bytes, char **data, size_t *size) {
    size_t capacity = 0;
    for (;;) {
        if (*size + 1 >= capacity) {
            capacity = capacity ? 2 * capacity : (size_t)1 << 16;
            char *grown = realloc(*data, capacity);
            if (!grown) return "";
            *data = grown;
        }
        const ssize_t n = read(fd, *data + *size, capacity - 1 - *size);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return strerror(errno);
        if (n == 0) return NULL;
        *size += (size_t)n;
        if (*size > max_bytes) return "it is too large";
    }
}

satin_status fileio_read_stream(struct log log, struct log_place place, const char *path,
                                size_t max_bytes, char **data, size_t *size) {
    struct stat st;
    // What is not there, or is a regular file or a folder, is read or refused as usual.
    if (stat(path, &st) != 0 || S_ISREG(st.st_mode) || S_ISDIR(st.st_mode))
        return fileio_read(log, place, path, max_bytes, data, size);
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return read_failed(log, place, path, strerror(errno));
    char *buffer = NULL;
    size_t length = 0;
    const char *why = read_to_end(fd, max_bytes, &buffer, &length);
    close(fd);
    if (!why) {
        buffer[length] = 0;
        *data = buffer;
        *size = length;
        return SATIN_OK;
    }
    free(buffer);
    if (*why) return read_failed(log, place, path, why);
    return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory to read it", path);
}

satin_status fileio_write(struct log log, const char *path, const void *data, size_t size) {
    struct fileio_output out;
    satin_status status = fileio_output_open(log, path, FILEIO_APPEND, &out);
    if (status != SATIN_OK) return status;
    fileio_output_append(&out, data, size);
    return fileio_output_commit(log, &out);
}

char *fileio_beside(const char *base, const char *name) {
    const char *slash = name[0] == '/' ? NULL : strrchr(base, '/');
    size_t folder = slash ? (size_t)(slash - base) + 1 : 0, n = strlen(name);
    char *path = malloc(folder + n + 1);
    if (!path) return NULL;
    memcpy(path, base, folder);
    memcpy(path + folder, name, n + 1);
    return path;
}

uint64_t fileio_hash(uint64_t hash, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; i++) hash = (hash ^ bytes[i]) * 0x100000001b3ull;
    return hash;
}

uint64_t fileio_hash_large(uint64_t hash, const void *data, size_t size) {
    enum { LANES = 4, HASH_STEP = LANES * sizeof(uint64_t) };
    uint64_t lane[LANES] = {1, 2, 3, 4}, word[LANES];
    const unsigned char *bytes = data;
    for (; size >= HASH_STEP; bytes += HASH_STEP, size -= HASH_STEP) {
        memcpy(word, bytes, HASH_STEP);
        // Multiplication moves no information from high bits to low ones; the shift does.
        for (int i = 0; i < LANES; i++) {
            lane[i] = (lane[i] ^ word[i]) * 0x9e3779b97f4a7c15ull;
            lane[i] ^= lane[i] >> 32;
        }
    }
    return fileio_hash(fileio_hash(hash, lane, sizeof lane), bytes, size);
}
