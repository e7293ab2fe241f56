// SPDX-License-Identifier: Apache-2.0
// Films: named channels of an image; reading and writing OpenEXR, writing PNG, denoising,
// comparison.
#ifndef FILM_FILM_H
#define FILM_FILM_H

#include "base/log.h"
#include "base/parallel.h"
#include "base/vec.h"
#include "satin/film.h"

// An attribute of the file's header: a text with a name that OpenEXR does not use itself.
struct film_attribute {
    char *name, *value;
};

// The matrices of a camera as OpenEXR has them, for row vectors: p' = p M.
struct film_camera {
    bool known;
    float to_camera[16];  // from world space to the camera's: z is forward, y up, x to the left
    float to_ndc[16];     // to the film: x y from 0 at its top left to 1 at its bottom right
};

struct satin_film {
    int width, height;
    int x, y, full_width, full_height;  // see satin_film_window
    int channel_count;
    char **channel_name;
    float **channel;  // each width * height
    int attribute_count;
    struct film_attribute *attribute;
    char *stats;      // JSON or NULL
    bool full_float;  // whether files have 32-bit floats in all channels, whatever the format says
    bool keep_nonfinite;  // whether files have values that are not finite as they are, not as 0
    struct film_camera camera;
    float chromaticities[8];  // x y of red, green, blue and white, in the file alone
};

// Makes a film with zeroed channels of these names, which are copied. NULL if there is no memory,
// if width or height is below 1, or if there are more than 2^31 pixels. Its primaries are those of
// sRGB.
struct satin_film *film_new(int width, int height, const char *const *channel_names,
                            int channel_count);
extern const float film_srgb_chromaticities[8];
float *film_channel(struct satin_film *film, const char *name);  // NULL if there is none
// Whether a channel is of a Cryptomatte layer, whose values are ids and coverages.
bool film_is_cryptomatte(const char *channel);
// Adds or replaces an attribute. False if there is no memory.
bool film_attribute_set(struct satin_film *film, const char *name, const char *value);
const char *film_attribute_get(const struct satin_film *film, const char *name);
// Removes an attribute that is there.
void film_attribute_remove(struct satin_film *film, const char *name);
// Set to FILM_VARIANCE_BOUND if the channels of variance are a bound, which must not be subtracted.
#define FILM_VARIANCE_ATTRIBUTE "satin:variance"
#define FILM_VARIANCE_BOUND "bound"
// The variance of a channel's pixels that may be subtracted from squared errors; NULL if there is
// none, or if it is a bound.
const float *film_variance(const struct satin_film *film, const char *channel);
// The attribute that holds `stats` in a file.
#define FILM_STATS_ATTRIBUTE "satin:stats"
// Writes an OpenEXR file. With a pool, all threads compress, with the same result; NULL: no pool.
// The pool's progress function must not cancel it, because then the writing fails.
satin_status film_write_exr_as(const struct satin_film *film, const char *path,
                               const satin_exr_format *format, struct parallel *pool,
                               struct log log);
// Whether a channel has half floats in a file of this format.
bool film_is_half(const struct satin_film *film, const satin_exr_format *format, const char *name);
// The half float that a file has for a value whose size is at most 65504.
float film_half(float value);
// How hard zlib tries to compress the chunks of a file: fixed, as defaults differ. With noisy
// floats the sizes of 1 to 9 differ by 1.5 %.
enum { FILM_ZIP_EFFORT = 4 };
// The time [s] in which one core compresses a pixel of a film of so many channels, of which most
// have half floats or all have full floats, measured now, in 1 to 2 ms (film_exr_speed.c). 0 if
// there is no memory.
double film_exr_pixel_seconds(int channels, bool full_float);
// Does so with full floats and ZIP compression.
satin_status film_write_exr(const struct satin_film *film, const char *path, struct parallel *pool,
                            struct log log);
// Reads the bytes of an OpenEXR file; `name` is for messages. SATIN_ERROR_INPUT if they are invalid
// or not supported. The caller frees *film.
satin_status film_parse_exr(const void *data, size_t size, const char *name, struct log log,
                            struct satin_film **film);

