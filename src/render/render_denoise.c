// SPDX-License-Identifier: Apache-2.0
// Denoising of the light that no record carries. Interpolated light has no noise, but errors that a
// denoiser would take for a part of the scene, so it is not denoised. Emitters that are seen are
// not denoised either. The image is the sum of the denoised light and the rest.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_image.h"

// The mean number of samples per pixel from which albedo and normal count as free of noise.
// Measured on the living room of docs/experiments/denoising.md by path, relMSE with and without
// this assumption: .126 and .098 at 1 sample, .0423 and .0449 at 4, .0263 and .0311 at 8, .0073 and
// .0083 at 76. Denoising both first gives .0415 at 4, .0265 at 8 and .0073 at 76, in three times
// the time.
static const double CLEAN_SAMPLES = 4.0;

enum { DENOISE_CHUNK = 16 };  // rows per chunk

// Context of the filter's progress function.
struct asked {
    struct render *r;
    bool stopped;
};

bool render_denoise_memory(struct render_image *image) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    image->uncached = array_new(pixels, sizeof *image->uncached);
    image->planes = array_new(pixels, 4 * sizeof *image->planes);
    if (!image->uncached || !image->planes) return false;
    rgb *at = image->planes;
    image->noisy = (struct film_noisy){.width = image->width,
                                       .height = image->height,
                                       .light = at,
                                       .albedo = at + pixels,
                                       .normal = at + 2 * pixels,
                                       .denoised = at + 3 * pixels};
    return true;
}

satin_status render_denoiser(struct render *r) {
    if (!r->options.denoise) return SATIN_OK;
    return film_denoiser_open(parallel_threads(r->pool), r->log, &r->denoiser);
}

static void set_plane_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct render_image *image = ctx;
    const struct film_noisy *noisy = &image->noisy;
    rgb *light = image->planes;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < image->width; x++) {
            const size_t at = y * (size_t)image->width + (size_t)x;
            const struct image_pixel *pixel = render_image_source(image, x, (int)y);
            if (!pixel) continue;
            const float scale = render_image_scale(pixel);
            light[at] = rgb_scale(image->uncached[pixel - image->pixel], scale);
            noisy->albedo[at] = rgb_scale(pixel->layer[SHADE_ALBEDO], scale);
            noisy->normal[at] = rgb_scale(pixel->layer[SHADE_NORMAL], scale);
        }
}

static bool goes_on(void *user, double done) {
    struct asked *asked = user;
    if (!asked->stopped) asked->stopped = !render_progress_report(asked->r, done);
    return !asked->stopped;
}

void render_denoise(struct render *r) {
    struct render_image *image = r->image;
    struct asked asked = {r, false};
    parallel_begin_part(r->pool, "denoise");
    parallel_for_all(r->pool, (size_t)image->height, DENOISE_CHUNK, set_plane_rows, image);
    // A coarse image has samples of a few pixels; the other pixels are copies of these.
    if (render_steps(r)->coarse || !render_budget_denoises(r)) {
        log_message(r->log, SATIN_LOG_WARNING, "cancelled: the image is not denoised");
        return;
    }
    const double pixels = (double)image->width * (double)image->height;
    image->noisy.clean = (double)image->taken >= CLEAN_SAMPLES * pixels;
    render_stage_begin(r, STAGE_DENOISE, pixels);
    r->outcome.denoised = film_denoise(r->denoiser, &image->noisy, goes_on, &asked, r->log);
    image->denoised = r->outcome.denoised == SATIN_OK;
    if (r->outcome.denoised == SATIN_CANCELLED)
        log_message(r->log, SATIN_LOG_WARNING, "cancelled: the image is not denoised");
}
