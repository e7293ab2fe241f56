// SPDX-License-Identifier: Apache-2.0
// Denoising of the light that no record carries. Interpolated light has no noise, but errors that a
// denoiser would take for a part of the scene, so it is not denoised, unless pixels have few
// samples. Emitters that are seen are never denoised. The image is the sum of the denoised light
// and the rest.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_image.h"

enum { DENOISE_CHUNK = 16 };  // rows per chunk

// The number of samples per pixel from which on interpolated light is left as it is. Fewer samples
// of a pixel at an edge are on one surface or the other by chance, and so is the light of its
// records: staircase2 has .72 of the error at 2.8 samples if this is denoised, too, veach-ajar .88
// at 9, and data scenes .9 to 1.06 at 9 and .97 to 1.05 at 25 (docs/experiments/denoising.md).
static const double DENOISE_RECORDS_BELOW = 16.0;

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

static bool denoises_records(const struct render *r) {
    const double pixels = (double)r->image->width * (double)r->image->height;
    return r->second_pass.shade.records.cache &&
           (double)r->image->taken < DENOISE_RECORDS_BELOW * pixels;
}

// The sum of the light of a pixel that is denoised; `all`: the light of records, too.
static rgb denoised_sum(const struct image_pixel *pixel, const struct image_uncached *sum,
                        bool all) {
    return all ? rgb_sub(pixel->beauty, pixel->layer[SHADE_EMISSION]) : sum->light;
}

static void set_plane_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct render *r = ctx;
    const struct render_image *image = r->image;
    const bool all = denoises_records(r);
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
            light[at] = rgb_scale(denoised_sum(pixel, sum, all), render_image_scale(pixel));
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
    parallel_for_all(r->pool, (size_t)image->height, DENOISE_CHUNK, set_plane_rows, r);
    // A coarse image has samples of a few pixels; the other pixels are copies of these.
    if (render_steps(r)->coarse || !render_budget_denoises(r)) {
        log_message(r->log, SATIN_LOG_WARNING, "cancelled: the image is not denoised");
        return;
    }
    const double pixels = (double)image->width * (double)image->height;
    render_stage_begin(r, STAGE_DENOISE, pixels);
    r->outcome.denoised = film_denoise(r->denoiser, &image->noisy, goes_on, &asked, r->log);
    image->denoised = r->outcome.denoised == SATIN_OK;
    if (image->denoised && denoises_records(r)) stats_set(&r->stats, "image.denoised_records", 1.0);
    if (r->outcome.denoised == SATIN_CANCELLED)
        log_message(r->log, SATIN_LOG_WARNING, "cancelled: the image is not denoised");
}
