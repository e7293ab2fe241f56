// SPDX-License-Identifier: Apache-2.0
// Rays for albedo and normal alone, in pixels of an image to be denoised where these vary. From
// features without noise the denoiser knows where edges are, whose pixels may have very few samples
// of light. Such a ray costs a tenth of a sample or less (docs/experiments/denoising.md).
#include <math.h>

#include "render/render_image.h"

enum {
    FEATURES_CLEAN = 8,     // samples and rays of a pixel from which on its features have no noise
    FEATURES_MOST = 32,     // up to which there are rays, a power of two
    FEATURES_TIMED = 4096,  // rays that show how long one takes
    FEATURES_CHUNK = 1024   // pixels per chunk
};

// Largest difference between two pixels where features do not vary.
static const float FEATURES_ALIKE = 0.1f;
// Fraction of the remaining time of the image that rays may take, and what the denoiser's network
// for features without noise takes beyond the other one.
static const double FEATURES_FRACTION = 1.0 / 8.0;
// Fraction of the time limit that rays of pixels without a sample may take after it.
static const double LATE_FRACTION = 0.02;

// The context of loops over pixels.
struct features {
    struct render *r;
    struct image_uncached *pixel;
};

static float find_features(const struct render *r, size_t at, uint32_t index,
                           struct shade_features *found) {
    const size_t width = (size_t)r->image->width;
    return shade_find_features(&r->second_pass.shade, (int)(at % width), (int)(at / width), index,
                               found);
}

// ---- Where features vary ------------------------------------------------------------------------

static bool differ(rgb a, rgb b) {
    return fmaxf(fmaxf(fabsf(a.r - b.r), fabsf(a.g - b.g)), fabsf(a.b - b.b)) > FEATURES_ALIKE;
}

static bool differ_at(const struct image_uncached *a, const struct image_uncached *b) {
    const struct shade_features x = render_features_mean(a), y = render_features_mean(b);
    return differ(x.albedo, y.albedo) || differ(x.normal, y.normal);
}

// Whether a pixel differs from one of the eight around.
static bool varies(const struct features *f, size_t at) {
    const int width = f->r->image->width, height = f->r->image->height;
    const int x = (int)(at % (size_t)width), y = (int)(at / (size_t)width);
    for (int i = 0; i < 9; i++) {
        const int u = x + i % 3 - 1, v = y + i / 3 - 1;
        if (u >= 0 && u < width && v >= 0 && v < height &&
            differ_at(&f->pixel[at], &f->pixel[(size_t)v * (size_t)width + (size_t)u]))
            return true;
    }
    return false;
}

// Marks these pixels by a wanted ray.
static void find_varying(void *ctx, size_t begin, size_t end, int worker) {
    const struct features *f = ctx;
    (void)worker;
    for (size_t at = begin; at < end; at++) f->pixel[at].wanted = varies(f, at);
}

// ---- How many rays ------------------------------------------------------------------------------

static void time_features(void *ctx, size_t begin, size_t end, int worker) {
    const struct features *f = ctx;
    const size_t step = render_pixel_count(f->r->image) / FEATURES_TIMED + 1;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct shade_features found;
        (void)find_features(f->r, i * step, 0, &found);
    }
}

// The time of a ray, measured at some that do not count.
static double feature_seconds(struct features *f) {
    const size_t timed =
        render_pixel_count(f->r->image) / (render_pixel_count(f->r->image) / FEATURES_TIMED + 1);
    const double start = stats_wall();
    parallel_for_all(f->r->pool, timed, FEATURES_CHUNK / 16, time_features, f);
    return render_agreed(f->r, stats_wall() - start) / (double)timed;
}

// Whether there is time for the denoiser's network for features without noise, which is slower.
static bool can_be_clean(const struct render *r, double most) {
    const double pixel_seconds = r->denoiser ? film_denoiser_pixel_seconds(r->denoiser, true) -
                                                   film_denoiser_pixel_seconds(r->denoiser, false)
                                             : 0.0;
    return pixel_seconds * (double)render_pixel_count(r->image) <= most;
}

// The samples that a pixel is expected to have in the end.
static double expected_samples(const struct render *r, double left) {
    const struct render_image *image = r->image;
    const double more = isfinite(left) ? fmax(left, 0.0) / image->sample_seconds : INFINITY;
    return fmin((double)r->options.spp,
                ((double)image->taken + more) / (double)render_pixel_count(r->image));
}

