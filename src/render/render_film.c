// SPDX-License-Identifier: Apache-2.0
// The film of an image: the means of the pixels' samples in each channel. A pixel that had no
// sample when the render was cancelled gets the value of a neighbour.
#include <stdatomic.h>

#include "base/array.h"
#include "render/render_image.h"

static void put(const struct channel_planes *planes, int channel, size_t at, float value) {
    if (planes->of[channel]) planes->of[channel][at] = value;
}

static void put_rgb(const struct channel_planes *planes, int channel, size_t at, rgb value,
                    float scale) {
    put(planes, channel, at, value.r * scale);
    put(planes, channel + 1, at, value.g * scale);
    put(planes, channel + 2, at, value.b * scale);
}

const struct image_pixel *render_image_source(const struct render_image *image, int x, int y) {
    for (int stride = 1; stride <= image->coarsest; stride *= 2) {
        size_t row = (size_t)(y - y % stride), column = (size_t)(x - x % stride);
        const struct image_pixel *pixel = &image->pixel[row * (size_t)image->width + column];
        if (pixel->samples || pixel->dropped) return pixel;
    }
    return NULL;
}

float render_image_scale(const struct image_pixel *pixel) {
    return pixel->samples ? 1.0f / pixel->weight : 0.0f;
}

// The fraction of a pixel that samples of this weight cover, whose sum may be negative or more than
// that of all under a filter with negative lobes.
static float fraction_covered(const struct image_pixel *pixel, float weight) {
    return pixel->weight != 0.0f ? fminf(fmaxf(weight / pixel->weight, 0.0f), 1.0f) : 0.0f;
}

// The mean of what is for emission alone, as soon as it is there.
static rgb mean_emission(const struct image_pixel *pixel) {
    if (pixel->emission.weight > 0.0f) return render_emission_mean(&pixel->emission);
    return rgb_scale(pixel->layer[SHADE_EMISSION], render_image_scale(pixel));
}

static void put_pixel(const struct channel_planes *planes, size_t at,
                      const struct image_pixel *pixel, const struct render_image *image) {
    const float scale = render_image_scale(pixel);
    const struct image_pixel *own = &image->pixel[at];  // may have emission without samples
    const rgb *seen = &pixel->layer[SHADE_EMISSION];
    const rgb emission = mean_emission(own->emission.weight > 0.0f ? own : pixel);
    const rgb beauty = rgb_add(rgb_scale(rgb_sub(pixel->beauty, *seen), scale), emission);
    rgb shown = beauty;
    if (image->denoised && render_is_filled(image, at, pixel))
        shown = rgb_add(emission, image->noisy.denoised[at]);
    else if (image->denoised)
        shown = rgb_add(beauty, rgb_sub(image->noisy.denoised[at], image->noisy.light[at]));
    put_rgb(planes, 0, at, shown, 1.0f);
    put_rgb(planes, CHANNEL_NOISY, at, beauty, 1.0f);
    if (image->uncached)
        put_rgb(planes, CHANNEL_UNCACHED, at, image->uncached[pixel - image->pixel].light, scale);
    for (int k = 0; k < SHADE_LAYERS; k++)
        put_rgb(planes, CHANNEL_LAYERS + 3 * k, at, pixel->layer[k], scale);
    put_rgb(planes, CHANNEL_LAYERS + 3 * SHADE_EMISSION, at, emission, 1.0f);
    put(planes, CHANNEL_DEPTH, at, pixel->depth * scale);
    put(planes, CHANNEL_ALPHA, at, fraction_covered(pixel, pixel->alpha));
    if (pixel->samples)
        put(planes, CHANNEL_DENSITY, at, (float)pixel->used.count / (float)pixel->samples);
}

// Sets the channels that describe the pixel's records, as means by weight.
static void put_maps(const struct channel_planes *planes, size_t at,
                     const struct image_pixel *pixel) {
    const struct cache_used *used = &pixel->used;
    const float scale = pixel->samples ? 1.0f / (float)pixel->samples : 0.0f;
    const float mean = used->weight > 0.0f ? 1.0f / used->weight : 0.0f;
    put(planes, CHANNEL_MAPS, at, pixel->record * scale);
    put(planes, CHANNEL_MAPS + 1, at, used->a * mean);
    put(planes, CHANNEL_MAPS + 2, at, used->weight * scale);
    put(planes, CHANNEL_MAPS + 3, at, used->rays * mean);
}

