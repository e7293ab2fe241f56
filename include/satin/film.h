// SPDX-License-Identifier: Apache-2.0
// Images: named float channels of one size, rows from the top. A film is immutable: all functions
// but satin_film_free may be called for one film from several threads.
#ifndef SATIN_FILM_H
#define SATIN_FILM_H

#include <stdbool.h>

#include "satin/types.h"

#ifdef __cplusplus
extern "C" {
#endif

// Reads an OpenEXR file (scanline or tiled, first part, any pixel type); values keep the units of
// the file. `path` and `film` must not be NULL. `log` may be NULL; it is called on this thread. The
// caller frees *film with satin_film_free; on failure *film is unchanged. SATIN_ERROR_INPUT: the
// file cannot be read, is not OpenEXR or not supported; SATIN_ERROR_MEMORY. Thread-safe.
SATIN_API satin_status satin_film_read(const char *path, satin_log_fn log, void *log_user,
                                       satin_film **film);
// Frees the film with its channels, names and statistics. NULL is allowed. No other thread may use
// the film during or after the call, but other films may be freed at the same time.
SATIN_API void satin_film_free(satin_film *film);

// The film's size [pixels], of the crop window if the scene has one. Neither pointer may be NULL.
// Thread-safe.
SATIN_API void satin_film_size(const satin_film *film, int *width, int *height);
// Where the film lies in the whole image of which it is a crop: its first column *x and row *y
// there and the whole size [pixels]. Of a film that is no crop, 0, 0 and its own size. No pointer
// may be NULL. Thread-safe.
SATIN_API void satin_film_window(const satin_film *film, int *x, int *y, int *full_width,
                                 int *full_height);
// The name of channel `index`, counted from 0; NULL below 0 and beyond the last one, so that a loop
// can end by it. Channels are named R, G, B for the beauty and layer.R and so on for layers. The
// name is owned by the film. Thread-safe.
SATIN_API const char *satin_film_channel_name(const satin_film *film, int index);
// The channel of that name: width * height floats, row by row from the top, owned by the film; NULL
// if there is none. docs/formats.md has the unit of each: radiance [W m^-2 sr^-1] in all channels
// of light, the scene's unit of length in depth.Z, 1 in albedo, normal and counts. Thread-safe.
SATIN_API const float *satin_film_channel(const satin_film *film, const char *name);

// Writes all channels and attributes as OpenEXR (float, ZIP), with the values in their units. The
// file appears whole or not at all, and replaces an existing one. `log` may be NULL; it is called
// on this thread. SATIN_ERROR_IO, logged, if the file cannot be written; SATIN_ERROR_ARGUMENT,
// logged, if the film has no channels; SATIN_ERROR_MEMORY. Neither `film` nor `path` may be NULL;
// the caller keeps the film. Thread-safe; of two calls that write the same path, the last one to
// end determines the file.
SATIN_API satin_status satin_film_write_exr(const satin_film *film, const char *path,
                                            satin_log_fn log, void *log_user);
// How an OpenEXR file holds the values. All zero: channels of colours (.R, .G, .B and A) have
// 16-bit half floats and all others 32-bit floats, compressed by ZIP. A layer of colours has 32
// bits too if half floats cannot hold it: if a value is above 65504, or if most are below 2^-14.
typedef enum satin_exr_compression {
    SATIN_EXR_ZIP,   // 16 rows together
    SATIN_EXR_ZIPS,  // row by row, for viewers that read parts
    SATIN_EXR_PIZ,   // wavelets, smaller for noisy images
    SATIN_EXR_RLE,
    SATIN_EXR_NONE
} satin_exr_compression;
typedef struct satin_exr_format {
    bool full_float;  // all channels have 32 bits, so that reading returns what was written
    satin_exr_compression compression;
} satin_exr_format;

// Does what satin_film_write_exr does, from the same threads, in that format; NULL is all zero.
// SATIN_ERROR_ARGUMENT also if the compression is not one of the enum.
SATIN_API satin_status satin_film_write_exr_as(const satin_film *film, const char *path,
                                               const satin_exr_format *format, satin_log_fn log,
                                               void *log_user);

// How light becomes a picture. All zero: the beauty, as it is, clamped.
typedef enum satin_tone {
    SATIN_TONE_CLIP,    // linear up to 1, where the display is white
    SATIN_TONE_FILMIC,  // keeps details of bright parts
    SATIN_TONE_AGX  // as well, and bright colours become pale without changing their hue [Sobotka
                    // 2022]
} satin_tone;
typedef struct satin_tonemap {
    const char *layer;   // the layer of which channels .R, .G and .B are shown; NULL: the beauty
    float exposure;      // the light is multiplied by 2^exposure [stops]
    bool auto_exposure;  // first by what makes the mean logarithm of luminance that of 0.18
    satin_tone tone;
} satin_tonemap;

// Writes a picture as 8-bit sRGB PNG. If the film has a channel A, the picture of its beauty has
// alpha, by which its colours are divided, as PNG files have them. `tonemap` may be NULL, which is
// all zero. Errors are those of satin_film_write_exr, with SATIN_ERROR_ARGUMENT also if the film
// does not have the three channels or if the exposure is not finite, and SATIN_ERROR_INTERNAL if
// libpng fails. The other pointers, the threads and the file are as there: thread-safe, complete or
// not written.
SATIN_API satin_status satin_film_write_png(const satin_film *film, const char *path,
                                            const satin_tonemap *tonemap, satin_log_fn log,
                                            void *log_user);

#ifdef __cplusplus
}
#endif
#endif
