// SPDX-License-Identifier: Apache-2.0
// The film of an image: the means of the pixels' samples in each channel. A pixel that had no
// sample when the render was cancelled gets the value of a neighbour. There are no channels of
// quantities that the integrator does not compute. A channel that the scene asks for replaces the
// channel of satin's of the same name.
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "base/array.h"
#include "base/text.h"
#include "render/render_image.h"

// The least weight of a pixel per sample; the mean is 1.
static const float WEIGHT_LEAST = 0.25f;

// The integrators that compute a channel, as bits 1 << satin_integrator.
enum {
    BY_TWO_PASS = 1 << SATIN_TWO_PASS,
    BY_PATH = 1 << SATIN_PATH,
    BY_DIRECT = 1 << SATIN_DIRECT,
    BY_PHOTONS = 1 << SATIN_PHOTONS,
    BY_SPPM = 1 << SATIN_SPPM,
    ANY = BY_TWO_PASS | BY_PATH | BY_DIRECT | BY_PHOTONS | BY_SPPM
};

static const struct {
    const char *name;
    unsigned by;
} channels[FILM_CHANNELS] = {
    {"R", ANY},
    {"G", ANY},
    {"B", ANY},
    {"direct.R", BY_TWO_PASS | BY_DIRECT},
    {"direct.G", BY_TWO_PASS | BY_DIRECT},
    {"direct.B", BY_TWO_PASS | BY_DIRECT},
    {"caustic.R", BY_TWO_PASS},
    {"caustic.G", BY_TWO_PASS},
    {"caustic.B", BY_TWO_PASS},
    {"indirect_diffuse.R", BY_TWO_PASS | BY_PHOTONS},
    {"indirect_diffuse.G", BY_TWO_PASS | BY_PHOTONS},
    {"indirect_diffuse.B", BY_TWO_PASS | BY_PHOTONS},
    {"indirect_glossy.R", BY_TWO_PASS},
    {"indirect_glossy.G", BY_TWO_PASS},
    {"indirect_glossy.B", BY_TWO_PASS},
    {"emission.R", ANY},
    {"emission.G", ANY},
    {"emission.B", ANY},
    {"albedo.R", ANY},
    {"albedo.G", ANY},
    {"albedo.B", ANY},
    {"normal.X", ANY},
    {"normal.Y", ANY},
    {"normal.Z", ANY},
    {"depth.Z", ANY},
    {"A", ANY},
    {"density.Y", BY_TWO_PASS},
    {"samples.Y", ANY},
    {"records.position", BY_TWO_PASS},
    {"records.a", BY_TWO_PASS},
    {"records.weight", BY_TWO_PASS},
    {"records.rays", BY_TWO_PASS},
    {"noisy.R", ANY},
    {"noisy.G", ANY},
    {"noisy.B", ANY},
    {"uncached.R", ANY},
    {"uncached.G", ANY},
    {"uncached.B", ANY},
    {"variance.R", BY_PATH},
    {"variance.G", BY_PATH},
    {"variance.B", BY_PATH},
    {"CryptoObject00.R", ANY},
    {"CryptoObject00.G", ANY},
    {"CryptoObject00.B", ANY},
    {"CryptoObject00.A", ANY},
    {"CryptoObject01.R", ANY},
    {"CryptoObject01.G", ANY},
    {"CryptoObject01.B", ANY},
    {"CryptoObject01.A", ANY},
    {"CryptoObject02.R", ANY},
    {"CryptoObject02.G", ANY},
    {"CryptoObject02.B", ANY},
    {"CryptoObject02.A", ANY},
    {"CryptoMaterial00.R", ANY},
    {"CryptoMaterial00.G", ANY},
    {"CryptoMaterial00.B", ANY},
    {"CryptoMaterial00.A", ANY},
    {"CryptoMaterial01.R", ANY},
    {"CryptoMaterial01.G", ANY},
    {"CryptoMaterial01.B", ANY},
    {"CryptoMaterial01.A", ANY},
    {"CryptoMaterial02.R", ANY},
    {"CryptoMaterial02.G", ANY},
    {"CryptoMaterial02.B", ANY},
    {"CryptoMaterial02.A", ANY},
};

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
    // A few samples of a filter with negative lobes may have almost no weight together.
    float least = WEIGHT_LEAST * (float)pixel->samples;
    return pixel->samples ? 1.0f / fmaxf(pixel->weight, least) : 0.0f;
}

