// SPDX-License-Identifier: Apache-2.0
// A bump allocator: many small objects of one lifetime, freed together. Not thread-safe.
#ifndef BASE_ARENA_H
#define BASE_ARENA_H

#include <stddef.h>

struct arena_block;

struct arena {
    struct arena_block *head;  // newest block first; NULL when empty
    size_t bytes;              // bytes handed out, with padding
};

// `bytes` of zeroed memory aligned to 64 if bytes >= 64, else to 16; NULL if there is no memory.
// Valid until arena_free. A size of 0 gives a unique pointer.
void *arena_alloc(struct arena *arena, size_t bytes);
// `count * size` bytes; NULL too if the product overflows.
void *arena_array(struct arena *arena, size_t count, size_t size);
// As arena_array, in a block of its own, which arena_drop frees.
void *arena_array_alone(struct arena *arena, size_t count, size_t size);
// Frees an array of arena_array_alone before the others. NULL is allowed.
void arena_drop(struct arena *arena, const void *array);
// A copy of `length` bytes of text with a terminating 0.
char *arena_text(struct arena *arena, const char *text, size_t length);
// Frees all; the arena is empty and usable again.
void arena_free(struct arena *arena);

#endif
