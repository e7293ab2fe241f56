// SPDX-License-Identifier: Apache-2.0
// Writes the beauty or a layer of a film as a PNG: exposed, tone-mapped, and encoded as sRGB with 8
// bits per channel. For display, not for measurements.
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/fileio_output.h"
#include "film/film.h"

// IEC 61966-2-1.
unsigned char film_encode_srgb(float linear) {
    if (!(linear > 0.0f)) return 0;
    if (linear >= 1.0f) return 255;
    float v = linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
    return (unsigned char)(255.0f * v + 0.5f);
}

static satin_status encode(const char *name, png_image *image, const unsigned char *pixel,
                           struct log log, void **data, size_t *size) {
    image->version = PNG_IMAGE_VERSION;
    // The bound of libpng's own macro for incompressible data, so one encoding is enough.
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(*image);
    void *file = malloc(bytes);
    if (!file) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", name);
    if (png_image_write_to_memory(image, file, &bytes, 0, pixel, 0, NULL)) {
        *data = file;
        *size = bytes;
        return SATIN_OK;
    }
    free(file);
    return log_fail(log, SATIN_ERROR_INTERNAL, "%s: PNG: %s", name, image->message);
}

static png_uint_32 png_format(int channels) {
    return channels == 1 ? PNG_FORMAT_GRAY : channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
}

satin_status film_encode_pixels(const char *name, const struct film_pixels *picture, struct log log,
                                void **data, size_t *size) {
    png_image image = {.width = (png_uint_32)picture->width,
                       .height = (png_uint_32)picture->height,
                       .format = png_format(picture->channels)};
    return encode(name, &image, picture->pixel, log, data, size);
}

satin_status film_write_pixels(const char *path, const struct film_pixels *picture,
                               struct log log) {
    void *file = NULL;
    size_t bytes = 0;
    satin_status status = film_encode_pixels(path, picture, log, &file, &bytes);
    if (status == SATIN_OK) status = fileio_write(log, path, file, bytes);
    free(file);
    return status;
}

// ---- Pictures -----------------------------------------------------------------------------------

// The channel .R, .G or .B of a layer, or of the beauty if `layer` is NULL.
static const float *shown_channel(const struct satin_film *film, const char *layer, char colour) {
    for (int i = 0; i < film->channel_count; i++) {
        const char *name = film->channel_name[i];
        const size_t before = strlen(name) - 1;
        if (name[before] != colour) continue;
        if (!layer && before == 0) return film->channel[i];
        if (layer && before == strlen(layer) + 1 && name[before - 1] == '.' &&
            strncmp(name, layer, before - 1) == 0)
            return film->channel[i];
    }
    return NULL;
}

// The alpha of the picture, whose channels have been multiplied by it; NULL: it has none.
static const float *picture_alpha(const struct satin_film *film, const satin_tonemap *tonemap) {
    return tonemap && tonemap->layer ? NULL : satin_film_channel(film, "A");
}

// The planes of the light that is shown, as they are, or with `format` as a file of it has them.
static struct film_light picture_light(const struct satin_film *film, const char *layer,
                                       const satin_exr_format *format) {
    struct film_light light = {{shown_channel(film, layer, 'R'), shown_channel(film, layer, 'G'),
                                shown_channel(film, layer, 'B')},
                               false,
                               format && !film->keep_nonfinite};
    for (int i = 0; i < film->channel_count && format; i++)
        if (film->channel[i] == light.plane[0])
            light.half = film_is_half(film, format, film->channel_name[i]);
    return light;
}

