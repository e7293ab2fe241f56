// SPDX-License-Identifier: Apache-2.0
// A growing buffer of bytes to which values are appended, and a reader of such bytes. Values have
// the byte order and layout of memory. A failure is kept, so that it can be checked once at the
// end.
#ifndef BASE_BYTES_H
#define BASE_BYTES_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"

// All zeros at first; the owner frees `data`.
struct bytes {
    unsigned char *data;
    size_t count, capacity;
    bool failed;  // there was no memory: `data` lacks what did not fit
};

static inline void bytes_put(struct bytes *bytes, const void *value, size_t size) {
    if (size == 0 || bytes->failed) return;
    bytes->failed = size > SIZE_MAX - bytes->count ||
                    !array_reserve((void **)&bytes->data, &bytes->capacity, bytes->count + size, 1);
    if (bytes->failed) return;
    memcpy(bytes->data + bytes->count, value, size);
    bytes->count += size;
}

static inline void bytes_put_u64(struct bytes *bytes, uint64_t value) {
    bytes_put(bytes, &value, sizeof value);
}

static inline void bytes_free(struct bytes *bytes) {
    free(bytes->data);
    memset(bytes, 0, sizeof *bytes);
}

struct bytes_reader {
    const unsigned char *at;  // not owned
    size_t left;
    bool failed;  // more was read than there is
};

// Sets *value to the next `size` bytes, or to zeros if there are fewer.
static inline void bytes_get(struct bytes_reader *reader, void *value, size_t size) {
    reader->failed |= size > reader->left;
    if (reader->failed) {
        memset(value, 0, size);
        return;
    }
    if (size) memcpy(value, reader->at, size);
    reader->at += size;
    reader->left -= size;
}

static inline uint64_t bytes_get_u64(struct bytes_reader *reader) {
    uint64_t value;
    bytes_get(reader, &value, sizeof value);
    return value;
}

#endif