// The sRGB transfer function in 8 bits; NaN and negative values are black.
unsigned char film_encode_srgb(float linear);
// 8-bit sRGB pixels of 3 channels, of 4 with alpha, or of 1 for grey, row by row from the top.
struct film_pixels {
    int width, height, channels;
    const unsigned char *pixel;
};
// Encodes a picture as a PNG. `name` is for messages. The caller frees *data.
satin_status film_encode_pixels(const char *name, const struct film_pixels *picture, struct log log,
                                void **data, size_t *size);
// ---- film_primaries.c
// Whether chromaticities are those of the same primaries and white, but for rounding.
bool film_same_primaries(const float a[8], const float b[8]);
// Converts channels R, G and B of a layer, or of the beauty if `layer` is NULL, to the primaries of
// sRGB; the film's chromaticities stay. False, with nothing changed, if they are not those of
// colours, or if the film has not these channels.
bool film_convert_primaries(struct satin_film *film, const char *layer);
// ---- film_tonemap.c
// The light that a display shows for this light, to be encoded; values beyond [0, 1] are clamped
// then. Light that is not finite becomes white, no value black.
rgb film_tone(satin_tone tone, rgb light);
// The light of a picture.
struct film_light {
    const float *plane[3];  // R, G and B
    // Whether the light is that of a file: with half floats if it has them, with 0 for what is not
    // finite unless the film keeps that.
    bool half, finite;
};
float film_light_value(const struct film_light *light, float value);
rgb film_light_at(const struct film_light *light, size_t i);
// The factor of auto exposure for light of the film's size.
double film_auto_exposure(const struct satin_film *film, const struct film_light *light);
// The 8-bit sRGB pixels of a picture as satin_film_write_png writes it, but without alpha, over
// black; from malloc. NULL after a logged error.
unsigned char *film_picture(const struct satin_film *film, const char *name,
                            const satin_tonemap *tonemap, struct log log, satin_status *status);
// Writes what satin_film_write_png writes of the film once it is read from a file of this format,
// so that the picture of a render is that of its file.
satin_status film_write_png_as(const struct satin_film *film, const char *path,
                               const satin_tonemap *tonemap, const satin_exr_format *format,
                               struct log log);
// Writes what satin_film_write_png writes, but quickly: with less compression and without waiting
// for the disk. A reader of `path`, a regular file, always finds a whole picture.
satin_status film_write_preview(const struct satin_film *film, const char *path,
                                const satin_tonemap *tonemap, struct log log);
// Writes a picture as a PNG; `path` appears whole or not at all.
satin_status film_write_pixels(const char *path, const struct film_pixels *picture, struct log log);
// Writes a picture of one number per pixel (film_map.c): black where it is 0 or not finite, else
// from dark blue to light yellow, uniform in lightness, up to *top. *top is almost the largest
// value, so that a few outliers do not darken the picture.
satin_status film_write_map(const struct satin_film *film, const float *value, const char *path,
                            struct log log, float *top);
// The 8-bit sRGB pixels of such a picture of `count` numbers, from malloc; NULL if there is no
// memory.
unsigned char *film_map_pixels(const float *value, size_t count, float *top);
// Writes the beauty in grey, and in one colour the fraction `dot` of each pixel's area.
satin_status film_write_dots(const struct satin_film *film, const float *dot, const char *path,
                             struct log log);

// ---- Denoising by Open Image Denoise (film_denoise.c) -------------------------------------------

struct film_denoiser;

// Opens the library and tests it on a small image. SATIN_ERROR_INPUT, with one logged line, if it
// is missing or does not work. A denoiser must be used by one thread at a time.
satin_status film_denoiser_open(int threads, struct log log, struct film_denoiser **out);
void film_denoiser_free(struct film_denoiser *denoiser);  // NULL is allowed
// The name and version of the library, valid as long as the denoiser.
const char *film_denoiser_name(const struct film_denoiser *denoiser);
// The time per pixel of the small image, without reading the library, if albedo and normal are
// `clean` or not [s/pixel].
double film_denoiser_pixel_seconds(const struct film_denoiser *denoiser, bool clean);

