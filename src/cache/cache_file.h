// SPDX-License-Identifier: Apache-2.0
// Private to cache/: the layout of a file of records (docs/formats.md has it as a table of bytes).
// Numbers are little-endian; records are rows of 32-bit words.
#ifndef CACHE_FILE_H
#define CACHE_FILE_H

#include "cache/cache.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "files have the byte order of memory");

enum { CACHE_FILE_VERSION = 4 };

enum cache_section {
    SECTION_OPTIONS = 0,
    SECTION_IRRADIANCE_HEADS,
    SECTION_IRRADIANCE,
    SECTION_RADIANCE_HEADS,
    SECTION_RADIANCE,
    SECTIONS
};
// The sections of a kind of records.
static inline enum cache_section cache_file_heads(enum cache_kind kind) {
    static const enum cache_section heads[CACHE_KINDS] = {
        [CACHE_IRRADIANCE] = SECTION_IRRADIANCE_HEADS, [CACHE_RADIANCE] = SECTION_RADIANCE_HEADS};
    return heads[kind];
}
static inline enum cache_section cache_file_values(enum cache_kind kind) {
    return (enum cache_section)(cache_file_heads(kind) + 1);
}

struct cache_file_section {
    uint64_t size;  // bytes, without the zeros up to a multiple of 8
    uint64_t checksum;
};

struct cache_file_header {
    char magic[8];
    uint32_t version, sections;
    uint64_t world, image, rays;
    uint32_t order, unused;
    struct cache_file_section section[SECTIONS];
    uint64_t checksum;  // of all bytes before it
};

// The words of a row; those between semicolons, or after one, are integers.
enum {
    HEAD_WORDS = 24,        // p R, n search_radius, anisotropy scale, u clear; sector: bytes
    IRRADIANCE_WORDS = 25,  // E, dE/dp r g b, rotation r g b, deviations, radius_ratio; rays
    RADIANCE_WORDS = 18,    // frame u v n, radius_ratio, residual mirror L; rays, lobe number; then
    COEFFICIENT_WORDS = 10  // for each coefficient: Lambda r g b noise, d/dx r g b, d/dy r g b
};
_Static_assert(sizeof(struct cache_head) == 4 * HEAD_WORDS, "a head is a row");
_Static_assert(sizeof(struct cache_file_header) == 136, "no gaps");

static inline size_t cache_file_row(enum cache_section section, uint32_t order) {
    const size_t radiance = RADIANCE_WORDS + (size_t)COEFFICIENT_WORDS * order * order;
    const size_t words[SECTIONS] = {0, HEAD_WORDS, IRRADIANCE_WORDS, HEAD_WORDS, radiance};
    return 4 * words[section];
}
static inline size_t cache_file_padded(size_t size) { return (size + 7) / 8 * 8; }

struct cache_file {
    struct cache_file_header header;
    char *options;                           // ended by 0
    const unsigned char *section[SECTIONS];  // pointers into the bytes of the file
    size_t rows[SECTIONS];
};

#endif
