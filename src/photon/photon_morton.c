// SPDX-License-Identifier: Apache-2.0
// The Morton order, and a stable radix sort by it on all threads: each chunk of items counts its
// digits, and the counts give the offsets to which each chunk writes its items of each digit.
#include "photon/photon_morton.h"

#include <stdlib.h>

#include "base/array.h"

enum {
    DIGIT_BITS = 10,
    DIGITS = 1 << DIGIT_BITS,
    CHUNK_LEAST = 4096,  // least number of items: some times the number of digits
    CHUNKS_MOST = 128  // largest number of chunks: one thread adds the counts of all their digits,
                       // which takes .1 ms; more threads than that would gain less
};

static uint32_t spread_bits(uint32_t x) {  // 10 bits to every third of 30
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

uint32_t photon_morton_key(const struct photon_morton *morton, vec3 p) {
    vec3 q = v3_mul(v3_sub(p, morton->lo), morton->scale);
    return spread_bits((uint32_t)clampf(q.x, 0.0f, 1023.0f)) |
           spread_bits((uint32_t)clampf(q.y, 0.0f, 1023.0f)) << 1 |
           spread_bits((uint32_t)clampf(q.z, 0.0f, 1023.0f)) << 2;
}

struct sorting {
    const struct photon_keyed *from;
    struct photon_keyed *to;
    size_t chunk;             // number of items of a chunk
    size_t (*start)[DIGITS];  // by chunk: first counts, then the offsets of its items
    int shift;
};

static size_t digit_of(const struct sorting *s, size_t i) {
    return s->from[i].key >> s->shift & (DIGITS - 1);
}

static void count_digits(void *ctx, size_t begin, size_t end, int worker) {
    const struct sorting *s = ctx;
    size_t *count = s->start[begin / s->chunk];
    (void)worker;
    for (size_t d = 0; d < DIGITS; d++) count[d] = 0;
    for (size_t i = begin; i < end; i++) count[digit_of(s, i)]++;
}

static void move_items(void *ctx, size_t begin, size_t end, int worker) {
    const struct sorting *s = ctx;
    size_t *start = s->start[begin / s->chunk];
    (void)worker;
    for (size_t i = begin; i < end; i++) s->to[start[digit_of(s, i)]++] = s->from[i];
}

struct photon_keyed *photon_morton_sort(struct photon_keyed *a, struct photon_keyed *b, size_t n,
                                        struct parallel *pool) {
    struct sorting s = {.from = a, .to = b, .chunk = n / CHUNKS_MOST + 1};
    if (s.chunk < CHUNK_LEAST) s.chunk = CHUNK_LEAST;
    const size_t chunks = n / s.chunk + (n % s.chunk != 0);
    s.start = array_new(chunks, sizeof *s.start);
    bool whole = s.start != NULL;
    for (; s.shift < PHOTON_MORTON_BITS && whole; s.shift += DIGIT_BITS) {
        whole = parallel_for(pool, n, s.chunk, count_digits, &s);
        size_t sum = 0;
        for (size_t d = 0; d < DIGITS; d++)
            for (size_t i = 0; i < chunks; i++) {
                const size_t count = s.start[i][d];
                s.start[i][d] = sum;
                sum += count;
            }
        whole = whole && parallel_for(pool, n, s.chunk, move_items, &s);
        s.from = s.to;
        s.to = s.from == a ? b : a;
    }
    free(s.start);
    return !whole ? NULL : s.from == a ? a : b;
}

// ---- Cells ------------------------------------------------------------------------------------

struct splitting {
    const struct photon_morton *morton;
    const float *position;
    size_t stride, most, capacity;
    struct photon_morton_tree *out;
};

static uint32_t key_at(const struct splitting *s, size_t i) {
    const float *p = s->position + i * s->stride;
    return photon_morton_key(s->morton, v3(p[0], p[1], p[2]));
}

// The first of the points whose key has the bit set.
static size_t find_bit(const struct splitting *s, size_t begin, size_t end, uint32_t bit) {
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (key_at(s, middle) & bit)
            end = middle;
        else
            begin = middle + 1;
    }
    return begin;
}

static bool split_range(struct splitting *s, size_t begin, size_t end) {
    struct photon_morton_tree *out = s->out;
    const size_t at = out->count;
    if (!array_reserve((void **)&out->node, &s->capacity, at + 1, sizeof *out->node)) return false;
    out->node[out->count++] = (struct photon_morton_node){-1, 0, begin, end};
    const uint32_t apart = key_at(s, begin) ^ key_at(s, end - 1);
    if (end - begin <= s->most || apart == 0) {
        out->cells++;
        return true;
    }
    int bit = PHOTON_MORTON_BITS - 1;
    while (!(apart >> bit & 1u)) bit--;
    const size_t middle = find_bit(s, begin, end, 1u << bit);
    out->node[at].column = bit % 3;
    if (!split_range(s, begin, middle)) return false;
    out->node[at].second = (uint32_t)out->count;
    return split_range(s, middle, end);
}

bool photon_morton_split(const struct photon_morton *morton, const float *position, size_t stride,
                         size_t count, size_t most, struct photon_morton_tree *out) {
    *out = (struct photon_morton_tree){0};
    struct splitting s = {morton, position, stride, most, 0, out};
    return split_range(&s, 0, count);
}
