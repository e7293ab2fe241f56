// SPDX-License-Identifier: Apache-2.0
// Growth of plain heap arrays.
#include "base/array.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

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

int array_compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}
