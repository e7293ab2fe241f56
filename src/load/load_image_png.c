// SPDX-License-Identifier: Apache-2.0
// Whether a PNG is whole, by the lengths and checksums of its chunks, and has what an image needs:
// libpng would tell of a damaged one on standard error. So pixels are unpacked here too, and thrown
// away.
#include <stdbool.h>
#include <string.h>
#include <zlib.h>

#include "load/load_build.h"

enum { SIGNATURE = 8, CHUNK = 12 };  // bytes; a chunk's are its length, name and checksum
enum { HEADER = 13, PALETTE_MOST = 3 * 256 };
enum { INDEXED = 3, TYPES = 7, SIDE_MOST = 1000000 };  // the longest that libpng takes

static uint32_t big_endian(const unsigned char *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

// The rows of an image, or of the passes of an interlaced one, as the compressed data hold them:
// a byte for the filter, then the pixels.
enum { PASSES = 7, FILTER_MOST = 4 };
struct rows {
    struct {
        uint32_t rows;
        size_t bytes;  // of a row
    } pass[PASSES];
    int at;         // the pass under way; PASSES: all are there
    uint32_t row;   // of it,
    size_t within;  // and the place in that
};

// What was found of the critical chunks.
struct seen {
    bool header, indexed, palette, pixels;
    struct rows rows;
    z_stream stream;
    bool no_memory;  // zlib found none
};

const char load_image_no_memory[] = "not enough memory to unpack it";

// ---- Pixels -------------------------------------------------------------------------------------

static void skip_empty(struct rows *r) {
    while (r->at < PASSES && r->row == r->pass[r->at].rows) {
        r->at++;
        r->row = 0;
    }
}

// `header` is one that is_header() takes.
static void begin_rows(const unsigned char *header, struct rows *r) {
    static const struct {
        unsigned x, y, dx, dy;  // of the pixels of a pass: the first, and the steps between them
    } adam7[PASSES] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                       {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
    static const unsigned channels[TYPES] = {1, 0, 3, 1, 2, 0, 4};
    const uint32_t width = big_endian(header), height = big_endian(header + 4);
    const size_t bits = (size_t)header[8] * channels[header[9]];
    *r = (struct rows){0};
    for (int i = 0; i < (header[12] ? PASSES : 1); i++) {
        const unsigned x = header[12] ? adam7[i].x : 0, dx = header[12] ? adam7[i].dx : 1;
        const unsigned y = header[12] ? adam7[i].y : 0, dy = header[12] ? adam7[i].dy : 1;
        const size_t columns = width > x ? (width - x + dx - 1) / dx : 0;
        if (columns == 0) continue;
        r->pass[i].rows = height > y ? (height - y + dy - 1) / dy : 0;
        r->pass[i].bytes = 1 + (columns * bits + 7) / 8;
    }
    skip_empty(r);
}

// Goes over unpacked bytes; false if a filter is none. What is too much does not matter.
static bool take_rows(struct rows *r, const unsigned char *data, size_t size) {
    while (size > 0 && r->at < PASSES) {
        const size_t bytes = r->pass[r->at].bytes, left = bytes - r->within;
        const size_t take = left < size ? left : size;
        if (r->within == 0 && data[0] > FILTER_MOST) return false;
        r->within += take;
        data += take;
        size -= take;
        if (r->within < bytes) break;
        r->within = 0;
        r->row++;
        skip_empty(r);
    }
    return true;
}

// Unpacks the data of one chunk; false if they are wrong.
static bool take_pixels(struct seen *seen, const unsigned char *data, uint32_t length) {
    unsigned char out[1 << 14];
    z_stream *z = &seen->stream;
    z->next_in = (z_const Bytef *)data;
    z->avail_in = length;
    while (seen->rows.at < PASSES) {
        z->next_out = out;
        z->avail_out = sizeof out;
        const int status = inflate(z, Z_NO_FLUSH);
        seen->no_memory = status == Z_MEM_ERROR;
        if (status != Z_OK && status != Z_STREAM_END) return status == Z_BUF_ERROR;
        if (!take_rows(&seen->rows, out, sizeof out - z->avail_out)) return false;
        if (status == Z_STREAM_END || (z->avail_in == 0 && z->avail_out > 0)) break;
    }
    return true;
}

// ---- Chunks -------------------------------------------------------------------------------------

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
        begin_rows(data, &seen->rows);
    } else if (!seen->header) {
        return "the PNG does not begin with a header";
    } else if (memcmp(name, "PLTE", 4) == 0) {
        if (seen->palette || length == 0 || length > PALETTE_MOST || length % 3)
            return "the PNG's palette is wrong";
        seen->palette = true;
    } else if (memcmp(name, "IDAT", 4) == 0) {
        if (seen->indexed && !seen->palette) return "the PNG has no palette";
        seen->pixels = true;
        if (!take_pixels(seen, data, length))
            return seen->no_memory ? load_image_no_memory : "the PNG's pixels are damaged";
    } else if (memcmp(name, "IEND", 4) == 0) {
        if (!seen->pixels) return "the PNG has no pixels";
        if (seen->rows.at < PASSES) return "the PNG has too few pixels";
    } else if (!(name[0] & 0x20)) {  // small letters begin what may be left out
        return "a part of the PNG is of an unknown kind";
    }
    return NULL;
}

static const char *chunks_problem(const unsigned char *at, const unsigned char *end,
                                  struct seen *seen) {
    while (end - at >= CHUNK) {
        uint32_t length = big_endian(at);
        if (length > (size_t)(end - at) - CHUNK) break;
        // The checksum is of the name and the data.
        uint32_t sum = (uint32_t)crc32_z(0, at + 4, (size_t)length + 4);
        if (sum != big_endian(at + 8 + length)) return "a part of the PNG is damaged";
        const char *problem = chunk_problem(at + 4, length, seen);
        if (problem || memcmp(at + 4, "IEND", 4) == 0) return problem;
        at += CHUNK + (size_t)length;
    }
    return "the PNG is cut short";
}

const char *load_image_png_problem(const char *data, size_t size) {
    const unsigned char *at = (const unsigned char *)data;
    struct seen seen = {0};
    if (size < SIGNATURE || memcmp(at, "\x89PNG\r\n\x1a\n", SIGNATURE) != 0) return NULL;
    if (inflateInit(&seen.stream) != Z_OK) return load_image_no_memory;
    const char *problem = chunks_problem(at + SIGNATURE, at + size, &seen);
    inflateEnd(&seen.stream);
    return problem;
}