// Sets the variance of the pixel's mean, by the differences of its complete blocks.
static void put_variance(const struct render_image *image, const struct channel_planes *planes,
                         size_t at, const struct image_pixel *pixel) {
    const struct image_blocks *blocks = &image->blocks[pixel - image->pixel];
    const double m = (double)image->block, n = (double)(pixel->samples / image->block);
    if (n < 2.0) return;
    const rgb sums = blocks->sums, squares = blocks->squares;
    const double sum[3] = {(double)sums.r, (double)sums.g, (double)sums.b};
    const double square[3] = {(double)squares.r, (double)squares.g, (double)squares.b};
    for (int c = 0; c < 3; c++) {
        const double variance = fmax(square[c] - sum[c] * sum[c] / n, 0.0) / (n - 1.0);
        // The mean is that of all samples, of which some may be in no complete block.
        put(planes, CHANNEL_VARIANCE + c, at, (float)(variance / (m * (double)pixel->samples)));
    }
}

static void put_cryptomattes(const struct render_image *image, const struct channel_planes *planes,
                             size_t at, const struct image_pixel *pixel) {
    const float scale =
        pixel->weight != 0.0f ? 1.0f / pixel->weight : 0.0f;  // see fraction_covered
    for (int k = 0; k < CRYPTOMATTES; k++) {
        float value[CRYPTOMATTE_CHANNELS];
        const int last = CHANNEL_CRYPTOMATTE + (k + 1) * CRYPTOMATTE_CHANNELS - 1;
        if (!image->cryptomatte.pixel[k] || !planes->of[last]) continue;
        render_cryptomatte_ranks(&image->cryptomatte.pixel[k][pixel - image->pixel], scale, value);
        for (int i = 0; i < CRYPTOMATTE_CHANNELS; i++)
            put(planes, CHANNEL_CRYPTOMATTE + k * CRYPTOMATTE_CHANNELS + i, at, value[i]);
    }
}

// Sets the channels of the scene's AOVs.
static void put_aovs(const struct render_image *image, const struct channel_planes *planes,
                     size_t at, const struct image_pixel *pixel) {
    const struct scene_aovs *aovs = image->aovs;
    const float scale = render_image_scale(pixel);
    const float *sum = image->aov + (size_t)(pixel - image->pixel) * image->sums;
    for (int i = 0; i < aovs->count; i++) {
        const struct scene_aov *channel = &aovs->channel[i];
        if (!planes->aov[i]) continue;
        planes->aov[i][at] = sum[channel->value + (channel->squared ? aovs->values : 0)] * scale;
    }
}

// The least number of rows that are converted at a time.
enum { FILM_BAND = 64 };

void render_film_put(const struct render_image *image, const struct channel_planes *planes,
                     size_t at, const struct image_pixel *source) {
    put(planes, CHANNEL_SAMPLES, at, (float)image->pixel[at].samples);
    if (!source) return;
    put_pixel(planes, at, source, image);
    put_maps(planes, at, source);
    if (image->blocks) put_variance(image, planes, at, source);
    put_cryptomattes(image, planes, at, source);
    if (image->aov) put_aovs(image, planes, at, source);
}

struct filming {
    const struct render_image *image;
    int first;  // row of the band
    struct channel_planes planes;
    atomic_uint_fast64_t samples, dropped, filled;
};

static void add_to_channel(const struct channel_planes *planes, int channel, size_t at,
                           rgb change) {
    float *const *plane = &planes->of[channel];
    if (plane[0]) plane[0][at] += change.r;
    if (plane[1]) plane[1][at] += change.g;
    if (plane[2]) plane[2][at] += change.b;
}

static void add_irradiance_change(const struct filming *f, size_t at,
                                  const struct image_pixel *source) {
    const rgb change = f->image->irradiance[source - f->image->pixel];
    add_to_channel(&f->planes, 0, at, change);
    add_to_channel(&f->planes, CHANNEL_LAYERS + 3 * SHADE_INDIRECT_DIFFUSE, at, change);
}

