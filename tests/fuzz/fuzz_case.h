// SPDX-License-Identifier: Apache-2.0
// What the fuzz targets have in common: their entry, a log that counts, and bytes as a file of the
// process.
#ifndef FUZZ_CASE_H
#define FUZZ_CASE_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include "satin/types.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { FUZZ_PATH = 64 };

// Ends the process, with the line and the text of the condition that does not hold.
#define FUZZ_REQUIRE(good) ((good) ? (void)0 : fuzz_fail(__LINE__, #good))

static inline void fuzz_fail(int line, const char *text) {
    fprintf(stderr, "line %d: not true: %s\n", line, text);
    abort();
}

// A satin_log_fn: counts the errors in the int at `user`.
static inline void fuzz_count(void *user, satin_log_severity severity, const char *text) {
    (void)text;
    if (severity == SATIN_LOG_ERROR) ++*(int *)user;
}

// The bytes as a file that lives as long as the descriptor that is returned.
static inline int fuzz_file(const void *data, size_t size, char path[FUZZ_PATH]) {
    int fd = memfd_create("fuzz", MFD_CLOEXEC);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size) abort();
    snprintf(path, FUZZ_PATH, "/proc/self/fd/%d", fd);
    return fd;
}

// The bytes packed as the content of a serialized mesh, so that mutations get past zlib.
static inline int fuzz_file_packed(const uint8_t *data, size_t size, char path[FUZZ_PATH]) {
    static const uint8_t head[4] = {0x1c, 0x04, 4, 0};
    uLongf packed = compressBound(size);
    uint8_t *content = malloc(sizeof head + packed);
    if (!content) abort();
    memcpy(content, head, sizeof head);
    if (compress(content + sizeof head, &packed, data, size) != Z_OK) abort();
    int fd = fuzz_file(content, sizeof head + packed, path);
    free(content);
    return fd;
}

#endif
