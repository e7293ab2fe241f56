// SPDX-License-Identifier: Apache-2.0
// The bump allocator.
#include "base/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// A test sets a small block size, so that every allocation needs a block of its own.
#ifndef ARENA_BLOCK_BYTES
#define ARENA_BLOCK_BYTES (1 << 20)
#endif

enum { BLOCK_BYTES = ARENA_BLOCK_BYTES, ALIGN_LARGE = 64, ALIGN_SMALL = 16 };

struct arena_block {
    struct arena_block *next;
    void *memory;       // in which `data` is
    size_t used, size;  // of `data`
    char *data;
};

// A block of zeros. Large ones take no memory until they are written, as calloc gets them from the
// system: an image that is found to be damaged takes none.
static struct arena_block *block_new(size_t bytes) {
    struct arena_block *block = malloc(sizeof *block);
    if (!block) return NULL;
    const size_t size = (bytes + ALIGN_LARGE - 1) / ALIGN_LARGE * ALIGN_LARGE;
    void *memory = calloc(1, size + ALIGN_LARGE);
    if (!memory) {
        free(block);
        return NULL;
    }
    char *data = (char *)memory + (ALIGN_LARGE - (uintptr_t)memory % ALIGN_LARGE);
    *block = (struct arena_block){.memory = memory, .size = size, .data = data};
    return block;
}

void *arena_alloc(struct arena *arena, size_t bytes) {
    if (bytes > SIZE_MAX / 2) return NULL;
    if (bytes == 0) bytes = 1;
    size_t align = bytes >= ALIGN_LARGE ? ALIGN_LARGE : ALIGN_SMALL;
    struct arena_block *block = arena->head;
    size_t start = block ? (block->used + align - 1) / align * align : 0;
    if (!block || start > block->size || bytes > block->size - start) {
        block = block_new(bytes > BLOCK_BYTES ? bytes : BLOCK_BYTES);
        if (!block) return NULL;
        block->next = arena->head;
        arena->head = block;
        start = 0;
    }
    block->used = start + bytes;
    arena->bytes += bytes;
    return block->data + start;
}

void *arena_array(struct arena *arena, size_t count, size_t size) {
    if (size && count > SIZE_MAX / 2 / size) return NULL;
    return arena_alloc(arena, count * size);
}

void *arena_array_alone(struct arena *arena, size_t count, size_t size) {
    if (size && count > SIZE_MAX / 2 / size) return NULL;
    const size_t bytes = count > 0 && size > 0 ? count * size : 1;
    struct arena_block *block = block_new(bytes);
    if (!block) return NULL;
    // Behind the block from which small objects are handed out.
    struct arena_block **link = arena->head ? &arena->head->next : &arena->head;
    block->next = *link;
    block->used = block->size;
    *link = block;
    arena->bytes += block->size;
    return block->data;
}

void arena_drop(struct arena *arena, const void *array) {
    for (struct arena_block **link = &arena->head; *link; link = &(*link)->next) {
        struct arena_block *block = *link;
        if (block->data != array) continue;
        *link = block->next;
        arena->bytes -= block->size;
        free(block->memory);
        free(block);
        return;
    }
}

char *arena_text(struct arena *arena, const char *text, size_t length) {
    char *copy = length < SIZE_MAX / 2 ? arena_alloc(arena, length + 1) : NULL;
    if (copy && length) memcpy(copy, text, length);
    return copy;
}

void arena_free(struct arena *arena) {
    for (struct arena_block *block = arena->head, *next; block; block = next) {
        next = block->next;
        free(block->memory);
        free(block);
    }
    *arena = (struct arena){0};
}
