// SPDX-License-Identifier: Apache-2.0
// Reads images for textures and environments as linear floats: PNG files by libpng, JPEG files by
// libjpeg, OpenEXR files by OpenEXR, all others by the module on OpenImageIO, which is found and
// opened here.
#include <dlfcn.h>
#include <limits.h>
#include <stdlib.h>

#include "base/library.h"
#include "load/load_build.h"
#include "load/load_image_reader.h"

// ---- The module ---------------------------------------------------------------------------------

// Where the module is, relative to the folder of the program or library that holds this code:
// installed beside the library, installed with the program, in the build tree.
static const char *const module_paths[] = {
    "satin/satin_oiio.so",          "../" SATIN_LIBDIR "/satin/satin_oiio.so",
    "src/load/satin_oiio.so",       "../src/load/satin_oiio.so",
    "load/satin_oiio.so",           "../load/satin_oiio.so",
    "../../src/load/satin_oiio.so",
};

// Opens the module on the first call. It is never closed, because threads of OpenImageIO could
// still run its code.
static const struct image_reader *open_module(struct log log, struct log_place place) {
    char path[PATH_MAX];
    if (!library_find(module_paths, sizeof module_paths / sizeof *module_paths, path)) {
        log_error_at(log, place, "the image module satin_oiio.so is not installed");
        return NULL;
    }
    void *library = library_open(path);
    const struct image_reader *module = library ? dlsym(library, OIIO_MODULE_SYMBOL) : NULL;
    if (!module) log_error_at(log, place, "cannot open the image module: %s", dlerror());
    return module;
}

// ---- Texels -------------------------------------------------------------------------------------

enum { BYTE_VALUES = UCHAR_MAX + 1 };

// The largest texel, such that sums over all texels are finite.
#define TEXEL_LIMIT 1e25f

static void decode_values(float *texel, size_t count) {
    for (size_t i = 0; i < count; i++) texel[i] = load_srgb_to_linear(texel[i]);
}

static bool is_texel(float x) { return x >= 0.0f && x < TEXEL_LIMIT; }

// Sets texels that are no light or reflectance to 0.
static void drop_wrong_texels(const struct load_source *source, float *texel, size_t count) {
    size_t bad = 0;
    for (size_t i = 0; i < count; i++) bad += !is_texel(texel[i]);
    if (!bad) return;
    for (size_t i = 0; i < count; i++)
        if (!is_texel(texel[i])) texel[i] = 0.0f;
    log_message(source->log, SATIN_LOG_WARNING,
                "%s: %zu values are negative, not finite or over %g and count as 0", source->path,
                bad, (double)TEXEL_LIMIT);
}

static satin_status check_read_heights(const struct load_source *source, const struct image *image,
                                       const float *texel) {
    const size_t row = (size_t)image->width * (size_t)image->channels;
    for (size_t i = 0; i < row * (size_t)image->height; i++) {
        if (isfinite(texel[i])) continue;
        log_error_at(source->log, source->place,
                     "image '%s': the height in column %zu of row %zu is not finite", source->path,
                     i % row / (size_t)image->channels + 1, i / row + 1);
        return SATIN_ERROR_INPUT;
    }
    return SATIN_OK;
}

static satin_status image_error(const struct load_source *source, const char *problem,
                                bool no_memory) {
    log_error_at(source->log, source->place, "cannot read image '%s': %s", source->path,
                 *problem ? problem : "it is damaged or cut short");
    return no_memory ? SATIN_ERROR_MEMORY : SATIN_ERROR_INPUT;
}

static satin_status no_image_memory(const struct load_source *source) {
    return log_fail(source->log, SATIN_ERROR_MEMORY, "%s: not enough memory for the image",
                    source->path);
}

// Images of up to PIXELS_FREE pixels are always read. Larger ones must have a byte per
// PIXELS_PER_BYTE pixels: no real format compresses better (deflate compresses 8 one-bit pixels by
// 1032).
enum { PIXELS_FREE = 1 << 22, PIXELS_PER_BYTE = 10000 };

static satin_status check_size(const struct load_source *source, const struct opened_image *opened,
                               size_t bytes) {
    uint64_t pixels = (uint64_t)opened->width * (uint64_t)opened->height;
    if (pixels > LOAD_IMAGE_PIXELS_MAX)
        log_error_at(source->log, source->place, "image '%s' is too large: %d x %d", source->path,
                     opened->width, opened->height);
    else if (pixels > PIXELS_FREE && pixels / PIXELS_PER_BYTE > bytes)
        log_error_at(source->log, source->place, "image '%s' is cut short: %d x %d in %zu bytes",
                     source->path, opened->width, opened->height, bytes);
    else
        return SATIN_OK;
    return SATIN_ERROR_INPUT;
}

