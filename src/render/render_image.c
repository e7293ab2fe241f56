// SPDX-License-Identifier: Apache-2.0
// The image pass: samples are summed per pixel, tile by tile. The samples of a pixel are added in
// the order of their indices, by one worker, so sums do not depend on threads. Some of the samples
// are distributed equally, the others to noisy pixels (render_adaptive_sampling.c). The first
// samples are taken coarse to fine, so that an image that is stopped early can be filled from them
// (render_film.c).
#include "render/render_image.h"

#include <math.h>
#include <stdlib.h>

#include "base/array.h"

// The coarse pass that shows the speed of samples, by its stride: one of a sixteenth of the pixels
// at most. The first ones are slower, as nothing is in the caches of the processor.
enum { LIGHTS_STRIDE = 4 };

// While the film is made, it grows by what the sums of the pixels shrink.
double render_image_bytes(const struct satin_scene *scene, const satin_options *options,
                          const satin_callbacks *callbacks) {
    const struct scene_aovs *aovs = &scene->hints.aovs;
    const double pixels = (double)scene->film.crop_width * (double)scene->film.crop_height;
    double bytes = sizeof(struct image_pixel) + sizeof(struct adaptive_pixel) + 6 * sizeof(float);
    bytes += (double)aovs->values * (aovs->moment ? 2.0 : 1.0) * sizeof(float);
    for (int k = 0; k < CRYPTOMATTES; k++)
        if ((int)options->cryptomatte >> k & 1) bytes += sizeof(struct cryptomatte_pixel);
    if (options->integrator == SATIN_PATH && !options->denoise)
        bytes += sizeof(struct image_blocks);
    if (render_irradiance_rays(options) > 0.0f)
        bytes += sizeof(struct image_gathered) + sizeof(rgb);
    if (render_noise_filter_on(options))
        bytes += sizeof(struct image_noisy) + sizeof(struct image_change);
    if (options->denoise)
        bytes += sizeof(struct image_uncached) + 4 * sizeof(rgb) + sizeof(struct image_denoised);
    if (!gather_traces_paths(options)) bytes += RENDER_RIMS_BYTES;
    if (render_edges_on(options)) bytes += RENDER_EDGES_BYTES;
    if (callbacks->snapshot) bytes += 1.0 + sizeof(float) * render_film_channels(scene, options);
    return bytes * pixels;
}

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
    // Pages of pixels that have records are never written, and take no memory.
    const bool filters = render_irradiance_rays(options) > 0.0f;
    if (filters) image->gathered = calloc(pixels, sizeof *image->gathered);
    image->block = 1;
    while (2 * IMAGE_BLOCKS * image->block <= (uint32_t)options->spp) image->block *= 2;
    bool ok = (image->blocks || !variance) && (image->gathered || !filters) && image->pixel &&
              image->film && (image->aov || !aovs->values);
    if (ok) ok = render_cryptomatte_make(&image->cryptomatte, scene, options);
    if (ok && options->denoise) ok = render_denoise_memory(image);
    if (ok && render_noise_filter_on(options)) ok = render_noise_memory(image);
    if (ok && render_adaptive_make(&image->adapt, width, height, options->light_samples,
                                   render_budget_first_gathers(options)))
        return image;
    render_image_free(image);
    return NULL;
}

satin_status render_image_renew(struct render *r) {
    const struct scene_film *film = &r->scene.film;
    render_image_free(r->image);
    r->image = render_image_new(&r->scene, &r->options);
    if (r->image) return SATIN_OK;
    return log_fail(r->log, SATIN_ERROR_MEMORY, "not enough memory for an image of %d x %d pixels",
                    film->crop_width, film->crop_height);
}

void render_image_free(struct render_image *image) {
    if (!image) return;
    render_adaptive_destroy(&image->adapt);
    satin_film_free(image->film);
    render_cryptomatte_destroy(&image->cryptomatte);
    free(image->tile_user);
    free(image->planes);
    free(image->explained);
    free(image->uncached);
    free(image->aov);
    free(image->gathered);
    free(image->irradiance);
    free(image->noisy_light);
    free(image->change);
    free(image->blocks);
    free(image->pixel);
    free(image);
}

// Sets the targets to `samples` of all pixels, of which some have one more than others.
static void distribute_equally(struct render_image *image, uint64_t samples) {
    const uint64_t pixels = (uint64_t)image->width * (uint64_t)image->height;
    const uint32_t each = (uint32_t)(samples / pixels);
    render_adaptive_equal(&image->adapt, 1, each);
    if (samples % pixels)
        render_adaptive_some(&image->adapt, (double)(samples % pixels) / (double)pixels, each + 1);
}

