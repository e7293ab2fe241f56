// SPDX-License-Identifier: Apache-2.0
// Whether a PNG is whole, by the lengths and checksums of its chunks, and has what an image needs:
// libpng would tell of a damaged one on standard error. Pixels are not unpacked here.
#include <stdbool.h>
#include <string.h>
#include <zlib.h>

#include "scene/scene_build.h"

enum { SIGNATURE = 8, CHUNK = 12 };  // bytes; a chunk's are its length, name and checksum
enum { HEADER = 13, PALETTE_MOST = 3 * 256 };
enum { INDEXED = 3, TYPES = 7, SIDE_MOST = 1000000 };  // the longest that libpng takes

static uint32_t big_endian(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

// What was found of the critical chunks.
struct seen {
    bool header, indexed, palette, pixels;
};

// Width, height, bits, type of colour, compression, filter, interlacing.
static bool is_header(const unsigned char *data, uint32_t length) {
    // Sums of the numbers of bits, powers of two, that a type may have.
    static const unsigned bits[TYPES] = {31, 0, 24, 15, 24, 0, 24};
    if (length != HEADER) return false;
    const uint32_t width = big_endian(data), height = big_endian(data + 4);
    const unsigned depth = data[8], type = data[9];
    return width - 1 < SIDE_MOST && height - 1 < SIDE_MOST && depth && !(depth & (depth - 1)) &&
           type < TYPES && bits[type] & depth && !data[10] && !data[11] && data[12] < 2;
}

static const char *chunk_problem(const unsigned char *name, uint32_t length, struct seen *seen) {
    const unsigned char *data = name + 4;
    if (memcmp(name, "IHDR", 4) == 0) {
        if (seen->header || !is_header(data, length)) return "the PNG's header is wrong";
        seen->header = true;
        seen->indexed = data[9] == INDEXED;
    } else if (!seen->header) {
        return "the PNG does not begin with a header";
    } else if (memcmp(name, "PLTE", 4) == 0) {
        if (seen->palette || length == 0 || length > PALETTE_MOST || length % 3)
            return "the PNG's palette is wrong";
        seen->palette = true;
    } else if (memcmp(name, "IDAT", 4) == 0) {
        if (seen->indexed && !seen->palette) return "the PNG has no palette";
        seen->pixels = true;
    } else if (memcmp(name, "IEND", 4) == 0) {
        if (!seen->pixels) return "the PNG has no pixels";
    } else if (!(name[0] & 0x20)) {  // small letters begin what may be left out
        return "a part of the PNG is of an unknown kind";
    }
    return NULL;
}

const char *scene_image_png_problem(const char *data, size_t size) {
    const unsigned char *at = (const unsigned char *)data, *end = at + size;
    struct seen seen = {0};
    if (size < SIGNATURE || memcmp(at, "\x89PNG\r\n\x1a\n", SIGNATURE) != 0) return NULL;
    for (at += SIGNATURE; end - at >= CHUNK;) {
        uint32_t length = big_endian(at);
        if (length > (size_t)(end - at) - CHUNK) break;
        // The checksum is of the name and the data.
        uint32_t sum = (uint32_t)crc32_z(0, at + 4, (size_t)length + 4);
        if (sum != big_endian(at + 8 + length)) return "a part of the PNG is damaged";
        const char *problem = chunk_problem(at + 4, length, &seen);
        if (problem || memcmp(at + 4, "IEND", 4) == 0) return problem;
        at += CHUNK + (size_t)length;
    }
    return "the PNG is cut short";
}
