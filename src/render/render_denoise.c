// SPDX-License-Identifier: Apache-2.0
// Denoising of reflected light, as far as noise explains what the denoiser changes. Interpolated
// light has little noise, but errors that a denoiser would take for a part of the scene, and so
// have fine textures. Emitters that are seen are never denoised. The image is the sum of the
// denoised light and the rest.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_image.h"

enum { DENOISE_CHUNK = 16 };  // rows per chunk

// A pixel has all of the denoiser's change if that is at most so many times the noise, in the mean
// over the pixels that are up to EXPLAINED_RADIUS away. By 1, 1.5, 2 and 3 times relMSE x 10^4 of
// sphere-on-floor at draft is 4.56, 4.20, 4.18 and 4.18, and of cornell-glossy at preview .315,
// .321 and .327 by the first three, beside .348 with all of the change; up to 2 and 5 away that of
// the former is 4.24 and 4.18 (docs/experiments/denoising.md).
static const float CHANGE_EXPLAINED = 2.0f;
enum { EXPLAINED_RADIUS = 3 };

// Context of the filter's progress function.
struct asked {
    struct render *r;
    bool stopped;
};

bool render_denoise_memory(struct render_image *image) {
    const size_t pixels = render_pixel_count(image);
    image->uncached = array_new(pixels, sizeof *image->uncached);
    image->planes = array_new(pixels, 4 * sizeof *image->planes);
    image->explained = array_new(pixels, sizeof *image->explained);
    if (!image->uncached || !image->planes || !image->explained) return false;
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

// The sum of the light of a pixel that is denoised: of photons that are seen directly, none.
static rgb denoised_sum(const struct render *r, const struct image_pixel *pixel) {
    if (!r->second_pass.shade.records.cache)
        return r->image->uncached[pixel - r->image->pixel].light;
    return rgb_sub(pixel->beauty, pixel->layer[SHADE_EMISSION]);
}

// ---- Pixels without a sample --------------------------------------------------------------------

static float squared_difference(struct shade_features a, struct shade_features b) {
    const rgb albedo = rgb_sub(a.albedo, b.albedo), normal = rgb_sub(a.normal, b.normal);
    return rgb_mean(rgb_mul(albedo, albedo)) + rgb_mean(rgb_mul(normal, normal));
}

// Albedos below this reflect too little to show the light that falls on them.
static const float LIT_ALBEDO_LEAST = 0.02f;

static float albedo_ratio(float own, float other) {
    return other > LIT_ALBEDO_LEAST ? own / other : 1.0f;
}

// The light of a pixel as another albedo would reflect it.
static rgb reflected_by(const struct render *r, const struct image_pixel *pixel, rgb albedo) {
    const rgb there = render_features_mean(&r->image->uncached[pixel - r->image->pixel]).albedo;
    const rgb light = rgb_scale(denoised_sum(r, pixel), render_image_scale(pixel));
    return rgb_make(light.r * albedo_ratio(albedo.r, there.r),
                    light.g * albedo_ratio(albedo.g, there.g),
                    light.b * albedo_ratio(albedo.b, there.b));
}

// Added to squared differences of features, so that those of noise do not count. With 1e-2 and 1e-4
// the bathroom of docs/experiments/denoising.md has 1.07 and 1.05 times the error.
static const float DIFFERENCE_LEAST = 1e-3f;

// The light at (x, y) by the sampled pixels at the corners of a cell of the first samples around
// it, of which `nearest` is the first: interpolated, where their features are similar.
static rgb interpolated_light(const struct render *r, int x, int y,
                              const struct image_pixel *nearest) {
    const struct render_image *image = r->image;
    const size_t width = (size_t)image->width, first = (size_t)(nearest - image->pixel);
    const int column = (int)(first % width), row = (int)(first / width);
    const struct shade_features own =
        render_features_mean(&image->uncached[(size_t)y * width + (size_t)x]);
    int step = 1;
    while (column + step <= x || row + step <= y) step *= 2;
    const float s = (float)(x - column) / (float)step, t = (float)(y - row) / (float)step;
    rgb sum = rgb_grey(0.0f);
    float all = 0.0f;
    for (int i = 0; i < 4; i++) {
        const int u = column + i % 2 * step, v = row + i / 2 * step;
        if (u >= image->width || v >= image->height) continue;
        const size_t corner = (size_t)v * width + (size_t)u;
        if (!image->pixel[corner].samples) continue;
        const float near = (i % 2 ? s : 1.0f - s) * (i / 2 ? t : 1.0f - t);
        const float difference =
            squared_difference(render_features_mean(&image->uncached[corner]), own);
        const float weight = near / (DIFFERENCE_LEAST + difference);
        sum = rgb_mad(sum, reflected_by(r, &image->pixel[corner], own.albedo), weight);
        all += weight;
    }
    return all > 0.0f ? rgb_scale(sum, 1.0f / all) : reflected_by(r, nearest, own.albedo);
}

static void set_plane_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct render *r = ctx;
    const struct render_image *image = r->image;
    const struct film_noisy *noisy = &image->noisy;
    rgb *light = image->planes;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < image->width; x++) {
            const size_t at = y * (size_t)image->width + (size_t)x;
            const struct image_pixel *pixel = render_image_source(image, x, (int)y);
            if (!pixel) continue;
            const struct image_uncached *own = &image->uncached[at];
            const bool fill = render_is_filled(image, at, pixel);
            const struct shade_features features =
                render_features_mean(fill ? own : &image->uncached[pixel - image->pixel]);
            light[at] = fill ? interpolated_light(r, x, (int)y, pixel)
                             : rgb_scale(denoised_sum(r, pixel), render_image_scale(pixel));
            noisy->albedo[at] = features.albedo;
            noisy->normal[at] = features.normal;
        }
}

