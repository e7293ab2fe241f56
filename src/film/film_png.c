// SPDX-License-Identifier: Apache-2.0
// Writes the beauty of a film as a PNG: 8 bits per channel, sRGB, clamped to [0, 1]. For display,
// not for measurements.
#include <math.h>
#include <png.h>
#include <stdlib.h>

#include "base/fileio.h"
#include "film/film.h"

// IEC 61966-2-1.
unsigned char film_encode_srgb(float linear) {
    if (!(linear > 0.0f)) return 0;
    if (linear >= 1.0f) return 255;
    float v = linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
    return (unsigned char)(255.0f * v + 0.5f);
}

satin_status film_write_pixels(const char *path, int width, int height, const unsigned char *pixel,
                               struct log log) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB};
    // The bound of libpng's own macro for incompressible data, so one encoding is enough.
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);
    void *file = malloc(bytes);
    if (!file) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    satin_status status;
    if (png_image_write_to_memory(&image, file, &bytes, 0, pixel, 0, NULL))
        status = fileio_write(log, path, file, bytes);
    else
        status = log_fail(log, SATIN_ERROR_INTERNAL, "%s: PNG: %s", path, image.message);
    free(file);
    return status;
}

satin_status satin_film_write_png(const satin_film *film, const char *path, satin_log_fn log_fn,
                                  void *log_user) {
    struct log log = {log_fn, log_user};
    const float *beauty[3] = {satin_film_channel(film, "R"), satin_film_channel(film, "G"),
                              satin_film_channel(film, "B")};
    if (!beauty[0] || !beauty[1] || !beauty[2])
        return log_fail(log, SATIN_ERROR_ARGUMENT, "%s: the film has no channels R, G and B", path);
    size_t pixels = (size_t)film->width * (size_t)film->height;
    unsigned char *pixel = malloc(3 * pixels);
    if (!pixel) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < 3; c++) pixel[3 * i + (size_t)c] = film_encode_srgb(beauty[c][i]);
    satin_status status = film_write_pixels(path, film->width, film->height, pixel, log);
    free(pixel);
    return status;
}
