// SPDX-License-Identifier: Apache-2.0
// Films: layers of summed samples while rendering, named channels afterwards; OpenEXR and PNG.
#ifndef FILM_FILM_H
#define FILM_FILM_H

#include "base/log.h"
#include "base/parallel.h"
#include "base/vec.h"
#include "satin/film.h"

// An attribute of the file's header: text, under a name that OpenEXR does not use itself.
struct film_attribute {
    char *name, *value;
};

struct satin_film {
    int width, height;
    int channel_count;
    char **channel_name;
    float **channel;  // each width * height
    int attribute_count;
    struct film_attribute *attribute;
    char *stats;  // JSON or NULL
};

// A film with zeroed channels of these names (copied). NULL without memory or if width or height <
// 1 or the size is over 2^31 pixels.
struct satin_film *film_new(int width, int height, const char *const *channel_names,
                            int channel_count);
float *film_channel(struct satin_film *film, const char *name);  // NULL if there is none
// Adds or replaces an attribute; false without memory.
bool film_attribute_set(struct satin_film *film, const char *name, const char *value);
const char *film_attribute_get(const struct satin_film *film, const char *name);
// The attribute that holds `stats` in a file.
#define FILM_STATS_ATTRIBUTE "satin:stats"
// Writing with a pool compresses on all threads; the bytes are the same. NULL for no pool. The pool
// must not be cancelled by its progress function: that fails the writing.
satin_status film_write_exr(const struct satin_film *film, const char *path, struct parallel *pool,
                            struct log log);
// Reads the bytes of an OpenEXR file; `name` is for messages. SATIN_ERROR_INPUT if they are bad or
// not supported. The caller frees *film.
satin_status film_parse_exr(const void *data, size_t size, const char *name, struct log log,
                            struct satin_film **film);

// The sRGB transfer function in 8 bits; NaN and negative values are black.
unsigned char film_encode_srgb(float linear);
// Writes a PNG of 8-bit sRGB pixels; `path` appears whole or not at all.
satin_status film_write_pixels(const char *path, int width, int height, const unsigned char *pixel,
                               struct log log);
// A picture of one number per pixel (film_map.c): black where it is 0 or not finite, then from dark
// blue to light yellow, evenly in lightness, up to *top: almost the largest value, so that a few
// do not darken the others.
satin_status film_write_map(const struct satin_film *film, const float *value, const char *path,
                            struct log log, float *top);
// The beauty in grey, and over it the fraction `dot` of each pixel's area in one colour.
satin_status film_write_dots(const struct satin_film *film, const float *dot, const char *path,
                             struct log log);

// ---- Denoising by Open Image Denoise (film_denoise.c) -------------------------------------------

struct film_denoiser;

// Opens the library and tries it on a small image. SATIN_ERROR_INPUT with one logged line if it is
// not there or does not work here. To be used by one thread at a time.
satin_status film_denoiser_open(int threads, struct log log, struct film_denoiser **out);
void film_denoiser_free(struct film_denoiser *denoiser);  // NULL is allowed
// Its name and version, as long as the denoiser.
const char *film_denoiser_name(const struct film_denoiser *denoiser);
// What it took on the small image, once the library was read [s/pixel].
double film_denoiser_pace(const struct film_denoiser *denoiser);

// Images of width * height, row by row from the top, all finite.
struct film_noisy {
    int width, height;
    const rgb *light;  // noisy, [W m^-2 sr^-1]
    rgb *albedo;       // of the surface that is seen, in [0, 1]; not kept
    rgb *normal;       // there, x y z in [-1, 1], of any length; not kept
    rgb *denoised;     // the result
    bool clean;        // albedo and normal have next to no noise
};

// Denoises light. What of a value is negative, or is so bright that the filter cannot hold it,
// stays as it is. `goes_on` (may be NULL) is called on this thread with the part that is done, in
// [0, 1]; false ends it with SATIN_CANCELLED. If it fails, one line is logged.
satin_status film_denoise(struct film_denoiser *denoiser, const struct film_noisy *image,
                          bool (*goes_on)(void *user, double done), void *user, struct log log);

// How far an image is from a reference; film_compare.c defines each figure.
struct film_difference {
    double rmse;         // linear, over pixels and channels
    double relmse;       // relative to the reference's square + 0.01; may be below 0, see variance
    double psnr;         // [dB] of the sRGB pictures; infinite if they are equal
    double mean_ratio;   // mean luminance over the reference's; 1 if both are black
    double discernible;  // fraction of pixels, in [0, 1]
    uint64_t compared, masked, nonfinite;  // pixels; the three sum to all
    bool variance;  // the reference's own variance was known and is subtracted from rmse and relmse
};

// Compares channels R, G and B. `mask_emission` leaves out pixels where a layer emission of either
// image is not black. Pixels that are not finite in either are counted and left out.
// SATIN_ERROR_INPUT if sizes differ, channels are missing or no pixel is left.
satin_status film_compare(const struct satin_film *image, const struct satin_film *reference,
                          bool mask_emission, struct log log, struct film_difference *out);

#endif
