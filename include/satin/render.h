// SPDX-License-Identifier: Apache-2.0
// Rendering: scene and options in, film out.
#ifndef SATIN_RENDER_H
#define SATIN_RENDER_H

#include "satin/film.h"
#include "satin/options.h"
#include "satin/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// Where a render stands. `stage` is static text, one of these, in their order; those that the
// options do without are left out:
//   photons           photon maps and the first-pass radiance estimate
//   BRDF tables       glossy BRDFs in harmonics
//   indirect bounces  records of the indirect bounces beyond the first, by first pass `recursive`
//   records           records of the first indirect bounce, at what the image shows
//   image             samples of the pixels
//   denoising         if options->denoise asks for it
// `done` in [0, 1] within the stage; `rate` items per second of the stage, whose name is `unit`, ""
// with a rate of 0 where they are not counted; `elapsed` seconds since the render began. Texts are
// static, the struct is valid during the call.
typedef struct satin_progress {
    const char *stage, *unit;
    double done, rate, elapsed;
} satin_progress;

// Called on the thread that called satin_render, about ten times a second, during that call only,
// so it needs no lock unless renders on several threads use one `user`. Returning true cancels. It
// must not free the scene of the render.
typedef bool (*satin_progress_fn)(void *user, const satin_progress *progress);

// What a render reports to, and the files of its records. The struct and its texts are the
// caller's, needed until satin_render returns.
typedef struct satin_callbacks {
    satin_log_fn log;  // NULL: no messages
    void *log_user;
    satin_progress_fn progress;  // NULL: no progress, no cancellation
    void *progress_user;
    // Files of cache records: read before records are made, and written after. NULL: none. The file
    // must have been made for the same scene, whatever its sensor, and by the same options, but for
    // those that do not decide records; else SATIN_ERROR_INPUT, with one logged line. So it is if
    // save_cache is a file that the scene was read from. It may be load_cache, which is replaced
    // when all records are there.
    const char *load_cache, *save_cache;
} satin_callbacks;

// Renders. `callbacks` may be NULL: none. SATIN_CANCELLED if the progress function asked for it;
// *film is then the image so far, like that of a render with less samples, its last pixels filled
// from their neighbours. Cancelled before the image was begun, a coarse one is made within half a
// second or so, of direct light alone if the photons were not done yet or a sample takes that long.
// If only the records could not be written to save_cache, or the image not be denoised, *film is
// the whole image, noisy then, and the status says why; SATIN_ERROR_INPUT, before anything is
// rendered, if options->denoise asks for a denoiser that is not installed. A cancelled image is
// denoised if that takes no longer than a moment. The caller frees *film with satin_film_free, and
// sets it to NULL before: it is touched where there is an image alone. SATIN_ERROR_ARGUMENT: a
// pointer but `callbacks` is NULL; SATIN_ERROR_INPUT also: a file of records does not fit;
// SATIN_ERROR_IO; SATIN_ERROR_MEMORY; SATIN_ERROR_INTERNAL: a library failed. Radiance is in W m^-2
// sr^-1, lengths in the scene's unit, options->time in seconds. Thread-safe on a shared scene:
// several threads may render at once, each with threads of its own as options->threads says;
// `options` is read before the call returns and not kept. The film's pixels depend on scene and
// options only, not on threads, unless options->time cuts them short.
SATIN_API satin_status satin_render(const satin_scene *scene, const satin_options *options,
                                    const satin_callbacks *callbacks, satin_film **film);

// The statistics of a rendered film as a JSON object, valid as long as the film, which owns it;
// NULL for a film that was read from a file without them. docs/formats.md has the unit of each;
// names that end in `_s` are in seconds. `film` must not be NULL. Thread-safe.
SATIN_API const char *satin_film_stats(const satin_film *film);

#ifdef __cplusplus
}
#endif
#endif
