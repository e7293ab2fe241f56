// SPDX-License-Identifier: Apache-2.0
// Growth of plain heap arrays: pointer, count and capacity stay visible in the owner's struct.
#ifndef BASE_ARRAY_H
#define BASE_ARRAY_H

#include <stdbool.h>
#include <stddef.h>

// Grows *items, from malloc or NULL, to at least `count` elements of `size` bytes. *capacity is the
// number of elements that fit; it grows by half at least. False, with everything unchanged, if
// there is no memory.
bool array_reserve(void **items, size_t *capacity, size_t count, size_t size);

// `count` zeroed elements of `size` bytes, aligned to 64 bytes; the caller frees them with free().
// NULL on overflow or lack of memory.
void *array_new(size_t count, size_t size);
// Does what array_new does, but zeroes nothing. For large arrays that all threads fill, so that the
// system's work for each new page is distributed over the threads too.
void *array_new_unset(size_t count, size_t size);

// Returns the memory of the whole pages in `bytes` bytes of an array to the system. What the bytes
// hold is lost; they may be freed or written again.
void array_drop(void *items, size_t bytes);

// For qsort of floats, none of them NaN, in ascending order.
int array_compare_floats(const void *a, const void *b);

#endif
