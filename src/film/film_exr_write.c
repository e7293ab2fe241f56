// SPDX-License-Identifier: Apache-2.0
// Writes films to OpenEXR: one part, scanlines; attributes as strings. Chunks, of 16 lines with
// ZIP, are converted and compressed in parallel, in batches, and written in order, so the bytes do
// not depend on threads. They are written by base/fileio_output.h. OpenEXR reports success even if
// chunks are missing, so written chunks are counted here.
#include <math.h>
#include <openexr.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio_output.h"
#include "film/film.h"

enum {
    EXR_BATCH = 64,      // compressed chunks in memory at once
    SHORT_NAME_MAX = 31  // longer names need a flag that readers before OpenEXR 1.7 refuse
};

static const exr_compression_t exr_compressions[] = {
    [SATIN_EXR_ZIP] = EXR_COMPRESSION_ZIP,   [SATIN_EXR_ZIPS] = EXR_COMPRESSION_ZIPS,
    [SATIN_EXR_PIZ] = EXR_COMPRESSION_PIZ,   [SATIN_EXR_RLE] = EXR_COMPRESSION_RLE,
    [SATIN_EXR_NONE] = EXR_COMPRESSION_NONE,
};

struct exr_chunk {
    void *data;  // from malloc
    uint64_t bytes;
    exr_result_t result;
    size_t dropped;  // number of values that were not finite
};

// Half floats from 2^-14 on have a relative error of up to 2^-11. Below, it is 2^-25 in all.
static const float HALF_LARGEST = 65504.0f, HALF_NORMAL = 0x1p-14f;
static const double HALF_RELATIVE = 0x1p-11, HALF_ABSOLUTE = 0x1p-25;

struct writer {
    const struct satin_film *film;
    satin_exr_format format;
    struct fileio_output file;
    exr_context_t exr;
    int lines, first;  // lines per chunk; index of the batch's first chunk
    struct exr_chunk chunk[EXR_BATCH];
};

static void ignore_exr_error(exr_const_context_t exr, exr_result_t code, const char *message) {
    (void)exr;
    (void)code;
    (void)message;
}

// Writes bytes, instead of OpenEXR's own file functions.
static int64_t write_bytes(exr_const_context_t exr, void *user, const void *data, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error) {
    (void)exr;
    (void)error;
    return fileio_output_write_at(user, data, size, offset) ? (int64_t)size : -1;
}

// Replaces the last step of the pipeline, writing, because chunks finish in any order here.
static exr_result_t keep_chunk(exr_encode_pipeline_t *pipe) {
    struct exr_chunk *chunk = pipe->encoding_user_data;
    // A chunk that is not shorter than the uncompressed one is stored uncompressed.
    bool shorter = pipe->compressed_bytes < pipe->packed_bytes;
    chunk->bytes = shorter ? pipe->compressed_bytes : pipe->packed_bytes;
    chunk->data = malloc(chunk->bytes ? chunk->bytes : 1);
    if (!chunk->data) return EXR_ERR_OUT_OF_MEMORY;
    memcpy(chunk->data, shorter ? pipe->compressed_buffer : pipe->packed_buffer, chunk->bytes);
    return EXR_ERR_SUCCESS;
}

// Copies `count` values to `out`, with 0 for those that are not finite unless these are kept.
// Returns the number of these.
static size_t copy_values(const float *in, size_t count, bool keep_nonfinite, float *out) {
    size_t dropped = 0;
    for (size_t i = 0; i < count; i++) {
        bool finite = isfinite(in[i]);
        out[i] = finite || keep_nonfinite ? in[i] : 0.0f;
        dropped += !finite;
    }
    return dropped;
}

