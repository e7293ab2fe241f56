// SPDX-License-Identifier: Apache-2.0
// The image pass: samples are summed per pixel, tile by tile. The samples of a pixel are added in
// the order of their indices, by one worker, so sums do not depend on threads. Some of the samples
// are distributed equally, the others to noisy pixels (render_adaptive_sampling.c). The first
// samples are taken coarse to fine, so that an image that is stopped early can be filled from them
// (render_film.c).
#include "render/render_image.h"

#include <stdlib.h>

#include "base/array.h"

enum { ASK_SAMPLES = 32 };  // samples after which a worker checks for cancellation

struct image_pass {
    struct render *r;
    struct shade_worker *worker;
    int columns;
};

struct render_image *render_image_new(const struct satin_scene *scene,
                                      const satin_options *options) {
    const struct scene_aovs *aovs = &scene->hints.aovs;
    const int width = scene->film.crop_width, height = scene->film.crop_height;
    const size_t pixels = (size_t)width * (size_t)height;
    struct render_image *image = calloc(1, sizeof *image);
    if (!image) return NULL;
    *image = (struct render_image){.width = width,
                                   .height = height,
                                   .aovs = aovs,
                                   .coarsest = render_budget_first_stride(width, height)};
    // From calloc, whose pages the system assigns to the threads that first use them.
    image->pixel = calloc(pixels, sizeof *image->pixel);
    image->sums = (size_t)aovs->values * (aovs->moment ? 2 : 1);
    image->aov = array_new(pixels, image->sums * sizeof *image->aov);
    image->film = render_film_new(scene, options);
    const bool variance = image->film && film_channel(image->film, "variance.R");
    if (variance) image->blocks = calloc(pixels, sizeof *image->blocks);
    image->block = 1;
    while (2 * IMAGE_BLOCKS * image->block <= (uint32_t)options->spp) image->block *= 2;
    bool ok = (image->blocks || !variance) && image->pixel && image->film &&
              (image->aov || !aovs->values);
    if (ok && options->denoise) ok = render_denoise_memory(image);
    if (ok && adaptive_make(&image->adapt, width, height, options->light_samples)) return image;
    render_image_free(image);
    return NULL;
}

void render_image_free(struct render_image *image) {
    if (!image) return;
    adaptive_destroy(&image->adapt);
    satin_film_free(image->film);
    free(image->tile_user);
    free(image->planes);
    free(image->uncached);
    free(image->aov);
    free(image->blocks);
    free(image->pixel);
    free(image);
}

// The light by which the noise of a sample is measured. Lights seen directly are limited to white,
// so that their rims do not take most samples.
static rgb shown_light(const struct shade_sample *s) {
    rgb e = s->layer[SHADE_EMISSION];
    rgb shown = rgb_make(fminf(e.r, 1.0f), fminf(e.g, 1.0f), fminf(e.b, 1.0f));
    return rgb_add(rgb_sub(s->beauty, e), shown);
}

// False if the sample was not finite and was dropped.
static bool add_sample(struct image_pixel *pixel, const struct shade_sample *s) {
    if (!shade_sample_finite(s)) {
        pixel->dropped++;
        return false;
    }
    pixel->samples++;
    pixel->weight += s->weight;
    pixel->beauty = rgb_mad(pixel->beauty, s->beauty, s->weight);
    for (int i = 0; i < SHADE_LAYERS; i++)
        pixel->layer[i] = rgb_mad(pixel->layer[i], s->layer[i], s->weight);
    pixel->depth += s->weight * s->depth;
    pixel->alpha += s->weight * s->alpha;
    pixel->record += s->record;
    pixel->used = cache_used_add(pixel->used, s->used);
    return true;
}

// To be called after add_sample.
static void add_to_block(struct render_image *image, size_t at, rgb value) {
    struct image_blocks *blocks = &image->blocks[at];
    blocks->begun = rgb_add(blocks->begun, value);
    if (image->pixel[at].samples % image->block) return;
    blocks->sums = rgb_add(blocks->sums, blocks->begun);
    blocks->squares = rgb_fma(blocks->squares, blocks->begun, blocks->begun);
    blocks->begun = rgb_grey(0.0f);
}

static void add_aovs(const struct render_image *image, size_t at, const struct shade_sample *s) {
    const int values = image->aovs->values;
    float *sum = image->aov + at * image->sums;
    for (int i = 0; i < values; i++) sum[i] += s->weight * s->aov[i];
    for (int i = 0; image->aovs->moment && i < values; i++)
        sum[values + i] += s->weight * (s->aov[i] * s->aov[i]);
}