// Sets the targets of the next pass, which has *samples samples. False: the image is done.
static bool next_pass(struct render *r, uint64_t *samples) {
    struct render_image *image = r->image;
    parallel_begin_part(r->pool, "plan");
    const uint64_t pixels = (uint64_t)image->width * (uint64_t)image->height;
    // Again, as the samples so far show how long the filter of irradiance and edges will take.
    if (image->taken >= pixels) image->noise_fits = true;
    render_edges_plan(r);
    render_limit_image(r);
    *samples = render_budget_pass(r, image->taken, image->sample_seconds);
    if (*samples == 0) return false;
    if (image->taken < render_budget_equal_samples(&r->options) * pixels)
        distribute_equally(image, image->taken + *samples);
    else
        render_adaptive_distribute(&image->adapt, *samples);
    return true;
}

static void note_counts(struct render *r) {
    const struct shade_counts sum = r->image->counts;
    stats_set(&r->stats, "image.samples", (double)sum.samples);
    stats_set(&r->stats, "image.points", (double)sum.points);
    stats_set(&r->stats, "image.interpolated", (double)sum.interpolated);
    stats_set(&r->stats, "image.gathered", (double)sum.gathered);
    stats_set(&r->stats, "image.rays", (double)sum.rays);
    stats_set(&r->stats, "image.light_samples", render_adaptive_light_samples(&r->image->adapt));
    stats_set(&r->stats, "image.records_per_interpolation",
              sum.interpolated ? (double)sum.records_used / (double)sum.interpolated : 0.0);
    stats_set(&r->stats, "image.spp",
              (double)sum.samples / ((double)r->image->width * (double)r->image->height));
}

// To be called after a pass: sets how many samples and light samples each pixel gets.
static void plan_samples(struct render *r) {
    parallel_begin_part(r->pool, "plan");
    render_adaptive_compare(&r->image->adapt);
    const satin_options *o = &r->options;
    if (o->integrator != SATIN_TWO_PASS || !o->adaptive_sampling) return;
    const bool gathers = o->time > 0.0;
    render_adaptive_counts(&r->image->adapt, render_budget_sample_cost(&r->image->counts, gathers),
                           gathers);
}

// The number of pixels that a coarse pass with this stride samples, with those before.
static uint64_t coarse_pixels(const struct render_image *image, int stride) {
    return (uint64_t)((image->width + stride - 1) / stride) *
           (uint64_t)((image->height + stride - 1) / stride);
}

// Where little time is left, by that of the coarse pass with this stride, the first samples have
// fewer light samples, and where much is left, more gather rays. They end early enough for the
// filter of irradiance, as that pass shows how long it will take.
static void plan_first_samples(struct render *r, int stride, double seconds) {
    struct render_image *image = r->image;
    const uint64_t samples = coarse_pixels(image, stride) - coarse_pixels(image, 2 * stride);
    const double each = fmax(seconds / (double)samples, 1e-9);
    image->unsampled = render_budget_unsampled(r, each);
    image->noise_fits = render_budget_fits_noise(image->unsampled);
    if (!r->second_pass.lights_chosen)
        render_adaptive_direct(&image->adapt, render_budget_lights(r, each));
    render_adaptive_gathers(&image->adapt, render_budget_gathers(r, each));
    render_limit_image(r);
}

// Takes the first sample of a few pixels, whatever the time limit, unless a coarse image of direct
// light can follow; and if the time is short, of all pixels, coarse to fine. False if that was
// stopped early.
static bool take_first_samples(struct image_pass *pass) {
    struct render *r = pass->r;
    const bool short_of_time = r->options.time > 0.0 || render_steps(r)->coarse;
    double limit = render_limit_lift(r);
    bool whole = true;
    if (r->progress.course == COURSE_COARSE) render_limit_restore(r, limit);
    for (int stride = r->image->coarsest; stride > 0 && whole; stride /= 2) {
        const double start = stats_wall();
        parallel_begin_part(r->pool, "plan");
        render_adaptive_equal(&r->image->adapt, stride, 1);
        whole = render_pass_run(pass);
        render_limit_restore(r, limit);
        const double seconds = render_agreed(r, stats_wall() - start);
        if (whole && r->options.time > 0.0 && stride == r->image->coarsest / LIGHTS_STRIDE) {
            plan_first_samples(r, stride, seconds);
            limit = r->progress.deadline;
        }
        if (!short_of_time) break;
    }
    r->image->unsampled = 0.0;
    if (short_of_time && whole)
        r->image->taken = (uint64_t)r->image->width * (uint64_t)r->image->height;
    return whole;
}

satin_status render_shading(struct render *r, const struct cache *cache) {
    struct render_second_pass *pass = &r->second_pass;
    const struct cache_reader records =
        cache_reader_make(cache, &pass->tables, pass->gather.options);
    return shade_init(&pass->shade, &pass->gather, records,
                      render_budget_missing(&r->options, render_core_seconds(r)), r->pool);
}

// Takes the photons of the first samples, and these samples, and plans the next pass from them.
static satin_status begin_samples(struct image_pass *pass) {
    struct render *r = pass->r;
    struct render_image *image = r->image;
    const double start = stats_wall(), limit = render_limit_lift(r);
    const satin_status status = render_pass_photons(r);
    render_limit_restore(r, limit);
    if (status != SATIN_OK) return status;
    if (!take_first_samples(pass)) return SATIN_CANCELLED;
    if (!image->taken) return SATIN_OK;
    image->sample_seconds = render_agreed(r, stats_wall() - start) / (double)image->taken;
    plan_samples(r);
    return SATIN_OK;
}

