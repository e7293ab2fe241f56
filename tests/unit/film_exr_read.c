// SPDX-License-Identifier: Apache-2.0
// OpenEXR files read: every compression, pixel type, scanlines and tiles, an offset data window;
// then files cut short, flipped bytes and headers that declare too much.
#include <math.h>
#include <openexr.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/fileio.h"
#include "base/rng.h"
#include "film/film.h"
#include "folder_case.h"
#include "message_case.h"

enum { WIDTH = 37, HEIGHT = 45, TILE = 16, LEFT = -3, TOP = 11 };

struct sample_file {
    exr_compression_t compression;
    exr_pixel_type_t type;
    bool tiled;
};

// Returns a value that half, float and uint hold exactly.
static uint32_t film_exr_read_value_at(int c, int x, int y) {
    return (uint32_t)(c * 700 + x * 7 + y * 3);
}

// Returns the bits of a non-negative integer below 2048 as half.
static uint16_t half_bits(uint32_t v) {
    if (v == 0) return 0;
    int e = 31 - __builtin_clz(v);
    return (uint16_t)((e + 15) << 10 | (int)((v << (10 - e)) & 0x3ff));
}

static void film_exr_read_store(void *out, exr_pixel_type_t type, uint32_t v) {
    float f = (float)v;
    uint16_t h = half_bits(v);
    if (type == EXR_PIXEL_HALF)
        memcpy(out, &h, 2);
    else if (type == EXR_PIXEL_FLOAT)
        memcpy(out, &f, 4);
    else
        memcpy(out, &v, 4);
}

static void film_exr_read_check(exr_result_t r) { assert_int_equal(r, EXR_ERR_SUCCESS); }

static void film_exr_read_put_chunk(exr_context_t exr, const struct sample_file *f,
                                    const exr_chunk_info_t *info, int x0, int y0) {
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int bytes = f->type == EXR_PIXEL_HALF ? 2 : 4;
    uint8_t *pixel = calloc((size_t)(3 * info->width * info->height), (size_t)bytes);
    film_exr_read_check(exr_encoding_initialize(exr, 0, info, &pipe));
    for (int c = 0; c < 3; c++) {
        uint8_t *plane = pixel + c * info->width * info->height * bytes;
        for (int y = 0; y < info->height; y++)
            for (int x = 0; x < info->width; x++)
                film_exr_read_store(plane + (y * info->width + x) * bytes, f->type,
                                    film_exr_read_value_at(c, x0 + x, y0 + y));
        pipe.channels[c].user_pixel_stride = bytes;
        pipe.channels[c].user_line_stride = bytes * info->width;
        pipe.channels[c].encode_from_ptr = plane;
    }
    film_exr_read_check(exr_encoding_choose_default_routines(exr, 0, &pipe));
    film_exr_read_check(exr_encoding_run(exr, 0, &pipe));
    film_exr_read_check(exr_encoding_destroy(exr, &pipe));
    free(pixel);
}

static void film_exr_read_put_pixels(exr_context_t exr, const struct sample_file *f) {
    exr_chunk_info_t info;
    int32_t lines = TILE;
    if (!f->tiled) film_exr_read_check(exr_get_scanlines_per_chunk(exr, 0, &lines));
    for (int y = 0; y < HEIGHT; y += lines) {
        if (!f->tiled) {
            film_exr_read_check(exr_write_scanline_chunk_info(exr, 0, TOP + y, &info));
            film_exr_read_put_chunk(exr, f, &info, 0, y);
            continue;
        }
        for (int x = 0; x < WIDTH; x += TILE) {
            film_exr_read_check(exr_write_tile_chunk_info(exr, 0, x / TILE, y / TILE, 0, 0, &info));
            film_exr_read_put_chunk(exr, f, &info, x, y);
        }
    }
}

