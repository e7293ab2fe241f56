// SPDX-License-Identifier: Apache-2.0
// The image pass: samples summed per pixel, tile by tile. A pixel's samples are added in the order
// of their numbers, by one worker, so sums do not depend on threads.
#include <stdio.h>
#include <stdlib.h>

#include "base/array.h"
#include "render/render_state.h"

enum { TILE = 16, PASS_SAMPLES = 4 };

// Of a render with a time limit: kept back for writing the film.
static const double WRITE_SECONDS = 0.12;

struct pixel {
    rgb beauty;
    rgb layer[SHADE_LAYERS];
    float depth, density;
    uint32_t samples, dropped;
};

struct render_image {
    int width, height;
    struct pixel *pixel;
    uint32_t done;  // samples that every pixel has
};

struct pass {
    struct render *r;
    uint32_t begin, end;          // sample numbers
    struct shade_counts *counts;  // per worker
    int columns;
};

struct render_image *render_image_new(int width, int height) {
    struct render_image *image = calloc(1, sizeof *image);
    if (!image) return NULL;
    *image = (struct render_image){.width = width, .height = height};
    image->pixel = array_new((size_t)width * (size_t)height, sizeof *image->pixel);
    if (image->pixel) return image;
    free(image);
    return NULL;
}

void render_image_free(struct render_image *image) {
    if (!image) return;
    free(image->pixel);
    free(image);
}

static void add_sample(struct pixel *pixel, const struct shade_sample *s) {
    bool finite = rgb_finite(s->beauty);
    for (int i = 0; i < SHADE_LAYERS; i++) finite = finite && rgb_finite(s->layer[i]);
    if (!finite) {
        pixel->dropped++;
        return;
    }
    pixel->samples++;
    pixel->beauty = rgb_add(pixel->beauty, s->beauty);
    for (int i = 0; i < SHADE_LAYERS; i++) pixel->layer[i] = rgb_add(pixel->layer[i], s->layer[i]);
    pixel->depth += s->depth;
    pixel->density += s->density;
}

static void render_tiles(void *ctx, size_t begin, size_t end, int worker) {
    struct pass *pass = ctx;
    struct render_image *image = pass->r->image;
    for (size_t tile = begin; tile < end; tile++) {
        int x0 = (int)(tile % (size_t)pass->columns) * TILE;
        int y0 = (int)(tile / (size_t)pass->columns) * TILE;
        for (int y = y0; y < y0 + TILE && y < image->height; y++)
            for (int x = x0; x < x0 + TILE && x < image->width; x++) {
                struct pixel *pixel = &image->pixel[(size_t)y * (size_t)image->width + (size_t)x];
                for (uint32_t i = pass->begin; i < pass->end; i++) {
                    struct shade_sample sample;
                    shade_pixel(&pass->r->shade, worker, x, y, i, &sample, &pass->counts[worker]);
                    add_sample(pixel, &sample);
                }
            }
    }
}

// How many samples the next pass takes; 0: the image is done. With a time limit, passes are as long
// as the last one shows to fit.
static uint32_t pass_samples(const struct render *r, double per_sample) {
    uint32_t done = r->image->done, left = (uint32_t)r->options.spp - done;
    uint32_t want = left < PASS_SAMPLES ? left : PASS_SAMPLES;
    if (!(r->options.time > 0.0)) return want;
    if (done == 0) return left ? 1 : 0;
    double fit = (render_time_left(r) - WRITE_SECONDS) / per_sample;
    if (fit < 1.0) return 0;
    return fit < want ? (uint32_t)fit : want;
}

