// SPDX-License-Identifier: Apache-2.0
// Images: named float channels of one size, rows from the top. A film does not change once it is
// there: all functions but satin_film_free may be called for one film from several threads.
#ifndef SATIN_FILM_H
#define SATIN_FILM_H

#include "satin/types.h"

#ifdef __cplusplus
extern "C" {
#endif

// Reads an OpenEXR file (scanline or tiled, first part, any pixel type). The caller frees *film.
SATIN_API satin_status satin_film_read(const char *path, satin_log_fn log, void *log_user,
                                       satin_film **film);
// Ends the film, its channels, names and statistics. NULL is allowed.
SATIN_API void satin_film_free(satin_film *film);

// In pixels; of the crop window, if the scene has one.
SATIN_API void satin_film_size(const satin_film *film, int *width, int *height);
// Channels are named R, G, B for the beauty and layer.R and so on for layers. NULL beyond the last.
// Units are those of docs/formats.md: radiance [W m^-2 sr^-1] in all channels of light.
SATIN_API const char *satin_film_channel_name(const satin_film *film, int index);
// width * height floats, row by row from the top, valid as long as the film; NULL if there is none.
SATIN_API const float *satin_film_channel(const satin_film *film, const char *name);

// Writes all channels and attributes as OpenEXR (float, ZIP), or the beauty as 8-bit sRGB PNG. The
// file appears whole or not at all. SATIN_ERROR_IO, logged, if it cannot be written.
SATIN_API satin_status satin_film_write_exr(const satin_film *film, const char *path,
                                            satin_log_fn log, void *log_user);
SATIN_API satin_status satin_film_write_png(const satin_film *film, const char *path,
                                            satin_log_fn log, void *log_user);

#ifdef __cplusplus
}
#endif
#endif
