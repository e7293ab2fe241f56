// SPDX-License-Identifier: Apache-2.0
// Reads OpenEXR from memory by the C functions of OpenEXR.
#include "base/exrfile.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const int64_t VALUES_MAX = (int64_t)1 << 31;  // 8 GB of floats
enum {
    HEADER_MAX = 1 << 20,  // the library sorts attributes by insertion, in quadratic time
    PIECE_MAX = 4096,      // that the library reads at once but for values of long attributes
    CHANNELS_MAX = 1024,
    WIDTH_MAX = 1 << 28,  // the library counts the bytes of a line by int32
    RATIO_MAX = 2048      // more than any method compresses: PXR24 with zlib has 1376
};

// ---- What the library calls ---------------------------------------------------------------------

// Whether memory that the library asked for was missing, in the current call of it.
static _Thread_local bool allocation_failed;

static void *exr_allocate(size_t bytes) {
    void *memory = malloc(bytes);
    allocation_failed = allocation_failed || !memory;
    return memory;
}

// Whether a code says that there is no memory. PIZ says so of damaged data, too.
static bool means_no_memory(const struct exrfile *file, exr_result_t code) {
    return code == EXR_ERR_OUT_OF_MEMORY &&
           (allocation_failed || file->compression != EXR_COMPRESSION_PIZ);
}

// Stores the message, which would otherwise go to standard error.
static void note_error(exr_const_context_t exr, exr_result_t code, const char *message) {
    void *user = NULL;
    (void)message;
    if (exr_get_user_data(exr, &user) != EXR_ERR_SUCCESS || !user) return;
    struct exrfile *file = user;
    file->no_memory = file->no_memory || means_no_memory(file, code);
}

static int64_t memory_size(exr_const_context_t exr, void *user) {
    (void)exr;
    return (int64_t)((struct exrfile *)user)->size;
}

static int64_t memory_read(exr_const_context_t exr, void *user, void *buffer, uint64_t bytes,
                           uint64_t offset, exr_stream_error_func_ptr_t error) {
    struct exrfile *r = user;
    (void)exr;
    (void)error;
    if (r->in_header && bytes <= PIECE_MAX) r->header_bytes += bytes;
    if (offset >= r->size || r->header_bytes > HEADER_MAX) return 0;
    if (bytes > r->size - offset) bytes = r->size - offset;
    memcpy(buffer, r->data + offset, bytes);
    return (int64_t)bytes;
}

// ---- The header ---------------------------------------------------------------------------------

static satin_status exr_problem(struct exrfile *file, const char *what, const char *problem) {
    snprintf(file->problem, sizeof file->problem, "%s%s", what, problem);
    return SATIN_ERROR_INPUT;
}

satin_status exrfile_no_memory(struct exrfile *file) {
    exr_problem(file, "", "not enough memory");
    return SATIN_ERROR_MEMORY;
}

static satin_status exr_other(struct exrfile *file, const char *problem) {
    file->other = true;
    return exr_problem(file, "", problem);
}

static satin_status exr_problem_code(struct exrfile *file, const char *what, exr_result_t code) {
    if (file->no_memory || means_no_memory(file, code)) return exrfile_no_memory(file);
    if (code == EXR_ERR_OUT_OF_MEMORY) code = EXR_ERR_CORRUPT_CHUNK;
    return exr_problem(file, what, exr_get_default_error_message(code));
}

static satin_status open_header(struct exrfile *file, const char *name) {
    static const unsigned char magic[4] = {0x76, 0x2f, 0x31, 0x01};
    if (file->size < sizeof magic || memcmp(file->data, magic, sizeof magic) != 0)
        return exr_other(file, "it is not an OpenEXR file");
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = note_error;
    init.alloc_fn = exr_allocate;
    init.user_data = file;
    init.read_fn = memory_read;
    init.size_fn = memory_size;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    file->in_header = true;
    const exr_result_t code = exr_start_read(&file->exr, name, &init);
    file->in_header = false;
    return code == EXR_ERR_SUCCESS ? SATIN_OK
                                   : exr_problem_code(file, "invalid OpenEXR header: ", code);
}