// ---- What noise explains ------------------------------------------------------------------------

// The variance of the mean of a pixel's reflected light by its two halves; -1 without both. It is
// too large where one half weighs more than the other: otherwise a bright sample in that half would
// be more than its noise explains, and would remain.
static float variance_by_halves(const struct image_pixel *pixel, const struct image_uncached *sum) {
    const float odd = sum->odd_weight, even = pixel->weight - odd;
    if (!(odd > 0.0f && even > 0.0f)) return -1.0f;
    const rgb all = rgb_sub(pixel->beauty, pixel->layer[SHADE_EMISSION]);
    const rgb difference =
        rgb_sub(rgb_scale(sum->odd, 1.0f / odd), rgb_scale(rgb_sub(all, sum->odd), 1.0f / even));
    const float fraction = maxf(odd, even) / pixel->weight;
    return fraction * fraction * rgb_mean(rgb_mul(difference, difference));
}

static void compare_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct render_image *image = ctx;
    (void)worker;
    for (size_t at = begin * (size_t)image->width; at < end * (size_t)image->width; at++) {
        const rgb change = rgb_sub(image->noisy.denoised[at], image->noisy.light[at]);
        image->explained[at].change = rgb_mean(rgb_mul(change, change));
        image->explained[at].variance = variance_by_halves(&image->pixel[at], &image->uncached[at]);
    }
}

static float unexplained(struct image_denoised p) {
    return p.change - CHANGE_EXPLAINED * p.variance;
}

// The fraction of the denoiser's change that a pixel has: all where the noise is not known. Of the
// pixels around, the one whose change is explained least does not count: it may be one whose
// samples are all far too bright by chance.
static float fraction_at(const struct render_image *image, int x, int y) {
    struct image_denoised sum = {0.0f, 0.0f}, worst = {0.0f, 0.0f};
    for (int v = y - EXPLAINED_RADIUS; v <= y + EXPLAINED_RADIUS; v++)
        for (int u = x - EXPLAINED_RADIUS; u <= x + EXPLAINED_RADIUS; u++) {
            if (u < 0 || v < 0 || u >= image->width || v >= image->height) continue;
            struct image_denoised p =
                image->explained[(size_t)v * (size_t)image->width + (size_t)u];
            if (p.variance < 0.0f) continue;
            if (unexplained(p) > unexplained(worst)) {
                const struct image_denoised better = worst;
                worst = p;
                p = better;
            }
            sum.change += p.change;
            sum.variance += p.variance;
        }
    return unexplained(sum) > 0.0f ? CHANGE_EXPLAINED * sum.variance / sum.change : 1.0f;
}

static void keep_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct render_image *image = ctx;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < image->width; x++) {
            const size_t at = y * (size_t)image->width + (size_t)x;
            const rgb light = image->noisy.light[at];
            rgb *denoised = &image->noisy.denoised[at];
            *denoised = rgb_mad(light, rgb_sub(*denoised, light), fraction_at(image, x, y));
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
    // Without records the light that is denoised is not all of what albedo reflects.
    image->filled = image->filled && r->second_pass.shade.records.cache;
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
    if (image->denoised) {
        parallel_for_all(r->pool, (size_t)image->height, DENOISE_CHUNK, compare_rows, image);
        parallel_for_all(r->pool, (size_t)image->height, DENOISE_CHUNK, keep_rows, image);
    }
    if (r->outcome.denoised == SATIN_CANCELLED)
        log_message(r->log, SATIN_LOG_WARNING, "cancelled: the image is not denoised");
}