static void note_counts(struct render *r, const struct shade_counts *counts, int workers) {
    struct shade_counts sum = {0};
    for (int i = 0; i < workers; i++) {
        sum.samples += counts[i].samples;
        sum.points += counts[i].points;
        sum.interpolated += counts[i].interpolated;
        sum.records_used += counts[i].records_used;
        sum.gathered += counts[i].gathered;
    }
    stats_set(&r->stats, "image.samples", (double)sum.samples);
    stats_set(&r->stats, "image.points", (double)sum.points);
    stats_set(&r->stats, "image.interpolated", (double)sum.interpolated);
    stats_set(&r->stats, "image.gathered", (double)sum.gathered);
    stats_set(&r->stats, "image.records_per_interpolation",
              sum.interpolated ? (double)sum.records_used / (double)sum.interpolated : 0.0);
    stats_set(&r->stats, "image.spp", (double)r->image->done);
}

satin_status render_image_fill(struct render *r) {
    struct render_image *image = r->image;
    const int workers = parallel_threads(r->pool);
    struct pass pass = {.r = r, .columns = (image->width + TILE - 1) / TILE};
    pass.counts = array_new((size_t)workers, sizeof *pass.counts);
    if (!pass.counts) return SATIN_ERROR_MEMORY;
    size_t tiles = (size_t)pass.columns * (size_t)((image->height + TILE - 1) / TILE);
    double spp = (double)r->options.spp, per_sample = 0.0;
    render_stage(r, "image", "samples", spp * (double)image->width * (double)image->height);
    satin_status status = SATIN_OK;
    uint32_t samples;
    while (status == SATIN_OK && (samples = pass_samples(r, per_sample)) > 0) {
        double start = stats_wall();
        pass.begin = image->done;
        pass.end = image->done + samples;
        render_stage_part(r, image->done / spp, samples / spp);
        if (!parallel_for(r->pool, tiles, 1, render_tiles, &pass)) {
            if (r->cancelled) status = SATIN_CANCELLED;
            break;
        }
        image->done = pass.end;
        per_sample = (stats_wall() - start) / samples;
    }
    r->stage_items = image->done * (double)image->width * (double)image->height;
    note_counts(r, pass.counts, workers);
    free(pass.counts);
    return status;
}

static const char *const channel_names[] = {"R",
                                            "G",
                                            "B",
                                            "direct.R",
                                            "direct.G",
                                            "direct.B",
                                            "caustic.R",
                                            "caustic.G",
                                            "caustic.B",
                                            "indirect_diffuse.R",
                                            "indirect_diffuse.G",
                                            "indirect_diffuse.B",
                                            "indirect_glossy.R",
                                            "indirect_glossy.G",
                                            "indirect_glossy.B",
                                            "emission.R",
                                            "emission.G",
                                            "emission.B",
                                            "albedo.R",
                                            "albedo.G",
                                            "albedo.B",
                                            "normal.X",
                                            "normal.Y",
                                            "normal.Z",
                                            "depth.Z",
                                            "density.Y"};

static void put_rgb(struct satin_film *film, int channel, size_t at, rgb value, float scale) {
    film->channel[channel][at] = value.r * scale;
    film->channel[channel + 1][at] = value.g * scale;
    film->channel[channel + 2][at] = value.b * scale;
}

struct satin_film *render_image_film(struct render *r, bool *any) {
    const struct render_image *image = r->image;
    const int channels = (int)(sizeof channel_names / sizeof *channel_names);
    struct satin_film *film = film_new(image->width, image->height, channel_names, channels);
    if (!film) return NULL;
    uint64_t samples = 0, dropped = 0;
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++) {
        const struct pixel *pixel = &image->pixel[i];
        samples += pixel->samples;
        dropped += pixel->dropped;
        float scale = pixel->samples ? 1.0f / (float)pixel->samples : 0.0f;
        put_rgb(film, 0, i, pixel->beauty, scale);
        for (int k = 0; k < SHADE_LAYERS; k++) put_rgb(film, 3 + 3 * k, i, pixel->layer[k], scale);
        film->channel[channels - 2][i] = pixel->depth * scale;
        film->channel[channels - 1][i] = pixel->density * scale;
    }
    stats_set(&r->stats, "image.nonfinite", (double)dropped);
    if (dropped)
        log_message(r->log, SATIN_LOG_WARNING, "%llu samples were not finite and were dropped",
                    (unsigned long long)dropped);
    *any = samples > 0;
    return film;
}
