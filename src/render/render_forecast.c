// SPDX-License-Identifier: Apache-2.0
// How long records and image will take, before there is anything to measure that by: a small render
// of the same scene, of few pixels, photons and rays, has the same surfaces, materials and lights.
// Its image is not used.
#include "render/render_state.h"

// The pixels of the small render. With 400 its image takes up to 6 times too long for its samples,
// as a tile shows many records; with 1600 at most twice too long.
static const double FEW_PIXELS = 1600.0;

// A render of fewer samples ends so soon that a forecast would be a large part of it.
static const double SAMPLES_LEAST = 1e5;

// What else it has.
enum { FEW_SAMPLES = 4, FEW_PHOTONS = 3000, FEW_IRRADIANCE_RAYS = 48, FEW_RADIANCE_RAYS = 96 };

// The seconds of the records over those of the small render, and of the image, by what they should
// grow with: medians over the data scenes and the rooms by others at all qualities
// (docs/experiments/time-left.md). Records grow with a power of the pixels.
static const double RECORDS_FACTOR = 0.3, RECORDS_POWER = 0.4, IMAGE_FACTOR = 0.8;

static double pixel_count(const struct render *r) {
    return (double)r->options.width * (double)r->options.height;
}

bool render_forecasts(const struct render *r) {
    const satin_callbacks *c = &r->callbacks;
    if (!c->forecast || !c->progress || c->animation || c->resume) return false;
    if (pixel_count(r) * (double)r->options.spp < SAMPLES_LEAST) return false;
    const bool recursive = r->options.first_pass == SATIN_FIRST_RECURSIVE;
    return r->progress.course == COURSE_TWO_PASS && !recursive && !(r->options.time > 0.0);
}

// The caller's progress function may cancel the render during the small one.
static bool report_forecast(void *user, const satin_progress *small) {
    struct render *r = user;
    (void)small;
    render_progress_report(r, 0.0);
    return render_cancelled(r);
}

static int at_most(int value, int most) { return value < most ? value : most; }

struct render *render_forecast_new(struct render *r, satin_options *small) {
    const satin_callbacks callbacks = {.progress = report_forecast, .progress_user = r};
    const double scale = fmin(sqrt(FEW_PIXELS / pixel_count(r)), 1.0);
    render_stage_begin(r, STAGE_FORECAST, 0.0);
    *small = r->options;
    // The window of the film is scaled with it.
    small->width = (int)ceil(scale * r->scene.film.width);
    small->height = (int)ceil(scale * r->scene.film.height);
    small->crop_x = small->crop_y = small->crop_width = small->crop_height = 0;
    small->spp = at_most(r->options.spp, FEW_SAMPLES);
    small->photons = FEW_PHOTONS;
    small->caustic_photons = 0;
    small->irradiance_rays = at_most(r->options.irradiance_rays, FEW_IRRADIANCE_RAYS);
    small->radiance_rays = at_most(r->options.radiance_rays, FEW_RADIANCE_RAYS);
    // In fewer pixels, these are the same distances.
    small->irradiance_min_pixels *= (float)scale;
    small->irradiance_max_pixels = fmaxf(small->irradiance_max_pixels * (float)scale, 1.0f);
    small->radiance_min_pixels *= (float)scale;
    small->radiance_max_pixels = fmaxf(small->radiance_max_pixels * (float)scale, 1.0f);
    small->guide_visibility = false;
    small->denoise = false;
    small->memory = 0;
    return render_new(&callbacks);
}

// The gather rays of the records that a render has made, if each has the rays of the options.
static double record_rays(const struct render *made, const satin_options *options) {
    return stats_get(&made->stats, "records.irradiance") * options->irradiance_rays +
           stats_get(&made->stats, "records.radiance") * options->radiance_rays;
}

void render_forecast_take(struct render *r, const struct render *small) {
    const double ranks = r->callbacks.ranks ? r->callbacks.ranks->count : 1.0;
    const double pixels = pixel_count(r) / pixel_count(small);
    const double rays =
        record_rays(small, &r->options) / fmax(record_rays(small, &small->options), 1.0);
    const double samples = pixels * r->options.spp / small->options.spp;
    struct render_forecast *forecast = &r->progress.forecast;
    forecast->records = RECORDS_FACTOR * rays * pow(pixels, RECORDS_POWER) *
                        stats_get(&small->stats, "time.records_s") / ranks;
    forecast->image = IMAGE_FACTOR * samples * stats_get(&small->stats, "time.image_s") / ranks;
    if (render_cache_whole(r)) forecast->records = 0.0;
    stats_set(&r->stats, "forecast.records_s", forecast->records);
    stats_set(&r->stats, "forecast.image_s", forecast->image);
}
