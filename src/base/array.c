// SPDX-License-Identifier: Apache-2.0
// Growth of plain heap arrays.
#include "base/array.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

bool array_reserve(void **items, size_t *capacity, size_t count, size_t size) {
    if (count <= *capacity) return true;
    size_t want = *capacity + *capacity / 2;
    if (want < count) want = count;
    if (want < 16) want = 16;
    if (want > SIZE_MAX / 2 / size) return false;
    void *grown = realloc(*items, want * size);
    if (!grown) return false;
    *items = grown;
    *capacity = want;
    return true;
}

void *array_new_unset(size_t count, size_t size) {
    if (size && count > SIZE_MAX / 2 / size) return NULL;
    size_t bytes = (count * size + 63) / 64 * 64;
    return aligned_alloc(64, bytes ? bytes : 64);
}

void *array_new(size_t count, size_t size) {
    void *items = array_new_unset(count, size);
    return items ? memset(items, 0, count * size) : NULL;
}

void array_drop(void *items, size_t bytes) {
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    const uintptr_t begin = ((uintptr_t)items + page - 1) / page * page;
    const uintptr_t end = ((uintptr_t)items + bytes) / page * page;
    // If the system refuses, it keeps the memory, which changes nothing else.
    if (begin < end) (void)madvise((void *)begin, end - begin, MADV_DONTNEED);
}

int array_compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}
