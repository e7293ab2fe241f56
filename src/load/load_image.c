// SPDX-License-Identifier: Apache-2.0
// Images for textures and environments: finds the module around OpenImageIO, opens it, and turns
// what it reads into linear floats.
#include <dlfcn.h>
#include <stdlib.h>

#include "base/library.h"
#include "load/load_build.h"
#include "load/load_image_oiio.h"

// ---- The module ---------------------------------------------------------------------------------

// Where the module is, seen from the folder of the program or library that holds this code:
// installed beside the library, installed from the program, in the build tree.
static const char *const module_places[] = {
    "satin/satin_oiio.so",          "../" SATIN_LIBDIR "/satin/satin_oiio.so",
    "src/load/satin_oiio.so",       "../src/load/satin_oiio.so",
    "load/satin_oiio.so",           "../load/satin_oiio.so",
    "../../src/load/satin_oiio.so",
};

// Opens the module, or finds it open. It stays open for the life of the process: OpenImageIO keeps
// threads that unloading would pull the code from under.
static const struct oiio_module *open_module(struct log log, struct log_place place) {
    char path[PATH_MAX];
    if (!library_find(module_places, sizeof module_places / sizeof *module_places, path)) {
        log_error_at(log, place, "the image module satin_oiio.so is not installed");
        return NULL;
    }
    void *library = library_open(path);
    const struct oiio_module *module = library ? dlsym(library, OIIO_MODULE_SYMBOL) : NULL;
    if (!module) log_error_at(log, place, "cannot open the image module: %s", dlerror());
    return module;
}

// ---- Texels -------------------------------------------------------------------------------------

// Sums of as many texels as there may be are finite.
#define TEXEL_LIMIT 1e25f

static void finish_texels(const struct load_source *source, float *texel, size_t count,
                          bool decode) {
    size_t bad = 0;
    for (size_t i = 0; i < count; i++) {
        if (decode) texel[i] = srgb_to_linear(texel[i]);
        if (texel[i] >= 0.0f && texel[i] < TEXEL_LIMIT) continue;
        texel[i] = 0.0f;
        bad++;
    }
    if (bad)
        log_message(source->log, SATIN_LOG_WARNING,
                    "%s: %zu values are negative, not finite or over %g and count as 0",
                    source->path, bad, (double)TEXEL_LIMIT);
}

static satin_status image_error(const struct load_source *source, const char *problem,
                                bool no_memory) {
    log_error_at(source->log, source->place, "cannot read image '%s': %s", source->path, problem);
    return no_memory ? SATIN_ERROR_MEMORY : SATIN_ERROR_INPUT;
}

// Hashes the file and finds out what is wrong before a library tells of it on standard error.
static satin_status check_file(const struct load_source *source, size_t *bytes) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, LOAD_FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    const char *problem = load_image_png_problem(data, size);
    free(data);
    *bytes = size;
    if (!problem) return SATIN_OK;
    return image_error(source, problem, problem == load_image_no_memory);
}

// Images of this many pixels may come out of any file; larger ones need a byte for so many pixels:
// no compression of a real format does better (deflate shrinks 8 pixels of a bit by 1032).
enum { PIXELS_FREE = 1 << 22, PIXELS_PER_BYTE = 10000 };

static satin_status check_size(const struct load_source *source, const struct oiio_image *opened,
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

static satin_status read_image(const struct load_source *source, const struct oiio_module *module,
                               struct oiio_image *opened, bool raw, const struct image **out) {
    size_t pixels = (size_t)opened->width * (size_t)opened->height;
    size_t count = pixels * (size_t)opened->channels;
    float *texel = arena_array(source->arena, count, sizeof *texel);
    struct image *image = arena_alloc(source->arena, sizeof *image);
    if (!texel || !image)
        return log_fail(source->log, SATIN_ERROR_MEMORY, "%s: not enough memory for the image",
                        source->path);
    char error[512] = "";
    const enum oiio_result result = module->read(opened, texel, error, sizeof error);
    if (result != OIIO_DONE) return image_error(source, error, result == OIIO_NO_MEMORY);
    finish_texels(source, texel, count, !raw && opened->srgb);
    *image = (struct image){opened->width, opened->height, opened->channels, texel};
    *out = image;
    return SATIN_OK;
}

satin_status load_image(const struct load_source *source, bool raw, const struct image **out) {
    size_t bytes = 0;
    satin_status status = check_file(source, &bytes);
    if (status != SATIN_OK) return status;
    const struct oiio_module *module = open_module(source->log, source->place);
    if (!module) return SATIN_ERROR_INTERNAL;
    struct oiio_image opened;
    char error[512] = "";
    const enum oiio_result result = module->open(source->path, &opened, error, sizeof error);
    if (result != OIIO_DONE) return image_error(source, error, result == OIIO_NO_MEMORY);
    status = check_size(source, &opened, bytes);
    if (status == SATIN_OK) status = read_image(source, module, &opened, raw, out);
    module->close(&opened);
    return status;
}