// The first feature of the file that is not supported, by name; NULL if there is none.
static const char *unsupported(exr_storage_t storage, exr_compression_t compression,
                               const exr_attr_chlist_t *channels) {
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return "deep images are not supported";
    if (compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB)
        return "DWA compression is not supported";
    // The library's own C functions unpack these wrongly: float values, and chunks of one row.
    if (compression == EXR_COMPRESSION_B44 || compression == EXR_COMPRESSION_B44A)
        return "B44 compression is not supported";
    if (compression > EXR_COMPRESSION_B44A) return "its compression is not supported";
    if (channels->num_channels < 1) return "it has no channels";
    if (channels->num_channels > CHANNELS_MAX) return "it has too many channels";
    for (int i = 0; i < channels->num_channels; i++)
        if (channels->entries[i].x_sampling != 1 || channels->entries[i].y_sampling != 1)
            return "subsampled channels are not supported";
    return NULL;
}

// Reads the size of the image and checks it against the size of the file.
static const char *read_size(struct exrfile *file) {
    const exr_attr_chlist_t *channels = file->channels;
    int64_t width = (int64_t)file->window.max.x - file->window.min.x + 1;
    int64_t height = (int64_t)file->window.max.y - file->window.min.y + 1, bytes = 0;
    if (width < 1 || height < 1) return "its data window is empty";
    if (width > WIDTH_MAX || width > VALUES_MAX / channels->num_channels / height)
        return "it is too large";
    for (int i = 0; i < channels->num_channels; i++)
        bytes += channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    if (width * height > (int64_t)(file->size * RATIO_MAX) / bytes)
        return "it is too short for the size that its header states";
    file->width = (int)width;
    file->height = (int)height;
    return NULL;
}