// Takes the samples of a pixel up to its target. False if that was stopped early. *asked counts
// samples.
static bool sample_pixel(const struct image_pass *pass, int x, int y, int worker, unsigned *asked) {
    struct render_image *image = pass->r->image;
    const size_t at = (size_t)y * (size_t)image->width + (size_t)x;
    struct adaptive_pixel *adapt = &image->adapt.pixel[at];
    shade_pixel_begin(&pass->worker[worker]);
    while (adapt->count < adapt->target) {
        struct shade_sample sample;
        const struct gather_light_samples light_samples = {(int)adapt->light_samples,
                                                           adapt->light_samples_taken};
        shade_pixel(&pass->r->second_pass.shade, &pass->worker[worker], x, y, adapt->count,
                    light_samples, &sample);
        if (parallel_stopped(pass->r->pool)) return false;  // it may be incomplete
        bool finite = add_sample(&image->pixel[at], &sample);
        if (finite && image->aov) add_aovs(image, at, &sample);
        if (finite && image->blocks) add_to_block(image, at, sample.beauty);
        if (finite && image->uncached)
            image->uncached[at] = rgb_mad(image->uncached[at], sample.uncached, sample.weight);
        adaptive_add(adapt, finite ? shown_light(&sample) : rgb_grey(0.0f),
                     finite ? sample.light_variance : 0.0f);
        // A late pass takes thousands of samples of every pixel.
        if (++*asked % ASK_SAMPLES == 0 && parallel_cancelled(pass->r->pool, worker)) return false;
    }
    return true;
}

static void render_tiles(void *ctx, size_t begin, size_t end, int worker) {
    struct image_pass *pass = ctx;
    struct render_image *image = pass->r->image;
    unsigned asked = 0;
    bool whole = true;
    for (size_t tile = begin; tile < end && whole; tile++) {
        const int x0 = (int)(tile % (size_t)pass->columns) * IMAGE_TILE;
        const int y0 = (int)(tile / (size_t)pass->columns) * IMAGE_TILE;
        render_tile_begin(image, tile, worker);
        shade_tile_begin(&pass->worker[worker]);
        for (int y = y0; y < y0 + IMAGE_TILE && y < image->height && whole; y++)
            for (int x = x0; x < x0 + IMAGE_TILE && x < image->width && whole; x++)
                whole = sample_pixel(pass, x, y, worker, &asked);
        render_tile_end(image, tile);
    }
}

// Sets the targets of the next pass, which has *samples samples. False: the image is done.
static bool next_pass(struct render *r, double per_sample, uint64_t *samples) {
    struct render_image *image = r->image;
    parallel_begin_part(r->pool, "plan");
    const uint64_t pixels = (uint64_t)image->width * (uint64_t)image->height;
    *samples = render_budget_pass(r, image->taken, per_sample);
    if (*samples == 0) return false;
    if (image->taken < render_budget_equal_samples(&r->second_pass.options) * pixels)
        adaptive_equal(&image->adapt, 1, (uint32_t)((image->taken + *samples) / pixels));
    else
        adaptive_distribute(&image->adapt, *samples);
    return true;
}

static struct shade_counts sum_counts(const struct shade_worker *worker, int workers) {
    struct shade_counts sum = {0};
    for (int i = 0; i < workers; i++) {
        sum.samples += worker[i].counts.samples;
        sum.points += worker[i].counts.points;
        sum.interpolated += worker[i].counts.interpolated;
        sum.records_used += worker[i].counts.records_used;
        sum.gathered += worker[i].counts.gathered;
        sum.rays += worker[i].counts.rays;
    }
    return sum;
}

static void note_counts(struct render *r, const struct shade_worker *worker, int workers) {
    const struct shade_counts sum = sum_counts(worker, workers);
    stats_set(&r->stats, "image.samples", (double)sum.samples);
    stats_set(&r->stats, "image.points", (double)sum.points);
    stats_set(&r->stats, "image.interpolated", (double)sum.interpolated);
    stats_set(&r->stats, "image.gathered", (double)sum.gathered);
    stats_set(&r->stats, "image.rays", (double)sum.rays);
    stats_set(&r->stats, "image.light_samples", adaptive_light_samples(&r->image->adapt));
    stats_set(&r->stats, "image.records_per_interpolation",
              sum.interpolated ? (double)sum.records_used / (double)sum.interpolated : 0.0);
    stats_set(&r->stats, "image.spp",
              (double)sum.samples / ((double)r->image->width * (double)r->image->height));
}