// What the texels of an image are.
struct texel_kind {
    bool raw;      // plain numbers, which are not decoded from sRGB
    bool heights;  // numbers of any sign; else light or reflectances
    bool bytes;    // bytes stay bytes
    int channel;   // LOAD_IMAGE_ALL, or the only one, see load_image_texture
};

static size_t value_size(const struct opened_image *opened, struct texel_kind kind) {
    return opened->bytes && kind.bytes ? 1 : sizeof(float);
}

// How many channels of a file are kept.
static int kept_channels(const struct opened_image *opened, struct texel_kind kind) {
    return kind.channel == LOAD_IMAGE_ALL ? opened->channels : 1;
}

static double value_count(const struct opened_image *opened, int channels) {
    return (double)opened->width * (double)opened->height * (double)channels;
}

static int color_channels(const struct opened_image *opened) {
    return opened->channels < 3 ? 1 : 3;
}

static bool has_alpha(const struct opened_image *opened) {
    return opened->channels > color_channels(opened);
}

// Keeps one channel of what was read into *values, as an array of its own instead. False if there
// is no memory.
static bool keep_channel(struct arena *arena, struct opened_image *opened, int channel,
                         void **values) {
    const int colors = color_channels(opened);
    const size_t from = (size_t)(channel == LOAD_IMAGE_ALPHA ? colors : colors == 1 ? 0 : channel);
    const size_t count = (size_t)opened->width * (size_t)opened->height;
    const size_t channels = (size_t)opened->channels;
    void *kept = arena_array_alone(arena, count, opened->bytes ? 1 : sizeof(float));
    if (!kept) return false;
    if (opened->bytes) {
        const unsigned char *all = *values;
        for (size_t i = 0; i < count; i++) ((unsigned char *)kept)[i] = all[i * channels + from];
    } else {
        const float *all = *values;
        for (size_t i = 0; i < count; i++) ((float *)kept)[i] = all[i * channels + from];
    }
    arena_drop(arena, *values);
    *values = kept;
    opened->channels = 1;
    return true;
}

// What each byte stands for.
static void byte_values(bool decode, float value[BYTE_VALUES]) {
    for (int b = 0; b < BYTE_VALUES; b++) {
        const float x = (float)b * (1.0f / UCHAR_MAX);
        value[b] = decode ? load_srgb_to_linear(x) : x;
    }
}

// Makes floats of bytes, which lie at the end of their array: a texel overwrites only the byte from
// which it is made and bytes before that.
static void spread_bytes(const float value[BYTE_VALUES], size_t count, float *texel) {
    const unsigned char *byte = (unsigned char *)texel + count * (sizeof *texel - 1);
    for (size_t i = 0; i < count; i++) texel[i] = value[byte[i]];
}

// Reads all values into *values, of value_size each, with linear texels as bytes or floats. If only
// one channel is kept, *values becomes another array.
static satin_status read_image_values(const struct load_source *source,
                                      const struct image_reader *reader,
                                      struct opened_image *opened, struct texel_kind kind,
                                      void **values, float byte_value[BYTE_VALUES]) {
    char error[512] = "";
    const size_t pixels = (size_t)opened->width * (size_t)opened->height;
    const bool spread = opened->bytes && !kind.bytes, alpha = kind.channel == LOAD_IMAGE_ALPHA;
    const bool decode = !kind.raw && !alpha && opened->srgb;
    const size_t count = pixels * (size_t)opened->channels;
    char *to = (char *)*values + (spread ? count * (sizeof(float) - 1) : 0);
    const enum reader_result result = reader->read(opened, to, error, sizeof error);
    if (result != READER_DONE) return image_error(source, error, result == READER_NO_MEMORY);
    if (kind.channel != LOAD_IMAGE_ALL &&
        !keep_channel(source->arena, opened, kind.channel, values))
        return no_image_memory(source);
    if (opened->bytes) byte_values(decode, byte_value);
    if (spread) spread_bytes(byte_value, count, *values);
    if (!opened->bytes && decode) decode_values(*values, pixels * (size_t)opened->channels);
    return SATIN_OK;
}

