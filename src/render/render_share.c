// SPDX-License-Identifier: Apache-2.0
// How a time limit is shared between records and image. A few pixels are sampled against the
// coarse records that are there; from them and from the rays gathered so far follow, per pixel,
//   the variance of n samples, V n^-1.5 (adapt_variance), and n, if the image gets the share s;
//   the error of the records, ERROR_RAYS q / rays, where q is the mean square of the indirect part
//   of a pixel's light and rays are those that fit into the share 1 - s;
// and s is where their sum is least.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_state.h"

enum { SIDE = 64, SAMPLES = 4, STEPS = 40 };

// Measured on the data scenes at 10 to 20 gather rays and 6 to 15 samples per pixel: the relative
// squared error of a pixel that is all indirect, times the rays per pixel, was 2.7e-3 to 1e-2. The
// image had a variance less than V by 5 to 12 in closed rooms, 2 to 3 in a furnished one: V is of
// two halves of two samples with few light samples, and of three colours.
static const double ERROR_RAYS = 5e-3, VARIANCE_GAIN = 5.0;
static const double SHARE_LEAST = 0.2, SHARE_MOST = 0.8;

struct pilot {
    struct render *r;
    struct adapt adapt;
    struct shade_worker *worker;
    rgb *indirect;  // sums, per pilot pixel
    int columns, rows;
};

static void sample_pixels(void *ctx, size_t begin, size_t end, int worker) {
    struct pilot *pilot = ctx;
    const satin_options *o = &pilot->r->options;
    for (size_t i = begin; i < end; i++) {
        struct adapt_pixel *pixel = &pilot->adapt.pixel[i];
        int column = (int)(i % (size_t)pilot->columns), row = (int)(i / (size_t)pilot->columns);
        int x = (int)((int64_t)(2 * column + 1) * o->width / (2 * pilot->columns));
        int y = (int)((int64_t)(2 * row + 1) * o->height / (2 * pilot->rows));
        shade_pixel_begin(&pilot->worker[worker]);
        while (pixel->count < pixel->target) {
            struct shade_sample s;
            shade_pixel(
                &pilot->r->second_pass.shade, &pilot->worker[worker], x, y, pixel->count,
                (struct gather_lights){o->light_samples, (uint32_t)o->light_samples * pixel->count},
                &s);
            bool finite = rgb_finite(s.beauty);
            rgb light = finite ? rgb_sub(s.beauty, s.layer[SHADE_EMISSION]) : rgb_grey(0.0f);
            rgb indirect = rgb_add(s.layer[SHADE_INDIRECT_DIFFUSE], s.layer[SHADE_INDIRECT_GLOSSY]);
            adapt_add(pixel, light, s.light_variance);
            if (finite) pilot->indirect[i] = rgb_add(pilot->indirect[i], indirect);
        }
    }
}

// The mean of q over the pilot's pixels.
static double mean_square_indirect(const struct pilot *pilot) {
    size_t n = (size_t)pilot->columns * (size_t)pilot->rows;
    double q = 0.0;
    for (size_t i = 0; i < n; i++) {
        const struct adapt_pixel *p = &pilot->adapt.pixel[i];
        float all = rgb_luminance(p->sum), indirect = rgb_luminance(pilot->indirect[i]);
        float part = all > 0.0f ? fminf(indirect / all, 1.0f) : 0.0f;
        q += (double)(part * part) / (double)n;
    }
    return q;
}

static bool pilot_make(struct pilot *pilot, struct render *r) {
    const int workers = parallel_threads(r->pool);
    int columns = r->options.width < SIDE ? r->options.width : SIDE;
    int rows = r->options.height < SIDE ? r->options.height : SIDE;
    *pilot = (struct pilot){.r = r, .columns = columns, .rows = rows};
    pilot->worker = array_new((size_t)workers, sizeof *pilot->worker);
    pilot->indirect = array_new((size_t)columns * (size_t)rows, sizeof *pilot->indirect);
    if (!pilot->worker || !pilot->indirect) return false;
    for (int i = 0; i < workers; i++) pilot->worker[i].scratch = r->second_pass.shade.scratch[i];
    return adapt_make(&pilot->adapt, columns, rows, r->options.light_samples);
}

static void pilot_destroy(struct pilot *pilot) {
    adapt_destroy(&pilot->adapt);
    free(pilot->worker);
    free(pilot->indirect);
}

satin_status render_share(struct render *r, double rays_per_second, double *best) {
    struct pilot pilot;
    double least = INFINITY, start = stats_wall();
    const bool made = pilot_make(&pilot, r);
    const double stop_at = r->budget.stop_at;
    bool ok = made;
    r->budget.stop_at = INFINITY;  // it is short
    for (uint32_t n = SAMPLES / 2; ok && n <= SAMPLES; n += SAMPLES / 2) {
        adapt_even(&pilot.adapt, n);
        ok = parallel_for(r->pool, (size_t)pilot.columns * (size_t)pilot.rows, 16, sample_pixels,
                          &pilot);
        adapt_judge(&pilot.adapt);
    }
    r->budget.stop_at = stop_at;
    double pixels = (double)r->options.width * (double)r->options.height, V = 0.0, q = 0.0;
    double samples = (double)SAMPLES * pilot.columns * pilot.rows;
    double samples_per_second = samples / fmax(stats_wall() - start, 1e-9);
    double left = render_time_left(r) - render_write_seconds(r);
    if (ok && left > 0.0) {
        V = adapt_variance(&pilot.adapt);
        q = mean_square_indirect(&pilot);
    }
    for (int i = 0; ok && left > 0.0 && i <= STEPS; i++) {
        double share = SHARE_LEAST + (SHARE_MOST - SHARE_LEAST) * i / STEPS;
        double n = share * left * samples_per_second / pixels;
        double rays = (1.0 - share) * left * rays_per_second / pixels;
        double error = V / VARIANCE_GAIN / (n * sqrt(n)) + ERROR_RAYS * q / fmax(rays, 1e-9);
        if (!(error < least)) continue;
        least = error;
        *best = 1.0 - share;
    }
    pilot_destroy(&pilot);
    return made ? SATIN_OK : SATIN_ERROR_MEMORY;
}
