// SPDX-License-Identifier: Apache-2.0
// Denoising of the light that no record carries. Interpolated light has no noise, but errors that a
// denoiser would take for a part of the scene, so it is not denoised. Emitters that are seen are
// not denoised either. The image is the sum of the denoised light and the rest.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_image.h"

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
            const struct image_uncached *sum = &image->uncached[pixel - image->pixel];
            const struct shade_features features = render_features_mean(sum);
            light[at] = rgb_scale(sum->light, render_image_scale(pixel));
            noisy->albedo[at] = features.albedo;
            noisy->normal[at] = features.normal;
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
    render_stage_begin(r, STAGE_DENOISE, pixels);
    r->outcome.denoised = film_denoise(r->denoiser, &image->noisy, goes_on, &asked, r->log);
    image->denoised = r->outcome.denoised == SATIN_OK;
    if (r->outcome.denoised == SATIN_CANCELLED)
        log_message(r->log, SATIN_LOG_WARNING, "cancelled: the image is not denoised");
}
