// SPDX-License-Identifier: Apache-2.0
// Denoising by Open Image Denoise's filter for ray-traced images, with albedo and normal as
// auxiliary images. It runs on the CPU, where its result does not depend on the number of threads
// (docs/experiments/denoising.md).
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/stats.h"
#include "film/film.h"
#include "film/film_oidn.h"

struct film_denoiser {
    struct oidn oidn;
    struct oidn_device *device;
    char name[64];
    double pixel_seconds;
};

// The status of an error; `broken` is that of an error other than lack of memory.
static satin_status status_of(int error, const char *message, satin_status broken, struct log log) {
    if (error == OIDN_NO_ERROR) return SATIN_OK;
    if (error == OIDN_CANCELLED) return SATIN_CANCELLED;
    return log_fail(log, error == OIDN_OUT_OF_MEMORY ? SATIN_ERROR_MEMORY : broken,
                    "Open Image Denoise failed: %s", message);
}

// The status of the preceding calls on this thread; `made` is whether they succeeded.
static satin_status device_status(const struct film_denoiser *d, bool made, satin_status broken,
                                  struct log log) {
    const char *message = NULL;
    const int error = d->oidn.GetDeviceError(d->device, &message);
    if (error == OIDN_NO_ERROR && made) return SATIN_OK;
    return status_of(error ? error : OIDN_UNKNOWN, message ? message : "it does not say why",
                     broken, log);
}

// ---- One filter ---------------------------------------------------------------------------------

// Limits the memory, by tiles if necessary, so that an image does not depend on the memory of the
// machine. Measured with 2.5.1 on 8.3 million pixels: 1.16 GB in all, of which .4 are images, and
// 3.25 us of CPU time per pixel; 1.82 GB and 3.02 us with 2000; 2.99 GB and 3.4 us without a limit.
enum { MEMORY_MB = 1000 };

static void bind(const struct film_denoiser *d, struct oidn_filter *filter, const char *name,
                 rgb *image, const struct film_noisy *of) {
    d->oidn.SetSharedFilterImage(filter, name, image, OIDN_FLOAT3, (size_t)of->width,
                                 (size_t)of->height, 0, sizeof *image, 0);
}

static satin_status run_filter(const struct film_denoiser *d, const struct film_noisy *image,
                               bool (*goes_on)(void *user, double done), void *user,
                               satin_status broken, struct log log) {
    const struct oidn *oidn = &d->oidn;
    struct oidn_filter *filter = oidn->NewFilter(d->device, "RT");
    satin_status status = device_status(d, filter, broken, log);
    if (status != SATIN_OK) return status;
    bind(d, filter, "color", image->denoised, image);
    bind(d, filter, "albedo", image->albedo, image);
    bind(d, filter, "normal", image->normal, image);
    bind(d, filter, "output", image->denoised, image);
    oidn->SetFilterBool(filter, "hdr", true);
    oidn->SetFilterBool(filter, "cleanAux", image->clean);
    oidn->SetFilterInt(filter, "maxMemoryMB", MEMORY_MB);
    status = device_status(d, true, broken, log);
    if (status == SATIN_OK) {
        char text[OIDN_TEXT];
        const int error = film_oidn_execute(oidn, d->device, filter, goes_on, user, text);
        status = status_of(error, text, broken, log);
    }
    oidn->ReleaseFilter(filter);
    return status;
}

// ---- The range of values ------------------------------------------------------------------------

// The filter needs images whose logarithmic mean is near 1, and finite sums. Measured: of an image
// of 1e-12 it made 17,000 times as much light, and a pixel of 3e38 made everything black; a bright
// square of 1e7 times the rest was within 2 %.
#define BRIGHTEST 0x1p24f

static rgb clamp_color(rgb value, float most) {
    return rgb_make(clampf(value.r, 0.0f, most), clampf(value.g, 0.0f, most),
                    clampf(value.b, 0.0f, most));
}

// The power of two nearest to the logarithmic mean of all pixels that are not black; 0: all are
// black.
static float mean_scale(const rgb *light, size_t pixels) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < pixels; i++) {
        const float most = rgb_max(light[i]);
        if (!(most > 0.0f)) continue;
        sum += log2((double)most);
        count++;
    }
    if (count == 0) return 0.0f;
    // The smallest powers of two have no inverse in float.
    return ldexpf(1.0f, (int)fmin(fmax(round(sum / (double)count), -100.0), 100.0));
}