// Ends the pass that has begun, and plans the next one.
static void end_pass(struct render *r) {
    struct render_image *image = r->image;
    image->taken += image->begun;
    image->begun = 0;
    atomic_store(&image->unwritten, true);
    render_checkpoint_end_pass(r);
    plan_samples(r);
}

// The first rims are not ended by a time limit, as they would be sampled after it.
static satin_status take_rims(struct render *r) {
    const struct render_image *image = r->image;
    const satin_options *o = &r->options;
    const uint64_t equal =
        (uint64_t)render_budget_equal_samples(o) * (uint64_t)image->width * (uint64_t)image->height;
    if (image->taken < equal || image->rims_taken >= image->taken || !render_has_rims(r))
        return SATIN_OK;
    bool whole = true;
    const bool lifts = render_budget_late_rims(r) > 0.0 && !render_has_checkpoint(r);
    const double limit = lifts ? render_limit_lift(r) : 0.0;
    const satin_status status = render_rims(r, false, &whole);
    if (lifts) render_limit_restore(r, limit);
    return status == SATIN_OK && !whole ? SATIN_CANCELLED : status;
}

// Takes pass after pass. A restored image goes on in the pass that had begun, or after it.
static satin_status take_passes(struct image_pass *pass, bool restored) {
    struct render *r = pass->r;
    struct render_image *image = r->image;
    const double all = (double)r->options.spp * (double)image->width * (double)image->height;
    satin_status status = render_features(r);
    if (status == SATIN_OK && restored && !image->begun) status = take_rims(r);
    bool begun = restored && image->begun;
    if (restored) render_stage_skip(r, (double)image->taken / all);
    while (status == SATIN_OK && (begun || next_pass(r, &image->begun))) {
        const double start = stats_wall();
        const uint64_t samples = image->begun;
        render_stage_range(r, (double)image->taken / all, (double)samples / all);
        if (begun || image->taken) status = render_pass_photons(r);
        begun = false;
        if (status == SATIN_OK && !render_pass_run(pass)) status = SATIN_CANCELLED;
        if (status != SATIN_OK) break;
        end_pass(r);
        image->sample_seconds = render_agreed(r, stats_wall() - start) / (double)samples;
        status = render_features(r);
        if (status == SATIN_OK) status = take_rims(r);
        if (status == SATIN_OK) render_checkpoint_between(r);
    }
    return status;
}

// Where a time limit is over before rims are looked for, they are sampled after it, by few rays: at
// .7 CPU seconds relMSE of cornell-metal is .024 instead of .081 (four seeds, 200x200).
static satin_status take_late_rims(struct render *r) {
    if (!(r->options.time > 0.0) || render_cancelled(r) || render_checkpoint_due(r) ||
        !(render_budget_late_rims(r) > 0.0))
        return SATIN_OK;
    bool whole;
    const double limit = render_limit_lift(r);
    const satin_status status = render_rims(r, true, &whole);
    render_limit_restore(r, limit);
    return status == SATIN_OK && !whole ? SATIN_CANCELLED : status;
}

// Samples the image, from the beginning or from where the checkpoint ends.
static satin_status sample_passes(struct image_pass *pass) {
    struct render *r = pass->r;
    bool restored;
    satin_status status = render_checkpoint_begin_image(r, &restored);
    if (status == SATIN_OK && restored) render_skip_photons(r);
    if (status == SATIN_OK && !restored) status = begin_samples(pass);
    if (render_steps(r)->coarse) return status;
    const bool begun = status == SATIN_OK;
    if (begun) status = take_passes(pass, restored);
    if (status == SATIN_OK || status == SATIN_CANCELLED) {
        const satin_status rims = take_late_rims(r);
        if (rims != SATIN_OK) status = rims;
    }
    if (status != SATIN_OK && status != SATIN_CANCELLED) return status;
    if (begun) render_checkpoint_write(r);
    const satin_status late = render_features_late(r);
    return late == SATIN_OK ? status : late;
}

satin_status render_image_fill(struct render *r) {
    struct render_image *image = r->image;
    struct image_pass pass;
    image->adapt.pool = r->pool;
    if (!render_snapshot_memory(r, image) || !render_pass_make(&pass, r)) return SATIN_ERROR_MEMORY;
    render_stage_begin(r, STAGE_IMAGE,
                       (double)r->options.spp * (double)image->width * (double)image->height);
    render_stage_range(r, 0.0, 1.0 / r->options.spp);
    const satin_status status = sample_passes(&pass);
    r->progress.items = (double)(image->taken + image->begun);
    note_counts(r);
    render_pass_destroy(&pass);
    // A time limit ends the samples without cancelling the render.
    return status == SATIN_CANCELLED && !render_cancelled(r) ? SATIN_OK : status;
}