static satin_status read_texels(const struct load_source *source, const struct image_reader *reader,
                                struct opened_image *opened, struct texel_kind kind,
                                struct image **out) {
    const size_t pixels = (size_t)opened->width * (size_t)opened->height;
    void *values = arena_array_alone(source->arena, pixels * (size_t)opened->channels,
                                     value_size(opened, kind));
    struct image *image = arena_alloc(source->arena, sizeof *image);
    float *byte_value = arena_array(source->arena, BYTE_VALUES, sizeof *byte_value);
    if (!values || !image || !byte_value) return no_image_memory(source);
    satin_status status = read_image_values(source, reader, opened, kind, &values, byte_value);
    if (status != SATIN_OK) return status;
    const bool bytes = opened->bytes && kind.bytes;
    *image =
        scene_image_make(opened->width, opened->height, opened->channels, bytes ? NULL : values);
    *out = image;
    if (bytes) {
        image->byte = values;
        image->byte_value = byte_value;
        return SATIN_OK;
    }
    if (kind.heights) return check_read_heights(source, image, values);
    drop_wrong_texels(source, values, pixels * (size_t)opened->channels);
    return SATIN_OK;
}

// Makes a black image instead of one that does not fit, with the three rows that an environment
// needs.
static satin_status leave_out(const struct load_source *source, int channels, struct image **out) {
    const size_t count = 3 * (size_t)channels;
    const float *texel = arena_array_alone(source->arena, count, sizeof *texel);
    struct image *image = arena_alloc(source->arena, sizeof *image);
    if (!texel || !image) return no_image_memory(source);
    *image = scene_image_make(1, 3, channels, texel);
    *out = image;
    return SATIN_OK;
}

// Finds whether the image fits, with its file and the channels that are read but not kept.
static satin_status admit(const struct load_source *source, struct load_images *images,
                          const struct opened_image *opened, struct texel_kind kind, size_t file,
                          bool *admitted) {
    const size_t size = value_size(opened, kind);
    const int kept = kept_channels(opened, kind);
    const double read =
        kept < opened->channels ? value_count(opened, opened->channels) * (double)size : 0.0;
    return load_images_admit(images, value_count(opened, kept), size, (double)file + read, admitted)
               ? SATIN_OK
               : no_image_memory(source);
}

// Reads an image whose size the limit of memory decides, unless `images` is NULL.
static satin_status read_image(const struct load_source *source, struct load_images *images,
                               const struct image_reader *reader, const struct image_data *file,
                               struct texel_kind kind, struct image **out) {
    struct opened_image opened;
    char error[512] = "";
    const enum reader_result result = reader->open(file, &opened, error, sizeof error);
    if (result != READER_DONE) return image_error(source, error, result == READER_NO_MEMORY);
    satin_status status = check_size(source, &opened, file->size);
    if (status == SATIN_OK && kind.channel == LOAD_IMAGE_ALPHA && !has_alpha(&opened))
        status = image_error(source, "it has no alpha channel", false);
    bool admitted = true;
    if (status == SATIN_OK && images)
        status = admit(source, images, &opened, kind, file->data ? file->size : 0, &admitted);
    if (status == SATIN_OK)
        status = admitted ? read_texels(source, reader, &opened, kind, out)
                          : leave_out(source, kept_channels(&opened, kind), out);
    reader->close(&opened);
    return status;
}

static satin_status load_any_image(const struct load_source *source, struct load_images *images,
                                   struct texel_kind kind, bool *used, struct image **out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    struct image_data file = {source->path, data, size, kind.channel == LOAD_IMAGE_ALPHA};
    const struct image_reader *own = load_image_is_png(&file)    ? &load_image_png
                                     : load_image_is_jpeg(&file) ? &load_image_jpeg
                                     : load_image_is_exr(&file)  ? &load_image_exr
                                                                 : NULL;
    if (own) {
        status = read_image(source, images, own, &file, kind, out);
        free(data);
        return status;
    }
    free(data);
    file.data = NULL;
    const struct image_reader *module = open_module(source->log, source->place);
    if (!module) return SATIN_ERROR_INTERNAL;
    *used = true;
    return read_image(source, images, module, &file, kind, out);
}

satin_status load_image(const struct load_source *source, struct load_images *images, bool raw,
                        struct image **out) {
    const struct texel_kind kind = {.raw = raw, .channel = LOAD_IMAGE_ALL};
    return load_any_image(source, images, kind, &images->module, out);
}

satin_status load_image_texture(const struct load_source *source, struct load_images *images,
                                bool raw, int channel, struct image **out) {
    const struct texel_kind kind = {.raw = raw, .bytes = true, .channel = channel};
    return load_any_image(source, images, kind, &images->module, out);
}

satin_status load_image_heights(const struct load_source *source, bool raw, bool *module,
                                struct image **out) {
    const struct texel_kind kind = {.raw = raw, .heights = true, .channel = LOAD_IMAGE_ALL};
    return load_any_image(source, NULL, kind, module, out);
}
