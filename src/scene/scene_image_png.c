// SPDX-License-Identifier: Apache-2.0
// Whether a PNG is whole, by the lengths and checksums of its chunks: libpng would tell of a
// damaged one on standard error.
#include <string.h>
#include <zlib.h>

#include "scene/scene_build.h"

enum { SIGNATURE = 8, CHUNK = 12 };  // bytes; a chunk's are its length, name and checksum

static uint32_t big_endian(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

const char *scene_image_png_problem(const char *data, size_t size) {
    const unsigned char *at = (const unsigned char *)data, *end = at + size;
    if (size < SIGNATURE || memcmp(at, "\x89PNG\r\n\x1a\n", SIGNATURE) != 0) return NULL;
    for (at += SIGNATURE; end - at >= CHUNK;) {
        uint32_t length = big_endian(at);
        if (length > (size_t)(end - at) - CHUNK) break;
        // The checksum is of the name and the data.
        uint32_t sum = (uint32_t)crc32_z(0, at + 4, (size_t)length + 4);
        if (sum != big_endian(at + 8 + length)) return "a part of the PNG is damaged";
        if (memcmp(at + 4, "IEND", 4) == 0) return NULL;
        at += CHUNK + (size_t)length;
    }
    return "the PNG is cut short";
}
