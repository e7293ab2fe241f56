// SPDX-License-Identifier: Apache-2.0
// Reads PNG files by libpng, whose errors become one message instead of lines on standard error.
// The files are untrusted: every checksum is checked; chunks that no texel depends on are skipped,
// so that none can unpack to more than the image; and libpng's own limits apply (a million pixels a
// side).
#include <limits.h>
#include <png.h>
#include <setjmp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/load_image_reader.h"

struct png_input {
    png_structp png;
    png_infop info;
    const unsigned char *at, *end;  // the part of the file that libpng has not read yet
    size_t width, height, channels;
    int bits;  // bits per value, 8 or 16
    bool no_memory;
    char problem[128];
    jmp_buf failed;
};

// ---- What libpng calls --------------------------------------------------------------------------

_Noreturn static void on_error(png_structp png, png_const_charp message) {
    struct png_input *input = png_get_error_ptr(png);
    snprintf(input->problem, sizeof input->problem, "%s", message);
    longjmp(input->failed, 1);
}

// Ignores warnings: libpng can read the file in spite of them, and they change no texel.
static void on_warning(png_structp png, png_const_charp message) { (void)png, (void)message; }

static png_voidp on_allocate(png_structp png, png_alloc_size_t size) {
    struct png_input *input = png_get_mem_ptr(png);
    void *memory = malloc(size);
    input->no_memory = input->no_memory || !memory;
    return memory;
}

static void on_free(png_structp png, png_voidp memory) {
    (void)png;
    free(memory);
}

static void on_read(png_structp png, png_bytep out, size_t size) {
    struct png_input *input = png_get_io_ptr(png);
    if (size > (size_t)(input->end - input->at)) png_error(png, "the file is cut short");
    memcpy(out, input->at, size);
    input->at += size;
}

// ---- The reader ---------------------------------------------------------------------------------

static enum reader_result report(const struct png_input *input, char *error, size_t size) {
    if (input->no_memory)
        snprintf(error, size, "not enough memory to unpack it");
    else
        snprintf(error, size, "the PNG is damaged: %s", input->problem);
    return input->no_memory ? READER_NO_MEMORY : READER_FAILED;
}

static void free_input(struct png_input *input) {
    png_destroy_read_struct(&input->png, &input->info, NULL);
    free(input);
}

// Whether values are encoded by the transfer function of sRGB, as OpenImageIO assumes, unless the
// file says by a gamma of 1 (to the hundredth) that they are linear.
static bool is_encoded(const struct png_input *input) {
    int intent;
    double exponent;
    if (png_get_sRGB(input->png, input->info, &intent)) return true;
    return !png_get_gAMA(input->png, input->info, &exponent) ||
           !(exponent > 1.0 / 1.005 && exponent < 1.0 / 0.995);
}

// Reads the header. False if libpng reports an error.
static bool read_png_header(struct png_input *input, bool alpha) {
    if (setjmp(input->failed)) return false;
    png_structp png = input->png;
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    // A negative count stands for all chunks except pixels, palette and transparency.
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, NULL, -1);
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_AS_DEFAULT, (png_const_bytep) "gAMA\0sRGB",
                                2);
    if (!alpha)
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, (png_const_bytep) "tRNS", 1);
    png_set_read_fn(png, input, on_read);
    png_read_info(png, input->info);
    const unsigned color = png_get_color_type(png, input->info);
    input->width = png_get_image_width(png, input->info);
    input->height = png_get_image_height(png, input->info);
    input->channels = color & PNG_COLOR_MASK_COLOR ? 3 : 1;
    input->bits = png_get_bit_depth(png, input->info) == 16 ? 16 : 8;
    png_set_expand(png);  // palettes to colours, less than 8 bits to 8
    const bool has_alpha =
        color & PNG_COLOR_MASK_ALPHA || png_get_valid(png, input->info, PNG_INFO_tRNS);
    if (alpha && has_alpha)
        input->channels++;
    else
        png_set_strip_alpha(png);
    return true;
}

static enum reader_result open_png(const struct image_data *file, struct opened_image *out,
                                   char *error, size_t size) {
    struct png_input *input = calloc(1, sizeof *input);
    if (input)
        input->png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, input, on_error, on_warning,
                                              input, on_allocate, on_free);
    if (input && input->png) input->info = png_create_info_struct(input->png);
    if (!input || !input->info) {
        if (input) free_input(input);
        snprintf(error, size, "not enough memory to unpack it");
        return READER_NO_MEMORY;
    }
    input->at = (const unsigned char *)file->data;
    input->end = input->at + file->size;
    if (!read_png_header(input, file->alpha)) {
        const enum reader_result result = report(input, error, size);
        free_input(input);
        return result;
    }
    *out = (struct opened_image){.input = input,
                                 .width = (int)input->width,
                                 .height = (int)input->height,
                                 .channels = (int)input->channels,
                                 .bytes = input->bits == 8,
                                 .srgb = is_encoded(input)};
    return READER_DONE;
}

// Reads all rows in the format of the file, one after another from `rows` on. False if libpng
// reports an error. The chunks after the pixels are read too, so that a truncated file is refused.
static bool read_rows(struct png_input *input, unsigned char *rows, size_t row_bytes) {
    if (setjmp(input->failed)) return false;
    const int passes = png_set_interlace_handling(input->png);
    png_read_update_info(input->png, input->info);
    if (png_get_rowbytes(input->png, input->info) != row_bytes)
        png_error(input->png, "rows of an unexpected length");
    for (int pass = 0; pass < passes; pass++)
        for (size_t y = 0; y < input->height; y++)
            png_read_row(input->png, rows + y * row_bytes, NULL);
    png_read_end(input->png, NULL);
    return true;
}

static enum reader_result read_png(struct opened_image *image, void *values, char *error,
                                   size_t size) {
    struct png_input *input = image->input;
    const size_t row = input->width * input->channels, count = row * input->height;
    if (image->bytes)
        return read_rows(input, values, row) ? READER_DONE : report(input, error, size);
    // The 16-bit values are read into the end of the array and are converted from its front. A
    // texel overwrites only the value from which it is made and values before that.
    float *texel = values;
    const unsigned char *from = (unsigned char *)texel + count * (sizeof *texel - 2);
    if (!read_rows(input, (unsigned char *)from, 2 * row)) return report(input, error, size);
    for (size_t i = 0; i < count; i++, from += 2)
        texel[i] = (float)(from[0] << 8 | from[1]) * (1.0f / USHRT_MAX);
    return READER_DONE;
}

static void close_png(struct opened_image *image) {
    free_input(image->input);
    image->input = NULL;
}

const struct image_reader load_image_png = {open_png, read_png, close_png};

int load_image_is_png(const struct image_data *file) {
    static const char signature[] = "\x89PNG\r\n\x1a\n";
    return file->size >= sizeof signature - 1 &&
           memcmp(file->data, signature, sizeof signature - 1) == 0;
}