// To be called after a pass: sets how many samples and light samples each pixel gets.
static void plan_samples(struct image_pass *pass, int workers) {
    struct render *r = pass->r;
    parallel_begin_part(r->pool, "plan");
    adaptive_compare(&r->image->adapt);
    const satin_options *o = &r->second_pass.options;
    if (o->integrator != SATIN_TWO_PASS || !o->adaptive_sampling) return;
    const struct shade_counts counts = sum_counts(pass->worker, workers);
    adaptive_lights(&r->image->adapt, render_budget_sample_cost(&counts));
}

static bool run_pass(struct image_pass *pass) {
    struct render_image *image = pass->r->image;
    parallel_begin_part(pass->r->pool, "image");
    size_t rows = (size_t)((image->height + IMAGE_TILE - 1) / IMAGE_TILE);
    image->in_pass = true;
    const bool whole =
        parallel_for(pass->r->pool, (size_t)pass->columns * rows, 1, render_tiles, pass);
    image->in_pass = false;
    return whole;
}

// Takes the first sample of a few pixels, whatever the time limit, unless a coarse image of direct
// light can follow; and if the time is short, of all pixels, coarse to fine. False if that was
// stopped early.
static bool take_first_samples(struct image_pass *pass) {
    struct render *r = pass->r;
    const bool short_of_time = r->options.time > 0.0 || render_steps(r)->coarse;
    const double limit = render_limit_lift(r);
    bool whole = true;
    if (r->progress.course == COURSE_COARSE) render_limit_restore(r, limit);
    for (int stride = r->image->coarsest; stride > 0 && whole; stride /= 2) {
        parallel_begin_part(r->pool, "plan");
        adaptive_equal(&r->image->adapt, stride, 1);
        whole = run_pass(pass);
        r->image->has_first_samples |= whole;
        render_limit_restore(r, limit);
        if (!short_of_time) break;
    }
    if (short_of_time && whole)
        r->image->taken = (uint64_t)r->image->width * (uint64_t)r->image->height;
    return whole;
}

satin_status render_shading(struct render *r, const struct cache *cache) {
    struct render_second_pass *pass = &r->second_pass;
    const bool interpolates = render_steps(r)->interpolates;
    const struct cache_reader records =
        cache_reader_make(interpolates ? cache : NULL, &pass->tables, pass->gather.options);
    return shade_init(&pass->shade, &pass->gather, records, interpolates,
                      render_budget_missing(&r->options), r->pool);
}

satin_status render_image_fill(struct render *r) {
    struct render_image *image = r->image;
    const int workers = parallel_threads(r->pool);
    struct image_pass pass = {.r = r, .columns = (image->width + IMAGE_TILE - 1) / IMAGE_TILE};
    image->adapt.pool = r->pool;
    if (!render_snapshot_memory(r, image)) return SATIN_ERROR_MEMORY;
    pass.worker = array_new((size_t)workers, sizeof *pass.worker);
    if (!pass.worker) return SATIN_ERROR_MEMORY;
    for (int i = 0; i < workers; i++) pass.worker[i].gather = r->second_pass.shade.worker[i];
    const double all = (double)r->options.spp * (double)image->width * (double)image->height;
    render_stage_begin(r, STAGE_IMAGE, all);
    render_stage_range(r, 0.0, 1.0 / r->options.spp);
    double start = stats_wall(), per_sample = 0.0;
    const double limit = render_limit_lift(r);
    satin_status status = render_pass_photons(r);
    render_limit_restore(r, limit);
    bool whole = status == SATIN_OK && take_first_samples(&pass);
    uint64_t samples;
    if (whole && image->taken) {
        per_sample = (stats_wall() - start) / (double)image->taken;
        plan_samples(&pass, workers);
    }
    const uint64_t equal = (uint64_t)render_budget_equal_samples(&r->second_pass.options) *
                           (uint64_t)image->width * (uint64_t)image->height;
    while (status == SATIN_OK && whole && !render_steps(r)->coarse &&
           next_pass(r, per_sample, &samples)) {
        start = stats_wall();
        render_stage_range(r, (double)image->taken / all, (double)samples / all);
        if (image->taken) status = render_pass_photons(r);
        whole = status == SATIN_OK && run_pass(&pass);
        if (!whole) break;
        image->taken += samples;
        per_sample = (stats_wall() - start) / (double)samples;
        plan_samples(&pass, workers);
        if (image->taken >= equal && !gather_traces_paths(&r->second_pass.options))
            status = render_rims(r, &whole);
    }
    r->progress.items = (double)image->taken;
    note_counts(r, pass.worker, workers);
    free(pass.worker);
    if (status != SATIN_OK && status != SATIN_CANCELLED) return status;
    return !whole && render_cancelled(r) ? SATIN_CANCELLED : SATIN_OK;
}
