// SPDX-License-Identifier: Apache-2.0
// PNG files: every type of pixel, interlaced or not, and one message for each kind of damage;
// libpng prints no messages of its own on standard error.
#include <png.h>
#include <zlib.h>

#include "load/load_image_reader.h"
#include "mesh_case.h"

enum { SIGNATURE = 8, HEADER = 13, FILE_MAX = 4096 };

// A PNG that is put together chunk by chunk.
struct png_file {
    size_t size;
    unsigned char byte[FILE_MAX];
};

static void put_number(struct png_file *png, size_t value) {
    for (int k = 24; k >= 0; k -= 8) png->byte[png->size++] = (unsigned char)(value >> k);
}

static void load_image_png_put_chunk(struct png_file *png, const char *name, const void *data,
                                     size_t size) {
    put_number(png, size);
    unsigned char *const from = png->byte + png->size;
    memcpy(from, name, 4);
    if (size) memcpy(from + 4, data, size);
    png->size += 4 + size;
    put_number(png, crc32(0, from, (unsigned)size + 4));
}

static void begin_png(struct png_file *png, const unsigned char header[HEADER]) {
    memcpy(png->byte, "\x89PNG\r\n\x1a\n", SIGNATURE);
    png->size = SIGNATURE;
    load_image_png_put_chunk(png, "IHDR", header, HEADER);
}

static void load_image_png_put_pixels(struct png_file *png, const unsigned char *rows,
                                      size_t size) {
    unsigned char packed[512];
    uLongf n = sizeof packed;
    assert_int_equal(compress(packed, &n, rows, size), Z_OK);
    load_image_png_put_chunk(png, "IDAT", packed, n);
}

static void end_png(struct png_file *png) { load_image_png_put_chunk(png, "IEND", NULL, 0); }

// Loads the file, with no line on standard error.
static satin_status load_raw(const struct png_file *png, struct scene_case *log,
                             struct arena *arena, struct image **image) {
    scene_case_bytes("a.png", png->byte, png->size);
    *arena = (struct arena){0};
    struct load_source source = {scene_case_begin(log), {"scene.xml", 3, 7}, arena, "a.png", NULL};
    struct load_images images = {.arena = arena};
    const satin_status status = load_image(&source, &images, true, image);
    assert_int_equal(log->errors, status != SATIN_OK);
    assert_int_equal(log->warnings, 0);
    return status;
}

static void refuse_png(const struct png_file *png, const char *problem) {
    struct scene_case log;
    struct arena arena;
    struct image *image = NULL;
    char message[256];
    assert_int_equal(load_raw(png, &log, &arena, &image), SATIN_ERROR_INPUT);
    snprintf(message, sizeof message, "scene.xml:3:7: cannot read image 'a.png': %s", problem);
    assert_string_equal(log.error, message);
    arena_free(&arena);
}

// For one pixel of each type and depth, the values are those that the file has, whatever its
// packing.
static void every_type_of_png_is_read(void **state) {
    (void)state;
    static const struct {
        unsigned char depth, type, row[9];
        size_t size;
        int channels;
        float texel[3];
    } kinds[] = {
        {1, 0, {0, 0x80}, 2, 1, {1}},
        {2, 0, {0, 0x40}, 2, 1, {85 / 255.0f}},
        {4, 0, {0, 0x30}, 2, 1, {51 / 255.0f}},
        {8, 0, {0, 7}, 2, 1, {7 / 255.0f}},
        {16, 0, {0, 1, 2}, 3, 1, {258 / 65535.0f}},
        {8, 2, {0, 1, 2, 3}, 4, 3, {1 / 255.0f, 2 / 255.0f, 3 / 255.0f}},
        {16, 2, {0, 1, 0, 0, 2, 0, 3}, 7, 3, {256 / 65535.0f, 2 / 65535.0f, 3 / 65535.0f}},
        {1, 3, {0, 0x80}, 2, 3, {40 / 255.0f, 50 / 255.0f, 60 / 255.0f}},
        {8, 4, {0, 9, 0}, 3, 1, {9 / 255.0f}},
        {8, 6, {0, 4, 5, 6, 0}, 5, 3, {4 / 255.0f, 5 / 255.0f, 6 / 255.0f}},
    };
    static const unsigned char palette[6] = {10, 20, 30, 40, 50, 60};
    for (size_t i = 0; i < 2 * (sizeof kinds / sizeof *kinds); i++) {
        const unsigned char interlaced = i & 1;
        const unsigned char header[HEADER] = {
            [3] = 1, [7] = 1, [8] = kinds[i / 2].depth, [9] = kinds[i / 2].type, [12] = interlaced};
        struct png_file png;
        struct scene_case log;
        struct arena arena;
        struct image *image;
        begin_png(&png, header);
        if (kinds[i / 2].type == 3) load_image_png_put_chunk(&png, "PLTE", palette, sizeof palette);
        load_image_png_put_pixels(&png, kinds[i / 2].row, kinds[i / 2].size);
        end_png(&png);
        assert_int_equal(load_raw(&png, &log, &arena, &image), SATIN_OK);
        assert_int_equal(image->channels, kinds[i / 2].channels);
        for (int c = 0; c < image->channels; c++)
            assert_float_equal(scene_image_value(image, c), kinds[i / 2].texel[c], 1e-7f);
        arena_free(&arena);
    }
}

