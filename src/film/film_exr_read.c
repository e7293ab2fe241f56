// SPDX-License-Identifier: Apache-2.0
// Reads OpenEXR to films: the first part, scanlines or the largest level of tiles, any pixel type
// as float, string attributes as text. The file is read whole, and the sizes in its header are
// checked against its size before anything is allocated, so that a hostile file takes no more
// memory than a valid one.
#include <inttypes.h>
#include <openexr.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "film/film.h"

static const size_t FILE_MAX = (size_t)4 << 30;
static const int64_t VALUES_MAX = (int64_t)1 << 31;  // 8 GB of floats
enum {
    HEADER_MAX = 1 << 20,      // the library sorts attributes by insertion, in quadratic time
    EXR_ATTRIBUTES_MAX = 256,  // further ones are ignored
    CHANNELS_MAX = 1024,
    WIDTH_MAX = 1 << 28,  // the library counts the bytes of a line by int32
    RATIO_MAX = 2048      // more than any method compresses: PXR24 with zlib has 1376
};

struct reader {
    const char *name;
    struct log log;
    const unsigned char *data;
    uint64_t size;
    bool in_header;
    bool no_memory;  // the library had no memory, even if it then reported another error
    exr_context_t exr;
    exr_attr_box2i_t window;
    int width, height;
    struct satin_film *film;
};

// Stores the message, which would otherwise go to standard error.
static void note_error(exr_const_context_t exr, exr_result_t code, const char *message) {
    void *user = NULL;
    (void)message;
    if (code == EXR_ERR_OUT_OF_MEMORY && exr_get_user_data(exr, &user) == EXR_ERR_SUCCESS && user)
        ((struct reader *)user)->no_memory = true;
}

static int64_t memory_size(exr_const_context_t exr, void *user) {
    (void)exr;
    return (int64_t)((struct reader *)user)->size;
}

static int64_t memory_read(exr_const_context_t exr, void *user, void *buffer, uint64_t bytes,
                           uint64_t offset, exr_stream_error_func_ptr_t error) {
    const struct reader *r = user;
    (void)exr;
    (void)error;
    if (offset >= r->size || (r->in_header && offset > HEADER_MAX)) return 0;
    if (bytes > r->size - offset) bytes = r->size - offset;
    memcpy(buffer, r->data + offset, bytes);
    return (int64_t)bytes;
}

static satin_status exr_refuse(const struct reader *r, const char *what, exr_result_t code) {
    if (code == EXR_ERR_OUT_OF_MEMORY || r->no_memory)
        return log_fail(r->log, SATIN_ERROR_MEMORY, "%s: not enough memory", r->name);
    return log_fail(r->log, SATIN_ERROR_INPUT, "%s: %s: %s", r->name, what,
                    exr_get_default_error_message(code));
}

static satin_status open_header(struct reader *r) {
    static const unsigned char magic[4] = {0x76, 0x2f, 0x31, 0x01};
    if (r->size < sizeof magic || memcmp(r->data, magic, sizeof magic) != 0)
        return log_fail(r->log, SATIN_ERROR_INPUT, "%s: it is not an OpenEXR file", r->name);
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = note_error;
    init.user_data = r;
    init.read_fn = memory_read;
    init.size_fn = memory_size;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    r->in_header = true;
    exr_result_t code = exr_start_read(&r->exr, r->name, &init);
    r->in_header = false;
    return code == EXR_ERR_SUCCESS ? SATIN_OK : exr_refuse(r, "invalid OpenEXR header", code);
}

// The first feature of the file that is not supported, by name; NULL if there is none.
static const char *unsupported(exr_storage_t storage, exr_compression_t compression,
                               const exr_attr_chlist_t *channels) {
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return "deep images are not supported";
    if (compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB)
        return "DWA compression is not supported";
    if (compression > EXR_COMPRESSION_B44A) return "its compression is not supported";
    if (channels->num_channels < 1) return "it has no channels";
    if (channels->num_channels > CHANNELS_MAX) return "it has too many channels";
    for (int i = 0; i < channels->num_channels; i++)
        if (channels->entries[i].x_sampling != 1 || channels->entries[i].y_sampling != 1)
            return "subsampled channels are not supported";
    return NULL;
}

