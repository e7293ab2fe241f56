// SPDX-License-Identifier: Apache-2.0
// Rendering: scene and options in, film out.
#ifndef SATIN_RENDER_H
#define SATIN_RENDER_H

#include "satin/animation.h"
#include "satin/film.h"
#include "satin/options.h"
#include "satin/ranks.h"
#include "satin/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// The progress of a render. `stage` is one of these static texts, in this order; stages that the
// options do not need are left out:
//   forecast          a small render, if the caller asks for a forecast
//   photons           photon maps and the first-pass radiance estimate
//   BRDF tables       glossy BRDFs in harmonics
//   indirect bounces  records at the surfaces of indirect bounces, by first pass `recursive`
//   records           records at the surfaces that the image shows
//   image             samples of the pixels
//   denoising         if options->denoise asks for it
// `done` is the fraction of the stage in [0, 1]; of the image, that of its time if options->time
// ends it. `rate` is the number of items of the stage per second, and `unit` their name; they are 0
// and "" if items are not counted. `elapsed` is in seconds since the render began. `left` is the
// number of seconds until the whole render ends: by the speed of the image so far, but at most what
// is left of options->time, from which it is known in all stages. During records the image is taken
// to last as long as it usually does after such records, so that the whole is right within half of
// it or so; and so is it from the photons on with a forecast. Denoising after an image without a
// time limit is not included. Negative: not known. Of an animation, `frame` is the number of images
// that were begun, of `frames`, and `left` includes all of them; else both are 0. Texts are static,
// and a stage has the same pointer in all calls; the struct is valid during the call.
typedef struct satin_progress {
    const char *stage, *unit;
    double done, rate, elapsed, left;
    int frame, frames;
} satin_progress;

// Called on the thread that called satin_render, about ten times a second and only during that
// call, so it needs no lock unless renders on several threads have the same `user`. Returning true
// cancels the render. It must not free the scene of the render.
typedef bool (*satin_progress_fn)(void *user, const satin_progress *progress);

// Shows the image while it is sampled. `film` is what the image would be if it ended now: each
// pixel has the mean of the samples that it has so far, whatever their number, and a pixel without
// a sample the values of a neighbour. Its channels are those of the finished image, or the beauty
// alone (satin_callbacks.snapshot_beauty); it is not denoised, and has no statistics. It is owned
// by the render, and is valid and does not change until the next call of this function or until
// satin_render returns.
//
// Called on the thread that called satin_render, during the stage `image`, from when a coarse grid
// of pixels has its first samples, about once a second: less often if the calls, with what the
// caller does in them, would take more than a fiftieth of the time of all threads or a tenth of
// that of this one. It does not affect the finished image, unless options->time cuts it short.
typedef void (*satin_snapshot_fn)(void *user, const satin_film *film);

// Functions that a render calls, and the files of its records. The struct and its texts are owned
// by the caller and must be valid until satin_render returns.
typedef struct satin_callbacks {
    satin_log_fn log;  // NULL: no messages
    void *log_user;
    satin_progress_fn progress;  // NULL: no progress, no cancellation
    void *progress_user;
    // Whether progress->left shall be known from the photons on, where two passes have no limit of
    // time. A small render measures that first, which takes a hundredth of the time or so. It does
    // not affect the image. Not of an animation, a render that is resumed, one with fewer than
    // 100,000 samples, and first pass `recursive`.
    bool forecast;
    // Files of cache records: read before records are made, and written after. NULL: none. The file
    // must have been made for the same scene, with any sensor, and with the same options, except
    // those that do not affect records; otherwise SATIN_ERROR_INPUT, with one logged line. The same
    // error is returned if save_cache is a file from which the scene was read. save_cache may be
    // load_cache, which is replaced when all records are complete.
    const char *load_cache, *save_cache;
    satin_snapshot_fn snapshot;  // NULL: none, which costs nothing
    void *snapshot_user;
    bool
        snapshot_beauty;  // snapshots have the channels R, G and B, and A if the film has it, alone
    // The caller will write the film with full floats: a time limit leaves twice the time for that.
    bool full_float;
    // File from which an interrupted render goes on, and that is written while it goes on; NULL:
    // none. With `resume` a file that exists is read: it must have been made by the same version of
    // satin for the same scene and options, but for the number of threads, and the image is then
    // that of a render which was not interrupted. If options->spp is larger, samples are added.
    // Without `resume`, or if it does not exist, the file is made, and replaced if it is a
    // checkpoint. All else is refused with SATIN_ERROR_INPUT, and so is options->time.
    const char *checkpoint;
    bool resume;
    // The state of the image is written to the checkpoint after so many seconds; 0: 60. So are the
    // results of other work that takes longer.
    double checkpoint_seconds;
    // The processes that render together; NULL: this one alone. Rank 0 has the film; the others
    // have one whose pixels are the same. Their files of records and checkpoints are not written.
    const satin_ranks *ranks;
    // The frames of an animation, each of which is an image; NULL: there is one image. Its
    // checkpoint has what all frames have in common, and is removed when they are complete. An
    // animation has no time limit, and is not rendered by SATIN_SPPM, which changes its photons
    // during an image: these are refused with SATIN_ERROR_INPUT, logged.
    const satin_animation *animation;
} satin_callbacks;

// Renders. `callbacks` may be NULL. The caller sets *film to NULL before the call, as it is set
// only if there is an image, and frees it with satin_film_free. The images of an animation are
// passed to its function instead, and *film is not set.
//
// SATIN_CANCELLED: the progress function cancelled the render. *film is then the image so far, as
// of a render with fewer samples, in which pixels without a sample have the values of neighbours.
// If the render is cancelled before the image is begun, a coarse one is made within about half a
// second, of direct light alone if the photons were not complete or a sample takes that long. A
// cancelled image is denoised if that takes less than half a second.
//
// If only the records could not be written to save_cache, or the checkpoint could not be written,
// or the image could not be denoised, *film is the whole image, in the latter case noisy, and the
// status is that of this failure.
//
// SATIN_ERROR_INPUT: an option is not in its range, as in a zeroed struct; options->denoise is set
// and the denoiser is not installed; both are detected before anything is rendered; or a file of
// records does not fit; SATIN_ERROR_ARGUMENT: a pointer other than `callbacks` is NULL;
// SATIN_ERROR_IO; SATIN_ERROR_MEMORY; SATIN_ERROR_INTERNAL: a library failed.
//
// Radiance is in W m^-2 sr^-1, lengths are in the scene's unit, options->time is in seconds. All
// memory of a render but the film is freed when it ends, whatever its status, so that a program may
// render as often as it needs to. Thread-safe: several threads may render the same scene at once,
// each with threads of its own as options->threads sets; `options` is not used after the call
// returns. The film's pixels depend only on scene and options, not on threads, unless options->time
// cuts the render short.
SATIN_API satin_status satin_render(const satin_scene *scene, const satin_options *options,
                                    const satin_callbacks *callbacks, satin_film **film);

// The statistics of a rendered film as a JSON object, owned by the film; NULL for a film that was
// read from a file without them. docs/formats.md has the unit of each; names that end in `_s` are
// in seconds. `film` must not be NULL. Thread-safe.
SATIN_API const char *satin_film_stats(const satin_film *film);

#ifdef __cplusplus
}
#endif
#endif