// The rows of an interlaced image end where those of its pixels are.
static void interlaced_rows_are_read(void **state) {
    (void)state;
    // The image has 3 x 2 pixels of grey. Passes 1, 4, 6 and 7 have a row each, of 1, 1, 1 and 3
    // pixels.
    static const unsigned char rows[] = {0, 10, 0, 30, 0, 20, 0, 40, 50, 60};
    const unsigned char header[HEADER] = {[3] = 3, [7] = 2, [8] = 8, [12] = 1};
    struct png_file png;
    struct scene_case log;
    struct arena arena;
    struct image *image;
    begin_png(&png, header);
    load_image_png_put_pixels(&png, rows, sizeof rows);
    end_png(&png);
    assert_int_equal(load_raw(&png, &log, &arena, &image), SATIN_OK);
    for (int i = 0; i < 6; i++)
        assert_float_equal(scene_image_value(image, i), (float)(i + 1) * 10 / 255.0f, 1e-7f);
    arena_free(&arena);
    begin_png(&png, header);
    load_image_png_put_pixels(&png, rows, sizeof rows - 1);
    end_png(&png);
    refuse_png(&png, "the PNG is damaged: Not enough image data");
}

static void the_encoding_is_that_of_the_file(void **state) {
    (void)state;
    static const struct {
        const char *name, *data;
        size_t size;
        int srgb;
    } chunks[] = {{"tEXt", "a\0b", 3, 1},
                  {"gAMA", "\0\1\x86\xa0", 4, 0},  // 1
                  {"gAMA", "\0\0\xb1\x8f", 4, 1},  // 1 / 2.2
                  {"sRGB", "\0", 1, 1}};
    for (size_t i = 0; i < sizeof chunks / sizeof *chunks; i++) {
        const unsigned char header[HEADER] = {[3] = 1, [7] = 1, [8] = 8}, row[2] = {0, 7};
        struct png_file png;
        struct opened_image opened;
        char error[128];
        begin_png(&png, header);
        load_image_png_put_chunk(&png, chunks[i].name, chunks[i].data, chunks[i].size);
        load_image_png_put_pixels(&png, row, sizeof row);
        end_png(&png);
        const struct image_data file = {"a.png", (char *)png.byte, png.size, 0};
        assert_true(load_image_is_png(&file));
        assert_int_equal(load_image_png.open(&file, &opened, error, sizeof error), READER_DONE);
        assert_int_equal(opened.srgb, chunks[i].srgb);
        load_image_png.close(&opened);
    }
}

static void damaged_png_files_are_refused(void **state) {
    (void)state;
    static const struct {
        size_t at;
        unsigned char byte;
        const char *problem;
    } bad[] = {
        {0, 0xff, "the PNG is damaged: PNG unsigned integer out of range"},  // width
        {7, 0, "the PNG is damaged: Invalid IHDR data"},                     // height
        {8, 7, "the PNG is damaged: Invalid IHDR data"},                     // bits
        {9, 5, "the PNG is damaged: Invalid IHDR data"},                     // type of colour
        {9, 3, "the PNG is damaged: IDAT: Missing PLTE before IDAT"},
        {12, 2, "the PNG is damaged: Invalid IHDR data"},  // interlacing
        {3, 9, "the PNG is damaged: Not enough image data"},
    };
    static const unsigned char rows[8] = {0};
    struct png_file png;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        unsigned char header[HEADER] = {[3] = 3, [7] = 2, [8] = 8};
        header[bad[i].at] = bad[i].byte;
        begin_png(&png, header);
        load_image_png_put_pixels(&png, rows, sizeof rows);
        end_png(&png);
        refuse_png(&png, bad[i].problem);
    }
    const unsigned char header[HEADER] = {[3] = 3, [7] = 2, [8] = 8};
    const unsigned char filter[8] = {[4] = 5};  // of the second row
    begin_png(&png, header);
    load_image_png_put_pixels(&png, filter, sizeof filter);
    end_png(&png);
    refuse_png(&png, "the PNG is damaged: bad adaptive filter value");
    begin_png(&png, header);
    load_image_png_put_chunk(&png, "HUGE", rows, sizeof rows);
    refuse_png(&png, "the PNG is damaged: HUGE: unhandled critical chunk");
    begin_png(&png, header);
    end_png(&png);
    refuse_png(&png, "the PNG is damaged: IEND: out of place");
}