static void make_file(const struct sample_file *f, const char *path) {
    exr_context_t exr;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    film_exr_read_check(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &init));
    int part;
    film_exr_read_check(
        exr_add_part(exr, NULL, f->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part));
    exr_attr_box2i_t window;
    window.min.x = LEFT;
    window.min.y = TOP;
    window.max.x = LEFT + WIDTH - 1;
    window.max.y = TOP + HEIGHT - 1;
    exr_attr_v2f_t centre;
    centre.x = centre.y = 0;
    film_exr_read_check(exr_initialize_required_attr(exr, 0, &window, &window, 1.0f, &centre, 1.0f,
                                                     EXR_LINEORDER_INCREASING_Y, f->compression));
    if (f->tiled)
        film_exr_read_check(
            exr_set_tile_descriptor(exr, 0, TILE, TILE, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN));
    static const char *const names[] = {"B", "G", "R"};
    for (int c = 0; c < 3; c++)
        film_exr_read_check(
            exr_add_channel(exr, 0, names[c], f->type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    film_exr_read_check(exr_attr_set_string(exr, 0, "comments", "made by a test"));
    film_exr_read_check(exr_write_header(exr));
    film_exr_read_put_pixels(exr, f);
    film_exr_read_check(exr_finish(&exr));
}

// All hold the values exactly (PXR24 drops bits that they do not have).
static void every_kind_of_file_is_read(void **state) {
    (void)state;
    static const exr_compression_t methods[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                                EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                                EXR_COMPRESSION_PIZ,  EXR_COMPRESSION_PXR24};
    enum { METHODS = sizeof methods / sizeof *methods };
    for (int i = 0; i < METHODS * 3 * 2; i++) {
        struct sample_file f = {methods[i % METHODS], (exr_pixel_type_t)(i / METHODS % 3),
                                i / METHODS / 3};
        make_file(&f, "kind.exr");
        struct satin_film *film = NULL;
        assert_int_equal(satin_film_read("kind.exr", NULL, NULL, &film), SATIN_OK);
        assert_int_equal(film->width, WIDTH);
        assert_int_equal(film->height, HEIGHT);
        assert_int_equal(film->attribute_count, 1);
        assert_string_equal(film_attribute_get(film, "comments"), "made by a test");
        for (int c = 0; c < 3; c++) {
            const float *channel = satin_film_channel(film, c == 0 ? "B" : c == 1 ? "G" : "R");
            for (int p = 0; p < WIDTH * HEIGHT; p++) {
                float want = (float)film_exr_read_value_at(c, p % WIDTH, p / WIDTH);
                assert_true(channel[p] == want);
            }
        }
        satin_film_free(film);
    }
    unlink("kind.exr");
}

static char *file_bytes(const struct sample_file *f, size_t *size) {
    char *data = NULL;
    make_file(f, "bytes.exr");
    assert_int_equal(
        fileio_read((struct log){0}, (struct log_place){0}, "bytes.exr", 1 << 20, &data, size),
        SATIN_OK);
    unlink("bytes.exr");
    return data;
}

// A long attribute is none of the many that would take long to sort.
static void long_attributes_are_read(void **state) {
    (void)state;
    enum { LENGTH = 3 << 20 };
    static const char *const names[] = {"Y"};
    char *text = malloc(LENGTH + 1);
    satin_film *film = film_new(2, 1, names, 1), *back = NULL;
    assert_true(text && film);
    memset(text, 'x', LENGTH);
    text[LENGTH] = 0;
    film->channel[0][1] = 0.5f;
    assert_true(film_attribute_set(film, "long", text));
    assert_int_equal(satin_film_write_exr(film, "long.exr", NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read("long.exr", NULL, NULL, &back), SATIN_OK);
    assert_string_equal(film_attribute_get(back, "long"), text);
    assert_true(back->channel[0][1] == 0.5f);
    satin_film_free(film);
    satin_film_free(back);
    free(text);
    unlink("long.exr");
}

static void b44_is_refused(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        const struct sample_file f = {i ? EXR_COMPRESSION_B44A : EXR_COMPRESSION_B44,
                                      EXR_PIXEL_HALF, false};
        struct message message = {0};
        struct satin_film *film = NULL;
        make_file(&f, "b44.exr");
        assert_int_equal(satin_film_read("b44.exr", keep, &message, &film), SATIN_ERROR_INPUT);
        assert_string_equal(message.text, "b44.exr: B44 compression is not supported");
    }
    unlink("b44.exr");
}

// The library reports some damage of PIZ as a lack of memory.
static void damaged_piz_is_no_lack_of_memory(void **state) {
    (void)state;
    size_t size;
    int refused = 0;
    char *data =
        file_bytes(&(struct sample_file){EXR_COMPRESSION_PIZ, EXR_PIXEL_HALF, false}, &size);
    for (size_t n = size / 2; n < size; n++) {
        struct message message = {0};
        struct satin_film *film = NULL;
        const char whole = data[n];
        data[n] = (char)~whole;
        const satin_status status =
            film_parse_exr(data, size, "piz.exr", (struct log){keep, &message}, &film);
        data[n] = whole;
        assert_true(status == SATIN_OK || status == SATIN_ERROR_INPUT);
        refused += status == SATIN_ERROR_INPUT;
        satin_film_free(film);
    }
    assert_true(refused > 0);
    free(data);
}

// A file that is cut at any byte is refused in one line.
static void files_that_end_early_are_refused(void **state) {
    (void)state;
    for (int tiled = 0; tiled < 2; tiled++) {
        size_t size;
        char *data = file_bytes(
            &(struct sample_file){EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, tiled == 1}, &size);
        for (size_t n = 0; n < size; n += n < 600 ? 1 : 97) {
            struct message message = {0};
            struct satin_film *film = NULL;
            char *part = malloc(n ? n : 1);
            memcpy(part, data, n);
            assert_int_equal(
                film_parse_exr(part, n, "cut.exr", (struct log){keep, &message}, &film),
                SATIN_ERROR_INPUT);
            assert_null(film);
            assert_int_equal(message.count, 1);
            assert_true(strncmp(message.text, "cut.exr: ", 9) == 0);
            free(part);
        }
        free(data);
    }
}

// A file with a flipped byte is read or refused, without a crash.
static void flipped_bytes_are_harmless(void **state) {
    (void)state;
    size_t size;
    char *data =
        file_bytes(&(struct sample_file){EXR_COMPRESSION_PIZ, EXR_PIXEL_HALF, true}, &size);
    struct rng rng = rng_make(3, RNG_TEST, 0);
    for (int i = 0; i < 3000; i++) {
        size_t at = rng_u32(&rng) % (i & 1 ? size : 500);
        char old = data[at];
        data[at] = (char)rng_u32(&rng);
        struct satin_film *film = NULL;
        if (film_parse_exr(data, size, "flip.exr", (struct log){0}, &film) == SATIN_OK)
            satin_film_free(film);
        data[at] = old;
    }
    free(data);
}

static void sizes_beyond_the_file_are_refused(void **state) {
    (void)state;
    size_t size;
    char *data =
        file_bytes(&(struct sample_file){EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, false}, &size);
    static const char key[] = "dataWindow\0box2i";
    char *box = memmem(data, size, key, sizeof key);
    assert_non_null(box);
    static const int32_t windows[][4] = {{0, 0, 0x7fffffff, 0x7fffffff},
                                         {-0x7fffffff, -0x7fffffff, 0x7fffffff, 0x7fffffff},
                                         {0, 0, 99999, 99999},
                                         {0, 0, 65535, 15},
                                         {5, 5, 4, 4}};
    for (int i = 0; i < 5; i++) {
        struct message message = {0};
        struct satin_film *film = NULL;
        memcpy(box + sizeof key + 4, windows[i], 16);
        assert_int_equal(film_parse_exr(data, size, "big.exr", (struct log){keep, &message}, &film),
                         SATIN_ERROR_INPUT);
        assert_int_equal(message.count, 1);
    }
    free(data);
}

static void a_missing_file_is_refused(void **state) {
    (void)state;
    struct message message = {0};
    struct satin_film *film = NULL;
    assert_int_equal(satin_film_read("missing.exr", keep, &message, &film), SATIN_ERROR_INPUT);
    assert_int_equal(satin_film_read("/tmp", keep, &message, &film), SATIN_ERROR_INPUT);
    assert_int_equal(message.count, 2);
    assert_int_equal(film_parse_exr("<scene/>", 8, "x.exr", (struct log){keep, &message}, &film),
                     SATIN_ERROR_INPUT);
    assert_string_equal(message.text, "x.exr: it is not an OpenEXR file");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_of_file_is_read),
        cmocka_unit_test(long_attributes_are_read),
        cmocka_unit_test(b44_is_refused),
        cmocka_unit_test(damaged_piz_is_no_lack_of_memory),
        cmocka_unit_test(files_that_end_early_are_refused),
        cmocka_unit_test(flipped_bytes_are_harmless),
        cmocka_unit_test(sizes_beyond_the_file_are_refused),
        cmocka_unit_test(a_missing_file_is_refused),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