// Reads the size of the image and checks it against the size of the file.
static const char *read_exr_size(struct reader *r, const exr_attr_chlist_t *channels) {
    int64_t width = (int64_t)r->window.max.x - r->window.min.x + 1;
    int64_t height = (int64_t)r->window.max.y - r->window.min.y + 1, bytes = 0;
    if (width < 1 || height < 1) return "its data window is empty";
    if (width > WIDTH_MAX || width > VALUES_MAX / channels->num_channels / height)
        return "it is too large";
    for (int i = 0; i < channels->num_channels; i++)
        bytes += channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    if (width * height > (int64_t)(r->size * RATIO_MAX) / bytes)
        return "it is too short for the size that its header states";
    r->width = (int)width;
    r->height = (int)height;
    return NULL;
}

static satin_status make_film(struct reader *r, const exr_attr_chlist_t *channels) {
    const char *names[CHANNELS_MAX];
    for (int i = 0; i < channels->num_channels; i++) names[i] = channels->entries[i].name.str;
    r->film = film_new(r->width, r->height, names, channels->num_channels);
    return r->film ? SATIN_OK : exr_refuse(r, "", EXR_ERR_OUT_OF_MEMORY);
}

// Sets where the film lies in the display window, unless that window is empty or far off.
static void set_film_window(struct reader *r) {
    exr_attr_box2i_t whole;
    if (exr_get_display_window(r->exr, 0, &whole) != EXR_ERR_SUCCESS) return;
    const int64_t x = (int64_t)r->window.min.x - whole.min.x;
    const int64_t y = (int64_t)r->window.min.y - whole.min.y;
    const int64_t width = (int64_t)whole.max.x - whole.min.x + 1;
    const int64_t height = (int64_t)whole.max.y - whole.min.y + 1;
    if (x < -WIDTH_MAX || x > WIDTH_MAX || y < -WIDTH_MAX || y > WIDTH_MAX || width < 1 ||
        width > WIDTH_MAX || height < 1 || height > WIDTH_MAX || r->height > WIDTH_MAX)
        return;
    r->film->x = (int)x;
    r->film->y = (int)y;
    r->film->full_width = (int)width;
    r->film->full_height = (int)height;
}

// Reads the primaries and the matrices of the camera, if the file has them.
static void read_standard_attributes(struct reader *r) {
    struct film_camera *camera = &r->film->camera;
    exr_attr_chromaticities_t c;
    exr_attr_m44f_t to_camera, to_ndc;
    if (exr_attr_get_chromaticities(r->exr, 0, "chromaticities", &c) == EXR_ERR_SUCCESS) {
        const float xy[8] = {c.red_x,  c.red_y,  c.green_x, c.green_y,
                             c.blue_x, c.blue_y, c.white_x, c.white_y};
        memcpy(r->film->chromaticities, xy, sizeof xy);
    }
    if (exr_attr_get_m44f(r->exr, 0, "worldToCamera", &to_camera) != EXR_ERR_SUCCESS ||
        exr_attr_get_m44f(r->exr, 0, "worldToNDC", &to_ndc) != EXR_ERR_SUCCESS)
        return;
    camera->known = true;
    memcpy(camera->to_camera, to_camera.m, sizeof camera->to_camera);
    memcpy(camera->to_ndc, to_ndc.m, sizeof camera->to_ndc);
}