// A file may end anywhere, and any byte of any chunk may be another, also one of a text, on which
// no texel depends.
static void every_cut_and_every_wrong_byte_is_refused(void **state) {
    (void)state;
    const unsigned char header[HEADER] = {[3] = 3, [7] = 2, [8] = 8}, rows[8] = {0};
    struct png_file png;
    begin_png(&png, header);
    load_image_png_put_chunk(&png, "tEXt", "a\0b", 3);
    load_image_png_put_pixels(&png, rows, sizeof rows);
    end_png(&png);
    const struct png_file whole = png;
    for (png.size = SIGNATURE; png.size < whole.size; png.size++)
        refuse_png(&png, "the PNG is damaged: the file is cut short");
    for (size_t at = SIGNATURE; at < whole.size; at++) {
        struct scene_case log;
        struct arena arena;
        struct image *image = NULL;
        png = whole;
        png.byte[at] ^= 1;
        assert_int_equal(load_raw(&png, &log, &arena, &image), SATIN_ERROR_INPUT);
        assert_non_null(strstr(log.error, "cannot read image 'a.png': the PNG is damaged: "));
        arena_free(&arena);
    }
}

// Text that unpacks to 64 MB, eight times what libpng would allocate for a chunk, is not unpacked.
static void chunks_without_effect_are_skipped(void **state) {
    (void)state;
    enum { LARGE = 64 << 20, PACKED = 1 << 17 };
    const unsigned char header[HEADER] = {[3] = 1, [7] = 1, [8] = 8}, row[2] = {0, 7};
    unsigned char *large = calloc(1, LARGE), *file = malloc(2 * PACKED);
    assert_true(large && file);
    uLongf n = PACKED;
    memcpy(file, "a\0", 3);  // a key, its end, and the method of compression
    assert_int_equal(compress(file + 3, &n, large, LARGE), Z_OK);
    free(large);
    struct png_file small;
    begin_png(&small, header);
    const size_t head = small.size;
    unsigned char *all = malloc(head + n + 3 + 12 + 64), *to = all + head;
    assert_non_null(all);
    memcpy(all, small.byte, head);
    const unsigned length = (unsigned)n + 3;
    for (int k = 24; k >= 0; k -= 8) *to++ = (unsigned char)(length >> k);
    memcpy(to, "zTXt", 4);
    memcpy(to + 4, file, length);
    const unsigned long sum = crc32(0, to, length + 4);
    to += 4 + length;
    for (int k = 24; k >= 0; k -= 8) *to++ = (unsigned char)(sum >> k);
    struct png_file tail = {0};
    load_image_png_put_pixels(&tail, row, sizeof row);
    end_png(&tail);
    memcpy(to, tail.byte, tail.size);
    const struct image_data data = {"a.png", (char *)all, (size_t)(to - all) + tail.size, 0};
    struct opened_image opened;
    char error[128] = "";
    unsigned char texel;
    assert_int_equal(load_image_png.open(&data, &opened, error, sizeof error), READER_DONE);
    assert_int_equal(load_image_png.read(&opened, &texel, error, sizeof error), READER_DONE);
    assert_true(opened.bytes && texel == 7);
    load_image_png.close(&opened);
    free(file);
    free(all);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_of_png_is_read),
        cmocka_unit_test(interlaced_rows_are_read),
        cmocka_unit_test(the_encoding_is_that_of_the_file),
        cmocka_unit_test(damaged_png_files_are_refused),
        cmocka_unit_test(every_cut_and_every_wrong_byte_is_refused),
        cmocka_unit_test(chunks_without_effect_are_skipped),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