satin_status exrfile_open(struct exrfile *file, const char *name, const void *data, size_t size) {
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    allocation_failed = false;
    *file = (struct exrfile){.data = data, .size = size};
    const satin_status status = open_header(file, name);
    if (status != SATIN_OK) return status;
    exr_result_t code = exr_get_storage(file->exr, 0, &storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_compression(file->exr, 0, &file->compression);
    if (code == EXR_ERR_SUCCESS) code = exr_get_channels(file->exr, 0, &file->channels);
    if (code == EXR_ERR_SUCCESS) code = exr_get_data_window(file->exr, 0, &file->window);
    if (code != EXR_ERR_SUCCESS) return exr_problem_code(file, "invalid OpenEXR header: ", code);
    const char *why = unsupported(storage, file->compression, file->channels);
    if (why) return exr_other(file, why);
    why = read_size(file);
    if (why) return exr_problem(file, "", why);
    file->tiled = storage == EXR_STORAGE_TILED;
    return SATIN_OK;
}

void exrfile_close(struct exrfile *file) {
    free(file->scratch);
    if (file->exr) exr_finish(&file->exr);
}

// ---- Pixels -------------------------------------------------------------------------------------

// The library would mix interleaved channels up, and may crash without memory for one that is not
// read: these are written to planes of scratch.
static bool needs_plane(const struct exrfile_channel *to) { return to->column != 1; }

static bool make_scratch(struct exrfile *file, const struct exrfile_channel *to,
                         const exr_chunk_info_t *info) {
    size_t planes = 1;  // the first one for all that are not read
    for (int c = 0; c < file->channels->num_channels; c++)
        planes += to[c].first && needs_plane(&to[c]);
    const size_t count = planes * (size_t)info->width * (size_t)info->height;
    if (count <= file->scratch_count) return true;
    free(file->scratch);
    file->scratch = malloc(count * sizeof *file->scratch);
    file->scratch_count = file->scratch ? count : 0;
    return file->scratch != NULL;
}

// Copies the values of a chunk, with its corner at (x, y), from their planes to where they belong.
static void copy_planes(const struct exrfile *file, const struct exrfile_channel *to,
                        const exr_chunk_info_t *info, size_t x, size_t y) {
    const float *plane = file->scratch;
    const size_t w = (size_t)info->width, h = (size_t)info->height;
    for (int c = 0; c < file->channels->num_channels; c++) {
        if (!to[c].first || !needs_plane(&to[c])) continue;
        plane += w * h;
        for (size_t j = 0; j < h; j++) {
            float *row = to[c].first + (y + j) * to[c].row + x * to[c].column;
            for (size_t i = 0; i < w; i++) row[i * to[c].column] = plane[j * w + i];
        }
    }
}

// Decodes one chunk, with its corner at (x, y) from that of the window.
static exr_result_t decode_chunk(struct exrfile *file, const struct exrfile_channel *to,
                                 const exr_chunk_info_t *info, int64_t x, int64_t y) {
    if (x < 0 || y < 0 || x + info->width > file->width || y + info->height > file->height)
        return EXR_ERR_CORRUPT_CHUNK;
    if (!make_scratch(file, to, info)) return EXR_ERR_OUT_OF_MEMORY;
    const size_t plane_size = (size_t)info->width * (size_t)info->height;
    float *plane = file->scratch;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code = exr_decoding_initialize(file->exr, 0, info, &pipe);
    for (int c = 0; code == EXR_ERR_SUCCESS && c < pipe.channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipe.channels[c];
        const bool direct = to[c].first && !needs_plane(&to[c]);
        const size_t row = direct ? to[c].row : (size_t)info->width;
        float *corner = direct        ? to[c].first + (size_t)y * row + (size_t)x
                        : to[c].first ? (plane += plane_size)
                                      : file->scratch;
        channel->user_bytes_per_element = sizeof *corner;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof *corner;
        channel->user_line_stride = (int32_t)(row * sizeof *corner);
        channel->decode_to_ptr = (uint8_t *)corner;
    }
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_choose_default_routines(file->exr, 0, &pipe);
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(file->exr, 0, &pipe);
    if (code == EXR_ERR_SUCCESS) copy_planes(file, to, info, (size_t)x, (size_t)y);
    exr_decoding_destroy(file->exr, &pipe);
    return code;
}

static satin_status read_scanlines(struct exrfile *file, const struct exrfile_channel *to) {
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(file->exr, 0, &lines);
    if (code == EXR_ERR_SUCCESS && lines < 1) code = EXR_ERR_FILE_BAD_HEADER;
    for (int64_t y = 0; code == EXR_ERR_SUCCESS && y < file->height; y += lines) {
        exr_chunk_info_t info;
        code = exr_read_scanline_chunk_info(file->exr, 0, (int)(file->window.min.y + y), &info);
        if (code == EXR_ERR_SUCCESS) code = decode_chunk(file, to, &info, 0, y);
    }
    return code == EXR_ERR_SUCCESS ? SATIN_OK : exr_problem_code(file, "invalid pixels: ", code);
}

static satin_status read_tiles(struct exrfile *file, const struct exrfile_channel *to) {
    int32_t w = 0, h = 0;
    exr_result_t code = exr_get_tile_sizes(file->exr, 0, 0, 0, &w, &h);
    if (code == EXR_ERR_SUCCESS && (w < 1 || h < 1)) code = EXR_ERR_FILE_BAD_HEADER;
    if (code != EXR_ERR_SUCCESS) return exr_problem_code(file, "invalid tiles: ", code);
    int columns = (file->width - 1) / w + 1, rows = (file->height - 1) / h + 1;
    for (int64_t i = 0; code == EXR_ERR_SUCCESS && i < (int64_t)columns * rows; i++) {
        int tx = (int)(i % columns), ty = (int)(i / columns);
        exr_chunk_info_t info;
        code = exr_read_tile_chunk_info(file->exr, 0, tx, ty, 0, 0, &info);
        if (code == EXR_ERR_SUCCESS)
            code = decode_chunk(file, to, &info, (int64_t)tx * w, (int64_t)ty * h);
    }
    return code == EXR_ERR_SUCCESS ? SATIN_OK : exr_problem_code(file, "invalid pixels: ", code);
}

satin_status exrfile_read(struct exrfile *file, const struct exrfile_channel *to) {
    allocation_failed = false;
    const satin_status status = file->tiled ? read_tiles(file, to) : read_scanlines(file, to);
    return status == SATIN_OK && file->no_memory ? exrfile_no_memory(file) : status;
}