// The fraction of a pixel that samples of this weight cover. Under a filter with negative lobes the
// weights of all samples may add up to almost nothing or less, and still an opaque pixel is opaque.
static float fraction_covered(const struct image_pixel *pixel, float weight) {
    return pixel->weight != 0.0f ? fminf(fmaxf(weight / pixel->weight, 0.0f), 1.0f) : 0.0f;
}

// The mean of the samples and, at rims, of the additional rays.
static rgb mean_emission(const struct image_pixel *pixel) {
    const rgb sum = rgb_add(pixel->layer[SHADE_EMISSION], pixel->rim);
    const float weight = pixel->weight + pixel->rim_weight;
    if (!(pixel->rim_weight > 0.0f) || !(weight > 0.0f))
        return rgb_scale(pixel->layer[SHADE_EMISSION], render_image_scale(pixel));
    return rgb_scale(sum, 1.0f / weight);
}

static void put_pixel(const struct channel_planes *planes, size_t at,
                      const struct image_pixel *pixel, const struct render_image *image) {
    const float scale = render_image_scale(pixel);
    const rgb *seen = &pixel->layer[SHADE_EMISSION], emission = mean_emission(pixel);
    const rgb beauty = rgb_add(rgb_scale(rgb_sub(pixel->beauty, *seen), scale), emission);
    rgb shown = beauty;
    if (image->denoised)
        shown = rgb_add(beauty, rgb_sub(image->noisy.denoised[at], image->noisy.light[at]));
    put_rgb(planes, 0, at, shown, 1.0f);
    put_rgb(planes, CHANNEL_NOISY, at, beauty, 1.0f);
    if (image->uncached)
        put_rgb(planes, CHANNEL_UNCACHED, at, image->uncached[pixel - image->pixel], scale);
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

static bool is_aov(const struct scene_aovs *aovs, const char *name) {
    for (int i = 0; i < aovs->count; i++)
        if (strcmp(aovs->channel[i].name, name) == 0) return true;
    return false;
}

// ---- Which channels -----------------------------------------------------------------------------

// The number of letters of a channel's layer: the name before its last point, or all of it.
static size_t layer_length(const char *channel) {
    const char *point = strrchr(channel, '.');
    return point ? (size_t)(point - channel) : strlen(channel);
}

static bool is_beauty(const char *channel) {
    return strlen(channel) == 1 && strchr("RGBA", channel[0]);
}

// Whether option layers has the channel's layer. It has the beauty always, and the mattes, which
// have an option of their own; and all if it is empty.
static bool is_wanted(const char *layers, const char *channel) {
    const size_t length = layer_length(channel);
    if (!*layers || is_beauty(channel) || film_is_cryptomatte(channel)) return true;
    for (const char *at = layers; *at;) {
        const size_t word = strcspn(at, ",");
        if (word == length && strncmp(at, channel, word) == 0) return true;
        at += word + (at[word] == ',');
    }
    return false;
}

static bool has_channel(const struct satin_scene *scene, const satin_options *options, int i) {
    if (i >= CHANNEL_MAPS && i < CHANNEL_NOISY && !options->record_maps) return false;
    if (i >= CHANNEL_NOISY && i < CHANNEL_VARIANCE && !options->denoise) return false;
    // A denoised image has another variance, and weights of both signs have none by this estimate.
    if (i >= CHANNEL_VARIANCE && i < CHANNEL_CRYPTOMATTE &&
        (options->denoise || scene_film_filter_has_lobes(&scene->film)))
        return false;
    if (i == CHANNEL_ALPHA && !scene->film.alpha) return false;
    if (i >= CHANNEL_CRYPTOMATTE &&
        !((int)options->cryptomatte & 1 << (i - CHANNEL_CRYPTOMATTE) / CRYPTOMATTE_CHANNELS))
        return false;
    return channels[i].by & 1u << options->integrator &&
           !is_aov(&scene->hints.aovs, channels[i].name);
}

// Sets the names of all channels that the integrator computes, whether or not the option layers has
// them. Returns their number.
static int all_channels(const struct satin_scene *scene, const satin_options *options,
                        const char *name[NAMES_MAX]) {
    const struct scene_aovs *aovs = &scene->hints.aovs;
    int count = 0;
    for (int i = 0; i < FILM_CHANNELS; i++)
        if (has_channel(scene, options, i)) name[count++] = channels[i].name;
    for (int i = 0; i < aovs->count; i++) name[count++] = aovs->channel[i].name;
    return count;
}

satin_status render_film_check(const struct satin_scene *scene, const satin_options *options,
                               struct log log) {
    enum { LAYER_NAME = 128 };
    const char *name[NAMES_MAX];
    char layer[NAMES_MAX][LAYER_NAME], wanted[LAYER_NAME];
    const int count = all_channels(scene, options, name);
    for (int i = 0; i < count; i++)
        snprintf(layer[i], LAYER_NAME, "%.*s", (int)layer_length(name[i]), name[i]);
    for (const char *at = options->layers; *at;) {
        const size_t word = strcspn(at, ",");
        snprintf(wanted, sizeof wanted, "%.*s", (int)word, at);
        struct text_nearest search = {.word = wanted};
        bool known = strcmp(wanted, "none") == 0;
        for (int i = 0; i < count && !known; i++) {
            if (is_beauty(name[i])) continue;
            known = strcmp(layer[i], wanted) == 0;
            text_nearest_try(&search, layer[i]);
        }
        if (!known && search.best)
            return log_fail(log, SATIN_ERROR_INPUT,
                            "option layers: the image has no layer '%s' (did you mean '%s'?)",
                            wanted, search.best);
        if (!known)
            return log_fail(log, SATIN_ERROR_INPUT, "option layers: the image has no layer '%s'",
                            wanted);
        at += word + (at[word] == ',');
    }
    return SATIN_OK;
}

// Sets the names of the channels that the film has. Returns their number.
static int wanted_channels(const struct satin_scene *scene, const satin_options *options,
                           const char *name[NAMES_MAX]) {
    const int count = all_channels(scene, options, name);
    int wanted = 0;
    for (int i = 0; i < count; i++)
        if (is_wanted(options->layers, name[i])) name[wanted++] = name[i];
    return wanted;
}

int render_film_channels(const struct satin_scene *scene, const satin_options *options) {
    const char *name[NAMES_MAX];
    return wanted_channels(scene, options, name);
}

struct satin_film *render_film_new(const struct satin_scene *scene, const satin_options *options) {
    const char *name[NAMES_MAX];
    const struct scene_film *spec = &scene->film;
    const int wanted = wanted_channels(scene, options, name);
    struct satin_film *film = film_new(spec->crop_width, spec->crop_height, name, wanted);
    if (!film) return NULL;
    film->x = spec->crop_x;
    film->y = spec->crop_y;
    film->full_width = spec->width;
    film->full_height = spec->height;
    film->full_float = spec->full_float;
    return film;
}

// ---- The values ---------------------------------------------------------------------------------

// The least number of rows that are converted at a time.
enum { FILM_BAND = 64 };

struct channel_planes render_film_planes(const struct render_image *image,
                                         struct satin_film *film) {
    struct channel_planes planes;
    for (int i = 0; i < FILM_CHANNELS; i++)
        planes.of[i] =
            is_aov(image->aovs, channels[i].name) ? NULL : film_channel(film, channels[i].name);
    for (int i = 0; i < image->aovs->count; i++)
        planes.aov[i] = film_channel(film, image->aovs->channel[i].name);
    return planes;
}

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