static satin_status read_exr_header(struct reader *r, exr_storage_t *storage) {
    const exr_attr_chlist_t *channels = NULL;
    exr_compression_t compression = EXR_COMPRESSION_NONE;
    satin_status status = open_header(r);
    if (status != SATIN_OK) return status;
    exr_result_t code = exr_get_storage(r->exr, 0, storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_compression(r->exr, 0, &compression);
    if (code == EXR_ERR_SUCCESS) code = exr_get_channels(r->exr, 0, &channels);
    if (code == EXR_ERR_SUCCESS) code = exr_get_data_window(r->exr, 0, &r->window);
    if (code != EXR_ERR_SUCCESS) return exr_refuse(r, "invalid OpenEXR header", code);
    const char *why = unsupported(*storage, compression, channels);
    if (!why) why = read_exr_size(r, channels);
    if (why) return log_fail(r->log, SATIN_ERROR_INPUT, "%s: %s", r->name, why);
    status = make_film(r, channels);
    if (status != SATIN_OK) return status;
    set_film_window(r);
    read_standard_attributes(r);
    return SATIN_OK;
}

// Whether an attribute describes the structure of the file and not the image.
static bool is_structure(const char *name) {
    return strcmp(name, "type") == 0 || strcmp(name, "name") == 0;
}

static satin_status read_attributes(struct reader *r) {
    int32_t count = 0;
    bool memory = true;
    exr_get_attribute_count(r->exr, 0, &count);
    for (int32_t i = 0; memory && i < count && r->film->attribute_count < EXR_ATTRIBUTES_MAX; i++) {
        const exr_attribute_t *a = NULL;
        if (exr_get_attribute_by_index(r->exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &a) !=
                EXR_ERR_SUCCESS ||
            a->type != EXR_ATTR_STRING || !a->string->str || is_structure(a->name))
            continue;
        if (strcmp(a->name, FILM_STATS_ATTRIBUTE) == 0 && !r->film->stats)
            memory = (r->film->stats = strdup(a->string->str)) != NULL;
        else
            memory = film_attribute_set(r->film, a->name, a->string->str);
    }
    return memory ? SATIN_OK : exr_refuse(r, "", EXR_ERR_OUT_OF_MEMORY);
}

// Decodes one chunk to the film, with its corner at (x, y) from the film's corner.
static exr_result_t decode_chunk(struct reader *r, const exr_chunk_info_t *info, int64_t x,
                                 int64_t y) {
    if (x < 0 || y < 0 || x + info->width > r->width || y + info->height > r->height)
        return EXR_ERR_CORRUPT_CHUNK;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code = exr_decoding_initialize(r->exr, 0, info, &pipe);
    for (int c = 0; code == EXR_ERR_SUCCESS && c < pipe.channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipe.channels[c];
        float *corner = r->film->channel[c] + y * r->width + x;
        channel->user_bytes_per_element = sizeof *corner;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof *corner;
        channel->user_line_stride = r->width * (int)sizeof *corner;
        channel->decode_to_ptr = (uint8_t *)corner;
    }
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_choose_default_routines(r->exr, 0, &pipe);
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(r->exr, 0, &pipe);
    exr_decoding_destroy(r->exr, &pipe);
    return code;
}

static satin_status read_scanlines(struct reader *r) {
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(r->exr, 0, &lines);
    if (code == EXR_ERR_SUCCESS && lines < 1) code = EXR_ERR_FILE_BAD_HEADER;
    for (int64_t y = 0; code == EXR_ERR_SUCCESS && y < r->height; y += lines) {
        exr_chunk_info_t info;
        code = exr_read_scanline_chunk_info(r->exr, 0, (int)(r->window.min.y + y), &info);
        if (code == EXR_ERR_SUCCESS) code = decode_chunk(r, &info, 0, y);
    }
    return code == EXR_ERR_SUCCESS ? SATIN_OK : exr_refuse(r, "invalid pixels", code);
}

static satin_status read_tiles(struct reader *r) {
    int32_t w = 0, h = 0;
    exr_result_t code = exr_get_tile_sizes(r->exr, 0, 0, 0, &w, &h);
    if (code == EXR_ERR_SUCCESS && (w < 1 || h < 1)) code = EXR_ERR_FILE_BAD_HEADER;
    if (code != EXR_ERR_SUCCESS) return exr_refuse(r, "invalid tiles", code);
    int columns = (r->width - 1) / w + 1, rows = (r->height - 1) / h + 1;
    for (int64_t i = 0; code == EXR_ERR_SUCCESS && i < (int64_t)columns * rows; i++) {
        int tx = (int)(i % columns), ty = (int)(i / columns);
        exr_chunk_info_t info;
        code = exr_read_tile_chunk_info(r->exr, 0, tx, ty, 0, 0, &info);
        if (code == EXR_ERR_SUCCESS)
            code = decode_chunk(r, &info, (int64_t)tx * w, (int64_t)ty * h);
    }
    return code == EXR_ERR_SUCCESS ? SATIN_OK : exr_refuse(r, "invalid pixels", code);
}

satin_status film_parse_exr(const void *data, size_t size, const char *name, struct log log,
                            struct satin_film **film) {
    struct reader r = {.name = name, .log = log, .data = data, .size = size};
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    satin_status status = read_exr_header(&r, &storage);
    if (status == SATIN_OK) status = read_attributes(&r);
    if (status == SATIN_OK)
        status = storage == EXR_STORAGE_TILED ? read_tiles(&r) : read_scanlines(&r);
    if (status == SATIN_OK && r.no_memory) status = exr_refuse(&r, "", EXR_ERR_OUT_OF_MEMORY);
    if (r.exr) exr_finish(&r.exr);
    if (status == SATIN_OK)
        *film = r.film;
    else
        satin_film_free(r.film);
    return status;
}

satin_status satin_film_read(const char *path, satin_log_fn log_fn, void *log_user,
                             satin_film **film) {
    struct log log = {log_fn, log_user};
    char *data = NULL;
    size_t size = 0;
    satin_status status = fileio_read(log, (struct log_place){0}, path, FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    status = film_parse_exr(data, size, path, log, film);
    free(data);
    return status;
}