static void clamp_auxiliary(const struct film_noisy *image, size_t pixels) {
    for (size_t i = 0; i < pixels; i++) {
        rgb *normal = &image->normal[i];
        image->albedo[i] = clamp_color(image->albedo[i], 1.0f);
        *normal = rgb_make(clampf(normal->r, -1.0f, 1.0f), clampf(normal->g, -1.0f, 1.0f),
                           clampf(normal->b, -1.0f, 1.0f));
    }
}

satin_status film_denoise(struct film_denoiser *denoiser, const struct film_noisy *image,
                          bool (*goes_on)(void *user, double done), void *user, struct log log) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    const float scale = mean_scale(image->light, pixels), most = scale * BRIGHTEST;
    for (size_t i = 0; i < pixels; i++)
        image->denoised[i] = scale > 0.0f
                                 ? rgb_scale(clamp_color(image->light[i], most), 1.0f / scale)
                                 : image->light[i];
    if (!(scale > 0.0f)) return SATIN_OK;
    clamp_auxiliary(image, pixels);
    const satin_status status =
        run_filter(denoiser, image, goes_on, user, SATIN_ERROR_INTERNAL, log);
    if (status != SATIN_OK) return status;
    for (size_t i = 0; i < pixels; i++) {
        const rgb given = clamp_color(image->light[i], most);
        const rgb made = rgb_scale(image->denoised[i], scale);
        image->denoised[i] = rgb_add(made, rgb_sub(image->light[i], given));
        if (!rgb_finite(image->denoised[i]))
            return log_fail(log, SATIN_ERROR_INTERNAL,
                            "Open Image Denoise failed: its result is not finite");
    }
    return SATIN_OK;
}

// ---- Opening it ---------------------------------------------------------------------------------

enum { TRY_SIDE = 128, TRY_PIXELS = TRY_SIDE * TRY_SIDE };

// Denoises a small image twice: the first time the library reads 50 MB of weights from the disk and
// initialises itself.
static satin_status test_denoiser(struct film_denoiser *d, struct log log) {
    rgb *all = array_new(3 * (size_t)TRY_PIXELS, sizeof *all);
    if (!all) return SATIN_ERROR_MEMORY;
    const struct film_noisy image = {.width = TRY_SIDE,
                                     .height = TRY_SIDE,
                                     .albedo = all + TRY_PIXELS,
                                     .normal = all + 2 * TRY_PIXELS,
                                     .denoised = all};
    satin_status status = run_filter(d, &image, NULL, NULL, SATIN_ERROR_INPUT, log);
    const double start = stats_wall();
    if (status == SATIN_OK) status = run_filter(d, &image, NULL, NULL, SATIN_ERROR_INPUT, log);
    d->pixel_seconds = (stats_wall() - start) / TRY_PIXELS;
    free(all);
    return status;
}

static satin_status open_device(struct film_denoiser *d, int threads, struct log log) {
    const struct oidn *oidn = &d->oidn;
    d->device = oidn->NewDevice(OIDN_CPU);
    if (!d->device) return device_status(d, false, SATIN_ERROR_INPUT, log);
    oidn->SetDeviceInt(d->device, "numThreads", threads);
    // Otherwise it would pin the calling thread to a core.
    oidn->SetDeviceBool(d->device, "setAffinity", false);
    oidn->CommitDevice(d->device);
    const satin_status status = device_status(d, true, SATIN_ERROR_INPUT, log);
    if (status != SATIN_OK) return status;
    const int version = oidn->GetDeviceInt(d->device, "version");
    snprintf(d->name, sizeof d->name, "Open Image Denoise %d.%d.%d", version / 10000,
             version / 100 % 100, version % 100);
    return SATIN_OK;
}

satin_status film_denoiser_open(int threads, struct log log, struct film_denoiser **out) {
    struct film_denoiser *d = calloc(1, sizeof *d);
    if (!d) return SATIN_ERROR_MEMORY;
    satin_status status = film_oidn_open(log, &d->oidn);
    if (status == SATIN_OK) status = open_device(d, threads, log);
    if (status == SATIN_OK) status = test_denoiser(d, log);
    if (status == SATIN_OK)
        *out = d;
    else
        film_denoiser_free(d);
    return status;
}

void film_denoiser_free(struct film_denoiser *denoiser) {
    if (!denoiser) return;
    if (denoiser->device) denoiser->oidn.ReleaseDevice(denoiser->device);
    free(denoiser);
}

const char *film_denoiser_name(const struct film_denoiser *denoiser) { return denoiser->name; }

// Without noise in albedo and normal, 2.5.1 uses a larger network, which takes 2.3 times as long at
// 640x360, and 2.4 times at the size of the small image.
double film_denoiser_pixel_seconds(const struct film_denoiser *denoiser, bool clean) {
    return (clean ? 2.35 : 1.0) * denoiser->pixel_seconds;
}