// Finds where features vary, and gives these pixels as many rays as fit into the time that is left
// for the image [s].
static void plan_features(struct features *f, double left) {
    struct render *r = f->r;
    const double samples = expected_samples(r, left), most = FEATURES_FRACTION * left;
    parallel_for_all(r->pool, render_pixel_count(r->image), FEATURES_CHUNK, find_varying, f);
    size_t count = 0;
    for (size_t i = 0; i < render_pixel_count(r->image); i++) count += f->pixel[i].wanted;
    const double seconds = isfinite(most) ? feature_seconds(f) * (double)count : 0.0;
    uint16_t rays = FEATURES_MOST;
    while (rays > 0 && (samples + rays > FEATURES_MOST || seconds * rays > most)) rays /= 2;
    for (size_t i = 0; i < render_pixel_count(r->image); i++) f->pixel[i].wanted *= rays;
    r->image->noisy.clean = samples + rays >= FEATURES_CLEAN && can_be_clean(r, most);
    r->image->has_features = true;
    stats_add(&r->stats, "image.feature_rays",
              (double)rays * (double)count / (double)render_pixel_count(r->image));
}

// ---- The rays -----------------------------------------------------------------------------------

static void trace_features(void *ctx, size_t begin, size_t end, int worker) {
    const struct features *f = ctx;
    (void)worker;
    for (size_t at = begin; at < end; at++) {
        struct image_uncached *pixel = &f->pixel[at];
        for (; pixel->rays < pixel->wanted; pixel->rays++) {
            struct shade_features found;
            const float weight = find_features(f->r, at, pixel->rays, &found);
            render_features_add(pixel, &found,
                                render_usable_weight(pixel->weight, pixel->count, weight));
        }
    }
}

satin_status render_features(struct render *r) {
    struct render_image *image = r->image;
    if (!r->options.denoise || render_steps(r)->coarse ||
        image->taken < render_pixel_count(r->image))
        return SATIN_OK;
    struct features f = {.r = r, .pixel = image->uncached};
    const struct parallel_results results = {.slot = {{f.pixel, sizeof *f.pixel}}};
    const double limit = render_limit_lift(r);
    parallel_begin_part(r->pool, "features");
    if (!image->has_features) plan_features(&f, render_agreed(r, limit - render_elapsed(r)));
    const bool whole = parallel_for_results(r->pool, render_pixel_count(r->image), FEATURES_CHUNK,
                                            trace_features, &f, &results);
    render_limit_restore(r, limit);
    return whole ? SATIN_OK : SATIN_CANCELLED;
}

static bool is_missing(const struct features *f, size_t at) {
    const struct image_pixel *pixel = &f->r->image->pixel[at];
    return !pixel->samples && !pixel->dropped && f->pixel[at].weight == 0.0f;
}

static void trace_missing(void *ctx, size_t begin, size_t end, int worker) {
    const struct features *f = ctx;
    (void)worker;
    for (size_t at = begin; at < end; at++) {
        struct shade_features found;
        if (!is_missing(f, at)) continue;
        const float weight = find_features(f->r, at, 0, &found);
        if (weight > 0.0f) render_features_add(&f->pixel[at], &found, weight);
    }
}

satin_status render_features_late(struct render *r) {
    struct render_image *image = r->image;
    if (!r->options.denoise || render_cancelled(r) || render_steps(r)->coarse ||
        !(r->options.time > 0.0) || image->taken >= render_pixel_count(r->image))
        return SATIN_OK;
    struct features f = {.r = r, .pixel = image->uncached};
    const struct parallel_results results = {.slot = {{f.pixel, sizeof *f.pixel}}};
    const double limit = render_limit_lift(r);
    size_t count = 0;
    for (size_t at = 0; at < render_pixel_count(r->image); at++) count += is_missing(&f, at);
    image->filled = (double)count * feature_seconds(&f) <= LATE_FRACTION * r->options.time;
    parallel_begin_part(r->pool, "features");
    const bool whole =
        !image->filled || parallel_for_results(r->pool, render_pixel_count(r->image),
                                               FEATURES_CHUNK, trace_missing, &f, &results);
    render_limit_restore(r, limit);
    return whole ? SATIN_OK : SATIN_CANCELLED;
}