// Film_picture, with a fourth channel if `alpha` is not NULL, of the film as a file of this format
// has it unless this is NULL. The colours of a PNG are not multiplied by alpha, and those of a film
// are.
static unsigned char *make_picture(const struct satin_film *film, const char *name,
                                   const satin_tonemap *tonemap, const float *alpha,
                                   const satin_exr_format *format, struct log log,
                                   satin_status *status) {
    static const satin_tonemap plain = {0};
    const satin_tonemap *map = tonemap ? tonemap : &plain;
    const struct film_light light = picture_light(film, map->layer, format);
    *status = SATIN_ERROR_ARGUMENT;
    if (!light.plane[0] || !light.plane[1] || !light.plane[2]) {
        const char *dot = map->layer ? "." : "", *layer = map->layer ? map->layer : "";
        log_fail(log, *status, "%s: the film has no channels %s%sR, G and B%s", name, layer, dot,
                 map->layer ? "; a layer that is shown has colours" : "");
        return NULL;
    }
    if (!isfinite(map->exposure)) {
        log_fail(log, *status, "%s: the exposure is not finite", name);
        return NULL;
    }
    const size_t pixels = (size_t)film->width * (size_t)film->height, channels = alpha ? 4 : 3;
    unsigned char *pixel = malloc(channels * pixels);
    *status = pixel ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (!pixel) {
        log_fail(log, *status, "%s: not enough memory", name);
        return NULL;
    }
    const float factor = (float)(exp2((double)map->exposure) *
                                 (map->auto_exposure ? film_auto_exposure(film, &light) : 1.0));
    for (size_t i = 0; i < pixels; i++) {
        const float opacity = alpha ? film_light_value(&light, alpha[i]) : 1.0f;
        const bool covered = opacity > 0.0f;
        const float multiplied = covered ? fminf(opacity, 1.0f) : 1.0f;
        const rgb shown =
            film_tone(map->tone, rgb_scale(film_light_at(&light, i), factor / multiplied));
        unsigned char *at = pixel + channels * i;
        at[0] = film_encode_srgb(shown.r);
        at[1] = film_encode_srgb(shown.g);
        at[2] = film_encode_srgb(shown.b);
        if (alpha) pixel[4 * i + 3] = covered ? (unsigned char)lrintf(255.0f * multiplied) : 0;
    }
    return pixel;
}

unsigned char *film_picture(const struct satin_film *film, const char *name,
                            const satin_tonemap *tonemap, struct log log, satin_status *status) {
    return make_picture(film, name, tonemap, NULL, NULL, log, status);
}

satin_status film_write_png_as(const struct satin_film *film, const char *path,
                               const satin_tonemap *tonemap, const satin_exr_format *format,
                               struct log log) {
    const float *alpha = picture_alpha(film, tonemap);
    satin_status status;
    unsigned char *pixel = make_picture(film, path, tonemap, alpha, format, log, &status);
    if (pixel)
        status = film_write_pixels(
            path, &(struct film_pixels){film->width, film->height, alpha ? 4 : 3, pixel}, log);
    free(pixel);
    return status;
}

satin_status satin_film_write_png(const satin_film *film, const char *path,
                                  const satin_tonemap *tonemap, satin_log_fn log, void *log_user) {
    return film_write_png_as(film, path, tonemap, NULL, (struct log){log, log_user});
}

satin_status film_write_preview(const struct satin_film *film, const char *path,
                                const satin_tonemap *tonemap, struct log log) {
    const float *alpha = picture_alpha(film, tonemap);
    // On noisy images, libpng's fast settings take .6 of the time for 1.2 to 1.4 of the bytes.
    png_image image = {.width = (png_uint_32)film->width,
                       .height = (png_uint_32)film->height,
                       .format = png_format(alpha ? 4 : 3),
                       .flags = PNG_IMAGE_FLAG_FAST};
    struct fileio_output out;
    void *file = NULL;
    size_t bytes = 0;
    satin_status status;
    unsigned char *pixel = make_picture(film, path, tonemap, alpha, NULL, log, &status);
    if (pixel) status = encode(path, &image, pixel, log, &file, &bytes);
    free(pixel);
    if (status == SATIN_OK) status = fileio_output_open(log, path, FILEIO_SEEK, &out);
    if (status == SATIN_OK) {
        out.unflushed = true;
        fileio_output_append(&out, file, bytes);
        status = fileio_output_commit(log, &out);
    }
    free(file);
    return status;
}