static exr_result_t encode_chunk(const struct writer *w, int index, struct exr_chunk *chunk) {
    int width = w->film->width, y = index * w->lines;
    exr_chunk_info_t info;
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t r = exr_write_scanline_chunk_info(w->exr, 0, w->film->y + y, &info);
    if (r != EXR_ERR_SUCCESS) return r;
    size_t values = (size_t)width * (size_t)info.height;
    float *copy = malloc((size_t)w->film->channel_count * values * sizeof *copy);
    if (!copy) return EXR_ERR_OUT_OF_MEMORY;
    r = exr_encoding_initialize(w->exr, 0, &info, &pipe);
    for (int c = 0; r == EXR_ERR_SUCCESS && c < pipe.channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipe.channels[c];
        float *plane = copy + (size_t)c * values;
        const float *from = satin_film_channel(w->film, channel->channel_name);
        chunk->dropped +=
            copy_values(from + (size_t)y * (size_t)width, values, w->film->keep_nonfinite, plane);
        channel->user_bytes_per_element = sizeof *plane;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof *plane;
        channel->user_line_stride = width * (int)sizeof *plane;
        channel->encode_from_ptr = (const uint8_t *)plane;
    }
    if (r == EXR_ERR_SUCCESS) r = exr_encoding_choose_default_routines(w->exr, 0, &pipe);
    if (r == EXR_ERR_SUCCESS) {
        pipe.encoding_user_data = chunk;
        pipe.yield_until_ready_fn = NULL;
        pipe.write_fn = keep_chunk;
        r = exr_encoding_run(w->exr, 0, &pipe);
    }
    exr_encoding_destroy(w->exr, &pipe);
    free(copy);
    return r;
}

static void encode_chunks(void *ctx, size_t begin, size_t end, int worker) {
    struct writer *w = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        w->chunk[i].result = encode_chunk(w, w->first + (int)i, &w->chunk[i]);
}

// Encodes and writes `count` chunks from w->first on.
static exr_result_t write_batch(struct writer *w, int count, struct parallel *pool,
                                size_t *dropped) {
    bool complete = true;
    memset(w->chunk, 0, sizeof w->chunk);
    if (pool)
        complete = parallel_for(pool, (size_t)count, 1, encode_chunks, w);
    else
        encode_chunks(w, 0, (size_t)count, 0);
    exr_result_t r = complete ? EXR_ERR_SUCCESS : EXR_ERR_UNKNOWN;
    for (int i = 0; i < count; i++) {
        struct exr_chunk *chunk = &w->chunk[i];
        if (r == EXR_ERR_SUCCESS) r = chunk->result;
        if (r == EXR_ERR_SUCCESS)
            r = exr_write_scanline_chunk(w->exr, 0, w->film->y + (w->first + i) * w->lines,
                                         chunk->data, chunk->bytes);
        *dropped += chunk->dropped;
        free(chunk->data);
    }
    return r;
}

// Whether a channel is of a layer of colours, and the length of its layer's name with the point.
// The variance of a reference is not a colour, and mattes are not.
static bool is_color(const char *name, size_t *layer) {
    const size_t length = strlen(name);
    *layer = length - 1;
    if (length == 0 || !strchr("RGBA", name[length - 1])) return false;
    if (length > 1 && name[length - 2] != '.') return false;
    return strncmp(name, "variance.", 9) != 0 && !film_is_cryptomatte(name);
}

// Whether half floats hold the values about as exactly as they hold numbers of their normal range.
static bool fits_half(const float *value, size_t count) {
    double sum = 0.0, small = 0.0;
    for (size_t i = 0; i < count; i++) {
        const float size = fabsf(value[i]);
        if (!(size <= HALF_LARGEST)) {
            if (isfinite(size)) return false;
            continue;
        }
        sum += (double)size;
        small += size > 0.0f && size < HALF_NORMAL;
    }
    return small * HALF_ABSOLUTE <= HALF_RELATIVE * sum;
}