static void add_noise_change(const struct filming *f, size_t at, const struct image_pixel *source) {
    const struct image_change *change = &f->image->change[source - f->image->pixel];
    static const enum shade_layer layers[NOISY_LAYERS] = {SHADE_DIRECT, SHADE_INDIRECT_GLOSSY};
    for (int k = 0; k < NOISY_LAYERS; k++) {
        add_to_channel(&f->planes, 0, at, change->layer[k]);
        add_to_channel(&f->planes, CHANNEL_LAYERS + 3 * (int)layers[k], at, change->layer[k]);
    }
}

// Whether the sums of samples have left the range of float, which are written as 0.
static bool has_overflowed(const struct channel_planes *planes, size_t at) {
    for (int c = 0; c < 3; c++) {
        const float *beauty = planes->of[c], *variance = planes->of[CHANNEL_VARIANCE + c];
        if ((beauty && !isfinite(beauty[at])) || (variance && !isfinite(variance[at]))) return true;
    }
    return false;
}

static void set_film_rows(void *ctx, size_t begin, size_t end, int worker) {
    struct filming *f = ctx;
    const struct render_image *image = f->image;
    const size_t width = (size_t)image->width;
    uint64_t samples = 0, dropped = 0, filled = 0;
    (void)worker;
    begin += (size_t)f->first;
    end += (size_t)f->first;
    for (size_t at = begin * width; at < end * width; at++) {
        const struct image_pixel *pixel = &image->pixel[at],
                                 *source = render_image_source(image, (int)(at % width),
                                                               (int)(at / width));
        samples += pixel->samples;
        dropped += pixel->dropped;
        filled += source != pixel;
        render_film_put(image, &f->planes, at, source);
        if (source && image->irradiance) add_irradiance_change(f, at, source);
        if (source && image->change) add_noise_change(f, at, source);
        dropped += has_overflowed(&f->planes, at);
    }
    atomic_fetch_add(&f->samples, samples);
    atomic_fetch_add(&f->dropped, dropped);
    atomic_fetch_add(&f->filled, filled);
}

void render_image_film(struct render *r, bool *any) {
    const struct render_image *image = r->image;
    struct filming f = {.image = image};
    atomic_init(&f.samples, 0);
    atomic_init(&f.dropped, 0);
    atomic_init(&f.filled, 0);
    f.planes = render_film_planes(image, image->film);
    parallel_begin_part(r->pool, "film");
    // The film grows by as much as the sums of the pixels shrink, so that both are never in memory
    // at the same time. A row reads pixels of its own band alone (render_image_source).
    render_adaptive_destroy(&r->image->adapt);
    const int band = image->coarsest > FILM_BAND ? image->coarsest : FILM_BAND;
    for (; f.first < image->height; f.first += band) {
        const int rows = image->height - f.first < band ? image->height - f.first : band;
        const size_t begin = (size_t)f.first * (size_t)image->width,
                     count = (size_t)rows * (size_t)image->width;
        // A cancelled render has a film too.
        parallel_for_all(r->pool, (size_t)rows, 4, set_film_rows, &f);
        array_drop(image->pixel + begin, count * sizeof *image->pixel);
        for (int k = 0; k < CRYPTOMATTES; k++)
            if (image->cryptomatte.pixel[k])
                array_drop(image->cryptomatte.pixel[k] + begin,
                           count * sizeof *image->cryptomatte.pixel[k]);
        if (image->aov)
            array_drop(image->aov + begin * image->sums, count * image->sums * sizeof *image->aov);
    }
    const uint64_t samples = f.samples, dropped = f.dropped, filled = f.filled;
    stats_set(&r->stats, "image.nonfinite", (double)dropped);
    stats_set(&r->stats, "image.filled", (double)filled);
    if (dropped)
        log_message(r->log, SATIN_LOG_WARNING, "%llu samples were not finite and were dropped",
                    (unsigned long long)dropped);
    if (samples && filled && !render_cancelled(r))
        log_message(r->log, SATIN_LOG_WARNING,
                    "the time was too short: %.0f %% of the pixels show a neighbour's sample",
                    100.0 * (double)filled / ((double)image->width * (double)image->height));
    *any = samples > 0;
}
