// SPDX-License-Identifier: Apache-2.0
// Reads JPEG files by libjpeg, whose errors become one message instead of lines on standard error.
// The files are untrusted: a file that is cut short is refused, and so is one of so many scans that
// it would take minutes. Those of four components are left to the module on OpenImageIO.
#include <limits.h>
#include <setjmp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jerror.h>
#include <jpeglib.h>

#include "load/load_image_reader.h"

enum { SCANS_MOST = 256 };  // a progressive file has some ten

struct jpeg_input {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_progress_mgr progress;
    bool damaged;
    char problem[JMSG_LENGTH_MAX];
    jmp_buf failed;
};

// ---- What libjpeg calls -------------------------------------------------------------------------

static void on_jpeg_error(j_common_ptr jpeg) {
    struct jpeg_input *input = jpeg->client_data;
    jpeg->err->format_message(jpeg, input->problem);
    longjmp(input->failed, 1);
}

// Notes the first warning but that of surplus bytes, which are common and harmless. Other messages
// have 0 and more.
static void on_jpeg_message(j_common_ptr jpeg, int severity) {
    struct jpeg_input *input = jpeg->client_data;
    if (severity >= 0 || input->damaged || jpeg->err->msg_code == JWRN_EXTRANEOUS_DATA) return;
    input->damaged = true;
    jpeg->err->format_message(jpeg, input->problem);
}

static void on_jpeg_progress(j_common_ptr jpeg) {
    struct jpeg_input *input = jpeg->client_data;
    if (input->jpeg.input_scan_number <= SCANS_MOST) return;
    snprintf(input->problem, sizeof input->problem, "it has too many scans");
    longjmp(input->failed, 1);
}

// ---- The reader ---------------------------------------------------------------------------------

static enum reader_result report_jpeg(const struct jpeg_input *input, char *error, size_t size) {
    const bool no_memory = input->errors.msg_code == JERR_OUT_OF_MEMORY;
    if (no_memory)
        snprintf(error, size, "not enough memory to unpack it");
    else
        snprintf(error, size, "the JPEG is damaged: %.200s", input->problem);
    return no_memory ? READER_NO_MEMORY : READER_FAILED;
}

// Reads the header. False if libjpeg reports an error. The caller frees the input in either case.
static bool read_jpeg_header(struct jpeg_input *input, const struct image_data *file) {
    input->jpeg.err = jpeg_std_error(&input->errors);
    input->jpeg.client_data = input;
    input->errors.error_exit = on_jpeg_error;
    input->errors.emit_message = on_jpeg_message;
    if (setjmp(input->failed)) return false;
    jpeg_create_decompress(&input->jpeg);
    input->progress.progress_monitor = on_jpeg_progress;
    input->jpeg.progress = &input->progress;
    jpeg_mem_src(&input->jpeg, (const unsigned char *)file->data, (unsigned long)file->size);
    jpeg_read_header(&input->jpeg, TRUE);
    input->jpeg.out_color_space = input->jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    return true;
}

static void free_jpeg(struct jpeg_input *input) {
    jpeg_destroy_decompress(&input->jpeg);
    free(input);
}

// Huffman codes have at least one bit for each block. Without all of these a file is damaged, and
// found to be so before its image takes memory.
static bool has_all_blocks(const struct jpeg_decompress_struct *jpeg, size_t bytes) {
    const size_t columns = ((size_t)jpeg->image_width + DCTSIZE - 1) / DCTSIZE,
                 rows = ((size_t)jpeg->image_height + DCTSIZE - 1) / DCTSIZE;
    return jpeg->arith_code || CHAR_BIT * bytes >= columns * rows;
}

static enum reader_result open_jpeg(const struct image_data *file, struct opened_image *out,
                                    char *error, size_t size) {
    struct jpeg_input *input = calloc(1, sizeof *input);
    if (!input) {
        snprintf(error, size, "not enough memory to unpack it");
        return READER_NO_MEMORY;
    }
    if (!read_jpeg_header(input, file)) {
        const enum reader_result result = report_jpeg(input, error, size);
        free_jpeg(input);
        return result;
    }
    if (!has_all_blocks(&input->jpeg, file->size)) {
        snprintf(error, size, "the JPEG is damaged: it has fewer bits than blocks");
        free_jpeg(input);
        return READER_FAILED;
    }
    *out = (struct opened_image){.input = input,
                                 .width = (int)input->jpeg.image_width,
                                 .height = (int)input->jpeg.image_height,
                                 .channels = input->jpeg.num_components == 1 ? 1 : 3,
                                 .bytes = true,
                                 .srgb = true};
    return READER_DONE;
}

// Reads all rows, one after another from `rows` on. False if libjpeg reports an error.
static bool read_jpeg_rows(struct jpeg_input *input, unsigned char *rows, size_t row_bytes) {
    if (setjmp(input->failed)) return false;
    struct jpeg_decompress_struct *jpeg = &input->jpeg;
    jpeg_start_decompress(jpeg);
    while (jpeg->output_scanline < jpeg->output_height) {
        JSAMPROW row = rows + jpeg->output_scanline * row_bytes;
        jpeg_read_scanlines(jpeg, &row, 1);
    }
    jpeg_finish_decompress(jpeg);
    return !input->damaged;
}

static enum reader_result read_jpeg(struct opened_image *image, void *values, char *error,
                                    size_t size) {
    struct jpeg_input *input = image->input;
    const size_t row = (size_t)image->width * (size_t)image->channels;
    return read_jpeg_rows(input, values, row) ? READER_DONE : report_jpeg(input, error, size);
}

static void close_jpeg(struct opened_image *image) {
    free_jpeg(image->input);
    image->input = NULL;
}

const struct image_reader load_image_jpeg = {open_jpeg, read_jpeg, close_jpeg};

int load_image_is_jpeg(const struct image_data *file) {
    if (file->size < 3 || memcmp(file->data, "\xff\xd8\xff", 3) != 0) return false;
    struct jpeg_input *input = calloc(1, sizeof *input);
    if (!input) return true;
    const bool four = read_jpeg_header(input, file) && input->jpeg.num_components == 4;
    free_jpeg(input);
    return !four;
}
