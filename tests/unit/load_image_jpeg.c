// SPDX-License-Identifier: Apache-2.0
// JPEG files: grey and colours, sequential and progressive, and one message for each kind of
// damage; libjpeg prints no messages of its own on standard error.
#include <stdio.h>
#include <stdlib.h>

#include <jpeglib.h>

#include "load/load_image_reader.h"
#include "mesh_case.h"

enum { WIDTH = 24, HEIGHT = 16 };

struct jpeg_file {
    unsigned char *byte;
    unsigned long size;
};

static unsigned char pixel_value(int x, int y, int c) {
    return (unsigned char)(40 + 5 * x + 3 * y + 20 * c);
}

// A smooth image of 1, 3 or 4 components, with little loss.
static struct jpeg_file make_jpeg(int components, bool progressive) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_file file = {NULL, 0};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &file.byte, &file.size);
    jpeg.image_width = WIDTH;
    jpeg.image_height = HEIGHT;
    jpeg.input_components = components;
    jpeg.in_color_space = components == 1 ? JCS_GRAYSCALE : components == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    for (int c = 0; c < components; c++)
        jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = 1;
    if (progressive) jpeg_simple_progression(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    for (int y = 0; y < HEIGHT; y++) {
        unsigned char row[4 * WIDTH];
        JSAMPROW rows = row;
        for (int i = 0; i < WIDTH * components; i++)
            row[i] = pixel_value(i / components, y, i % components);
        jpeg_write_scanlines(&jpeg, &rows, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return file;
}

static satin_status load_jpeg(const struct jpeg_file *jpeg, struct scene_case *log,
                              struct arena *arena, bool *module, struct image **image) {
    scene_case_bytes("a.jpg", jpeg->byte, jpeg->size);
    *arena = (struct arena){0};
    struct load_source source = {scene_case_begin(log), {"scene.xml", 3, 7}, arena, "a.jpg", NULL};
    struct load_images images = {.arena = arena};
    const satin_status status = load_image(&source, &images, true, image);
    *module = images.module;
    assert_int_equal(log->errors, status != SATIN_OK);
    return status;
}

static void refuse_jpeg(const struct jpeg_file *jpeg, const char *problem) {
    struct scene_case log;
    struct arena arena;
    struct image *image = NULL;
    bool module;
    char message[256];
    assert_int_equal(load_jpeg(jpeg, &log, &arena, &module, &image), SATIN_ERROR_INPUT);
    snprintf(message, sizeof message, "scene.xml:3:7: cannot read image 'a.jpg': %s", problem);
    assert_string_equal(log.error, message);
    arena_free(&arena);
}

static void check_pixels(const struct jpeg_file *jpeg, int channels) {
    struct scene_case log;
    struct arena arena;
    struct image *image;
    bool module;
    assert_int_equal(load_jpeg(jpeg, &log, &arena, &module, &image), SATIN_OK);
    assert_false(module);
    assert_true(image->width == WIDTH && image->height == HEIGHT && image->channels == channels);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            for (int c = 0; c < channels; c++)
                assert_float_equal(scene_image_value(image, (y * WIDTH + x) * channels + c),
                                   (float)pixel_value(x, y, c) / 255.0f, 3.0f / 255.0f);
    arena_free(&arena);
}

static void grey_and_colours_are_read(void **state) {
    (void)state;
    for (int components = 1; components <= 3; components += 2)
        for (int progressive = 0; progressive < 2; progressive++) {
            struct jpeg_file jpeg = make_jpeg(components, progressive);
            check_pixels(&jpeg, components);
            free(jpeg.byte);
        }
}

static void values_are_encoded(void **state) {
    (void)state;
    struct jpeg_file jpeg = make_jpeg(1, false);
    const struct image_data file = {"a.jpg", (char *)jpeg.byte, jpeg.size, 1};
    struct opened_image opened;
    char error[128];
    assert_true(load_image_is_jpeg(&file));
    assert_int_equal(load_image_jpeg.open(&file, &opened, error, sizeof error), READER_DONE);
    assert_true(opened.srgb && opened.channels == 1);  // there is no alpha
    load_image_jpeg.close(&opened);
    free(jpeg.byte);
}

static void surplus_bytes_are_harmless(void **state) {
    (void)state;
    struct jpeg_file jpeg = make_jpeg(3, false), longer = {malloc(jpeg.size + 7), jpeg.size + 7};
    assert_non_null(longer.byte);
    // Before the last marker, and after it.
    memset(longer.byte, 0, longer.size);
    memcpy(longer.byte, jpeg.byte, jpeg.size - 2);
    memcpy(longer.byte + jpeg.size + 2, jpeg.byte + jpeg.size - 2, 2);
    check_pixels(&longer, 3);
    free(jpeg.byte);
    free(longer.byte);
}

static void damaged_jpeg_files_are_refused(void **state) {
    (void)state;
    struct jpeg_file jpeg = make_jpeg(3, false);
    struct jpeg_file part = {jpeg.byte, jpeg.size - 40};
    refuse_jpeg(&part, "the JPEG is damaged: Premature end of JPEG file");
    part.size = 3;
    refuse_jpeg(&part, "the JPEG is damaged: JPEG datastream contains no image");
    // The end of the image in its middle.
    jpeg.byte[jpeg.size - 60] = 0xff;
    jpeg.byte[jpeg.size - 59] = 0xd9;
    refuse_jpeg(&jpeg, "the JPEG is damaged: Corrupt JPEG data: premature end of data segment");
    free(jpeg.byte);
}

// A few hundred bytes that promise 66 million pixels.
static void promised_pixels_take_no_memory(void **state) {
    (void)state;
    struct jpeg_file jpeg = make_jpeg(1, true);
    size_t frame = 0;
    while (!(jpeg.byte[frame] == 0xff && jpeg.byte[frame + 1] == 0xc2)) frame++;
    assert_true(jpeg.byte[frame + 6] == HEIGHT && jpeg.byte[frame + 8] == WIDTH);
    jpeg.byte[frame + 5] = 8;
    jpeg.byte[frame + 7] = 128;
    refuse_jpeg(&jpeg, "the JPEG is damaged: it has fewer bits than blocks");
    free(jpeg.byte);
}

// The last scan of a progressive file, hundreds of times.
static void scans_are_bounded(void **state) {
    (void)state;
    enum { TIMES = 400 };
    struct jpeg_file jpeg = make_jpeg(1, true);
    size_t scan = jpeg.size - 2;
    while (scan > 0 && !(jpeg.byte[scan] == 0xff && jpeg.byte[scan + 1] == 0xda)) scan--;
    const size_t length = jpeg.size - 2 - scan;
    struct jpeg_file many = {malloc(jpeg.size + TIMES * length), jpeg.size + TIMES * length};
    assert_non_null(many.byte);
    memcpy(many.byte, jpeg.byte, scan);
    for (size_t i = 0; i <= TIMES; i++)
        memcpy(many.byte + scan + i * length, jpeg.byte + scan, length);
    memcpy(many.byte + many.size - 2, jpeg.byte + jpeg.size - 2, 2);
    refuse_jpeg(&many, "the JPEG is damaged: it has too many scans");
    free(many.byte);
    free(jpeg.byte);
}

static void four_components_are_left_to_the_module(void **state) {
    (void)state;
    struct jpeg_file jpeg = make_jpeg(4, false);
    const struct image_data file = {"a.jpg", (char *)jpeg.byte, jpeg.size, 0};
    struct scene_case log;
    struct arena arena;
    struct image *image;
    bool module;
    assert_false(load_image_is_jpeg(&file));
    assert_int_equal(load_jpeg(&jpeg, &log, &arena, &module, &image), SATIN_OK);
    assert_true(module && image->channels == 3);
    arena_free(&arena);
    free(jpeg.byte);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grey_and_colours_are_read),
        cmocka_unit_test(values_are_encoded),
        cmocka_unit_test(surplus_bytes_are_harmless),
        cmocka_unit_test(damaged_jpeg_files_are_refused),
        cmocka_unit_test(promised_pixels_take_no_memory),
        cmocka_unit_test(scans_are_bounded),
        cmocka_unit_test(four_components_are_left_to_the_module),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