// The type is the same for all channels of a layer of colours.
bool film_is_half(const struct satin_film *film, const satin_exr_format *format, const char *name) {
    const size_t pixels = (size_t)film->width * (size_t)film->height;
    size_t layer, other;
    if (format->full_float || film->full_float || !is_color(name, &layer)) return false;
    for (int i = 0; i < film->channel_count; i++) {
        const bool same = is_color(film->channel_name[i], &other) && other == layer &&
                          strncmp(film->channel_name[i], name, layer) == 0;
        if (same && !fits_half(film->channel[i], pixels)) return false;
    }
    return true;
}

// OpenEXR rounds to the nearest value, and halfway to the one that is even.
float film_half(float value) {
    const uint32_t lowest = 1u << 13;  // of the 23 bits of the mantissa, a half has the first 10
    uint32_t bits;
    if (fabsf(value) < HALF_NORMAL) return rintf(value * 0x1p24f) * 0x1p-24f;
    memcpy(&bits, &value, sizeof bits);
    bits += lowest / 2 - 1 + (bits / lowest & 1);
    bits -= bits % lowest;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool has_long_name(const struct satin_film *film) {
    for (int i = 0; i < film->channel_count; i++)
        if (strlen(film->channel_name[i]) > SHORT_NAME_MAX) return true;
    for (int i = 0; i < film->attribute_count; i++)
        if (strlen(film->attribute[i].name) > SHORT_NAME_MAX) return true;
    return false;
}

// The display window is the whole image, the data window is what the film has of it.
static exr_result_t set_windows(exr_context_t exr, const struct satin_film *film,
                                exr_compression_t compression) {
    const exr_attr_box2i_t whole = {.max.x = film->full_width - 1, .max.y = film->full_height - 1};
    const exr_attr_box2i_t data = {.min.x = film->x,
                                   .min.y = film->y,
                                   .max.x = film->x + film->width - 1,
                                   .max.y = film->y + film->height - 1};
    const exr_attr_v2f_t centre = {.x = 0.0f};
    return exr_initialize_required_attr(exr, 0, &whole, &data, 1.0f, &centre, 1.0f,
                                        EXR_LINEORDER_INCREASING_Y, compression);
}

// Describes colours and camera: the primaries, and the matrices.
static exr_result_t set_standard_attributes(exr_context_t exr, const struct satin_film *film) {
    const float *xy = film->chromaticities;
    const exr_attr_chromaticities_t primaries = {xy[0], xy[1], xy[2], xy[3],
                                                 xy[4], xy[5], xy[6], xy[7]};
    exr_attr_m44f_t matrix;
    exr_result_t r = exr_attr_set_chromaticities(exr, 0, "chromaticities", &primaries);
    if (!film->camera.known) return r;
    memcpy(matrix.m, film->camera.to_camera, sizeof matrix.m);
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_m44f(exr, 0, "worldToCamera", &matrix);
    memcpy(matrix.m, film->camera.to_ndc, sizeof matrix.m);
    return r == EXR_ERR_SUCCESS ? exr_attr_set_m44f(exr, 0, "worldToNDC", &matrix) : r;
}

static exr_result_t write_header(struct writer *w) {
    const struct satin_film *film = w->film;
    int part = 0;
    exr_result_t r = exr_set_longname_support(w->exr, has_long_name(film));
    if (r == EXR_ERR_SUCCESS) r = exr_add_part(w->exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (r == EXR_ERR_SUCCESS)
        r = set_windows(w->exr, film, exr_compressions[w->format.compression]);
    for (int i = 0; r == EXR_ERR_SUCCESS && i < film->channel_count; i++) {
        const char *name = film->channel_name[i];
        r = exr_add_channel(w->exr, 0, name,
                            film_is_half(film, &w->format, name) ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                            EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    if (r == EXR_ERR_SUCCESS) r = set_standard_attributes(w->exr, film);
    for (int i = 0; r == EXR_ERR_SUCCESS && i < film->attribute_count; i++)
        r = exr_attr_set_string(w->exr, 0, film->attribute[i].name, film->attribute[i].value);
    if (r == EXR_ERR_SUCCESS && film->stats)
        r = exr_attr_set_string(w->exr, 0, FILM_STATS_ATTRIBUTE, film->stats);
    return r == EXR_ERR_SUCCESS ? exr_write_header(w->exr) : r;
}

// Writes all bytes of the open file.
static exr_result_t write_file(struct writer *w, struct parallel *pool, size_t *dropped) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = ignore_exr_error;
    init.zip_level = FILM_ZIP_EFFORT;
    init.write_fn = write_bytes;
    init.user_data = &w->file;
    exr_result_t r = exr_start_write(&w->exr, w->file.temporary, EXR_WRITE_FILE_DIRECTLY, &init);
    if (r != EXR_ERR_SUCCESS) return r;
    int32_t chunks = 0, lines = 0;
    r = write_header(w);
    if (r == EXR_ERR_SUCCESS) r = exr_get_chunk_count(w->exr, 0, &chunks);
    if (r == EXR_ERR_SUCCESS) r = exr_get_scanlines_per_chunk(w->exr, 0, &lines);
    w->lines = lines;
    for (w->first = 0; r == EXR_ERR_SUCCESS && w->first < chunks; w->first += EXR_BATCH) {
        int rest = chunks - w->first;
        r = write_batch(w, rest < EXR_BATCH ? rest : EXR_BATCH, pool, dropped);
    }
    exr_result_t closed = exr_finish(&w->exr);
    return r == EXR_ERR_SUCCESS ? closed : r;
}

satin_status film_write_exr_as(const struct satin_film *film, const char *path,
                               const satin_exr_format *format, struct parallel *pool,
                               struct log log) {
    if (film->channel_count == 0)
        return log_fail(log, SATIN_ERROR_ARGUMENT, "%s: the film has no channels", path);
    if ((unsigned)format->compression > SATIN_EXR_NONE)
        return log_fail(log, SATIN_ERROR_ARGUMENT, "%s: unknown compression %u", path,
                        (unsigned)format->compression);
    struct writer *w = calloc(1, sizeof *w);
    if (!w) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    w->film = film;
    w->format = *format;
    size_t dropped = 0;
    satin_status status = fileio_output_open(log, path, FILEIO_SEEK, &w->file);
    if (status == SATIN_OK) {
        const exr_result_t r = write_file(w, pool, &dropped);
        if (r == EXR_ERR_SUCCESS || w->file.error) {
            status = fileio_output_commit(log, &w->file);
        } else {
            status = r == EXR_ERR_OUT_OF_MEMORY ? SATIN_ERROR_MEMORY : SATIN_ERROR_IO;
            log_fail(log, status, "%s: cannot write: %s", path, exr_get_default_error_message(r));
            fileio_output_discard(&w->file);
        }
    }
    if (status == SATIN_OK && dropped)
        log_message(log, SATIN_LOG_WARNING,
                    film->keep_nonfinite ? "%s: %zu values are not finite"
                                         : "%s: %zu values that are not finite were written as 0",
                    path, dropped);
    free(w);
    return status;
}

satin_status film_write_exr(const struct satin_film *film, const char *path, struct parallel *pool,
                            struct log log) {
    const satin_exr_format full = {.full_float = true};
    return film_write_exr_as(film, path, &full, pool, log);
}

satin_status satin_film_write_exr_as(const satin_film *film, const char *path,
                                     const satin_exr_format *format, satin_log_fn log,
                                     void *log_user) {
    static const satin_exr_format plain;
    struct parallel *pool = parallel_new(0);  // if there are no threads, one core does all
    satin_status status =
        film_write_exr_as(film, path, format ? format : &plain, pool, (struct log){log, log_user});
    parallel_free(pool);
    return status;
}

satin_status satin_film_write_exr(const satin_film *film, const char *path, satin_log_fn log,
                                  void *log_user) {
    const satin_exr_format full = {.full_float = true};
    return satin_film_write_exr_as(film, path, &full, log, log_user);
}