// Images of width * height pixels, row by row from the top, all finite.
struct film_noisy {
    int width, height;
    const rgb *light;  // noisy, [W m^-2 sr^-1]
    rgb *albedo;       // of the surface that is seen, in [0, 1]; overwritten
    rgb *normal;       // of that surface, x y z in [-1, 1], of any length; overwritten
    rgb *denoised;     // the result
    bool clean;        // whether albedo and normal have almost no noise
};

// Denoises light. Values that are negative, or too large for the filter, keep that part unchanged.
// `goes_on` (may be NULL) is called on this thread with the fraction that is done, in [0, 1]; if it
// returns false, denoising ends with SATIN_CANCELLED. A failure is logged in one line.
satin_status film_denoise(struct film_denoiser *denoiser, const struct film_noisy *image,
                          bool (*goes_on)(void *user, double done), void *user, struct log log);

// The difference between an image and a reference; film_compare.c defines each figure.
struct film_difference {
    double rmse;         // linear, over pixels and channels
    double relmse;       // relative to the reference's square + 0.01; may be negative, see variance
    double psnr;         // [dB] of the sRGB pictures; infinite if they are equal
    double mean_ratio;   // mean luminance over the reference's; 1 if both are black
    double discernible;  // fraction of pixels, in [0, 1]
    uint64_t compared, masked, nonfinite;  // numbers of pixels, which sum to that of all pixels
    bool variance;  // whether the reference's own variance was known, and subtracted from rmse and
                    // relmse
};

// Compares channels R, G and B. `mask_emission` leaves out pixels where a layer emission of either
// image is not black. Pixels that are not finite in either image are counted and left out; a
// variance that is negative or not finite counts as 0.
// SATIN_ERROR_INPUT if sizes differ, channels are missing or no pixel is left.
satin_status film_compare(const struct satin_film *image, const struct satin_film *reference,
                          bool mask_emission, struct log log, struct film_difference *out);

// Which pixels that comparison has left out: one of these for each pixel. Errors are those of
// film_compare, but for that of no pixel.
enum film_pixel { FILM_PIXEL_COMPARED, FILM_PIXEL_MASKED, FILM_PIXEL_NONFINITE };
satin_status film_pixel_kinds(const struct satin_film *image, const struct satin_film *reference,
                              bool mask_emission, struct log log, unsigned char *out);

// ---- Parts of images that are compared (film_select.c) ------------------------------------------

// The box x, y, width, height of the pixels that both images have, in the pixels of the whole image
// of which they are crops. SATIN_ERROR_INPUT, with one logged line, if that differs in size or if
// they have no common pixel.
satin_status film_common_box(const struct satin_film *a, const struct satin_film *b, struct log log,
                             int box[4]);
// Makes a film of a box of the image (film_common_box) with the first channels R, G and B, which
// are those of the layer, or of the beauty if `layer` is NULL. Its window (satin_film_window) is
// the box. Channels of layer emission are there if the image has them, and those of layer variance
// with the beauty unless they are a bound. `name` is for messages. SATIN_ERROR_INPUT, with one
// logged line, if the image has not all pixels or no such channels.
satin_status film_select(const struct satin_film *film, const char *name, const char *layer,
                         const int box[4], struct log log, struct satin_film **out);
// The error of each pixel of a selected image: the root of the mean of (x - r)^2 / (r^2 + 0.01)
// over its three channels; 0 where `kind` (film_pixel_kinds) is masked, NaN where it is not finite.
void film_pixel_errors(const struct satin_film *image, const struct satin_film *reference,
                       const unsigned char *kind, float *out);
// LDR-FLIP of pictures in linear sRGB, width * height values each, which are clamped to [0, 1]
// (film_flip.c): `map` is the error of each pixel in [0, 1]; their mean is that of the picture.
satin_status film_flip(const float *const image[3], const float *const reference[3], int width,
                       int height, struct log log, float *map);

#endif
