// SPDX-License-Identifier: Apache-2.0
// Pilots of a render with a time limit: they sample a few pixels, with the first records and with
// the coarse records of the first round, to measure what determines the division of time between
// records and image (render_budget.h): samples per second, their variance, and the fraction of the
// light that is from records.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "render/render_state.h"

// Sums over the samples of a pixel.
struct pilot_pixel {
    rgb indirect;
    float direct, direct2;  // luminance of direct light and caustics, and its square
};

struct image_pilot {
    struct render *r;
    struct adaptive_sampling adapt;
    struct shade_worker *worker;
    struct pilot_pixel *pixel;
    int columns, rows;
};

static void add_to_pixel(struct pilot_pixel *pixel, const struct shade_sample *s) {
    const rgb indirect = rgb_add(s->layer[SHADE_INDIRECT_DIFFUSE], s->layer[SHADE_INDIRECT_GLOSSY]);
    const float y = rgb_luminance(rgb_add(s->layer[SHADE_DIRECT], s->layer[SHADE_CAUSTIC]));
    pixel->indirect = rgb_add(pixel->indirect, indirect);
    pixel->direct += y;
    pixel->direct2 += y * y;
}

static void sample_pixels(void *ctx, size_t begin, size_t end, int worker) {
    struct image_pilot *pilot = ctx;
    const satin_options *o = &pilot->r->options;
    for (size_t i = begin; i < end; i++) {
        struct adaptive_pixel *pixel = &pilot->adapt.pixel[i];
        int column = (int)(i % (size_t)pilot->columns), row = (int)(i / (size_t)pilot->columns);
        int x = (int)((int64_t)(2 * column + 1) * o->width / (2 * pilot->columns));
        int y = (int)((int64_t)(2 * row + 1) * o->height / (2 * pilot->rows));
        shade_tile_begin(&pilot->worker[worker]);
        shade_pixel_begin(&pilot->worker[worker]);
        while (pixel->count < pixel->target) {
            struct shade_sample s;
            shade_pixel(&pilot->r->second_pass.shade, &pilot->worker[worker], x, y, pixel->count,
                        render_adaptive_next(pixel), &s);
            render_adaptive_add(pixel, &s);
            if (shade_sample_finite(&s)) add_to_pixel(&pilot->pixel[i], &s);
        }
    }
}

// The mean of q over the pilot's pixels.
static double mean_square_indirect(const struct image_pilot *pilot) {
    size_t n = (size_t)pilot->columns * (size_t)pilot->rows;
    double q = 0.0;
    for (size_t i = 0; i < n; i++) {
        const struct adaptive_pixel *p = &pilot->adapt.pixel[i];
        float all = rgb_luminance(p->sum), indirect = rgb_luminance(pilot->pixel[i].indirect);
        float fraction = all > 0.0f ? fminf(indirect / all, 1.0f) : 0.0f;
        q += (double)(fraction * fraction) / (double)n;
    }
    return q;
}

// The mean over the pixels of the variance of direct light by one sample, relative to the square of
// the pixel's light plus a hundredth of that of the mean of all, as errors of images are.
static double direct_variance(const struct image_pilot *pilot) {
    const size_t n = (size_t)pilot->columns * (size_t)pilot->rows;
    const double count = RENDER_PILOT_SAMPLES;
    double mean = 0.0, sum = 0.0;
    for (size_t i = 0; i < n; i++)
        mean += rgb_luminance(pilot->adapt.pixel[i].sum) / count / (double)n;
    for (size_t i = 0; i < n; i++) {
        const struct pilot_pixel *p = &pilot->pixel[i];
        const double all = rgb_luminance(pilot->adapt.pixel[i].sum) / count;
        const double direct = p->direct / count, direct2 = p->direct2 / count;
        const double variance = fmax(direct2 - direct * direct, 0.0) * count / (count - 1.0);
        const double square = all * all + 0.01 * mean * mean;
        if (square > 0.0) sum += variance / square;
    }
    return sum / (double)n;
}

static bool pilot_make(struct image_pilot *pilot, struct render *r, int side) {
    const int workers = parallel_threads(r->pool);
    const int columns = r->options.width < side ? r->options.width : side;
    const int rows = r->options.height < side ? r->options.height : side;
    *pilot = (struct image_pilot){.r = r, .columns = columns, .rows = rows};
    pilot->worker = array_new((size_t)workers, sizeof *pilot->worker);
    pilot->pixel = array_new((size_t)columns * (size_t)rows, sizeof *pilot->pixel);
    if (!pilot->worker || !pilot->pixel) return false;
    for (int i = 0; i < workers; i++) pilot->worker[i].gather = r->second_pass.shade.worker[i];
    return render_adaptive_make(&pilot->adapt, columns, rows, r->options.light_samples,
                                render_budget_first_gathers(&r->options));
}

static void pilot_destroy(struct image_pilot *pilot) {
    render_adaptive_destroy(&pilot->adapt);
    free(pilot->worker);
    free(pilot->pixel);
}

// Samples a grid of pixels, so many along a side.
static satin_status sample_grid(struct render *r, int side, struct render_pace *pace) {
    struct image_pilot pilot;
    if (!pilot_make(&pilot, r, side)) {
        pilot_destroy(&pilot);
        return SATIN_ERROR_MEMORY;
    }
    const size_t pixels = (size_t)pilot.columns * (size_t)pilot.rows;
    const char *part = parallel_begin_part(r->pool, "pilot");
    const double start = stats_wall(), limit = render_limit_lift(r);
    bool whole = true;
    for (uint32_t n = RENDER_PILOT_SAMPLES / 2; whole && n <= RENDER_PILOT_SAMPLES;
         n += RENDER_PILOT_SAMPLES / 2) {
        render_adaptive_equal(&pilot.adapt, 1, n);
        whole = parallel_for(r->pool, pixels, 16, sample_pixels, &pilot);
        render_adaptive_compare(&pilot.adapt);
    }
    render_limit_restore(r, limit);
    parallel_begin_part(r->pool, part);
    if (whole) {
        const double seconds = render_agreed(r, stats_wall() - start);
        pace->samples = RENDER_PILOT_SAMPLES * (double)pixels / fmax(seconds, 1e-9);
        pace->variance = render_adaptive_variance(&pilot.adapt);
        pace->direct = direct_variance(&pilot);
        pace->indirect2 = mean_square_indirect(&pilot);
    }
    pilot_destroy(&pilot);
    return whole ? SATIN_OK : SATIN_CANCELLED;
}

satin_status render_first_pilot(struct render *r, struct render_pace *pace) {
    return sample_grid(r, RENDER_PILOT_LEAST, pace);
}

// A small grid shows the speed, and how large a grid the time allows.
satin_status render_image_pilot(struct render *r, struct render_pace *pace) {
    satin_status status = render_first_pilot(r, pace);
    const int side = render_budget_pilot(r, pace->samples);
    if (status != SATIN_OK || side <= RENDER_PILOT_LEAST) return status;
    return sample_grid(r, side, pace);
}
