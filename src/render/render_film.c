// SPDX-License-Identifier: Apache-2.0
// The film of an image: means of the pixels' samples by channel. Where an image was cut short
// before a pixel had its first sample, it shows a neighbour's.
#include "render/render_image.h"

// Least weight of a pixel per sample; on average they weigh 1.
static const float WEIGHT_LEAST = 0.25f;

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
                                            "density.Y",
                                            "samples.Y",
                                            "records.position",
                                            "records.a",
                                            "records.weight",
                                            "records.rays"};

enum {
    CHANNEL_LAYERS = 3,
    CHANNEL_DEPTH = CHANNEL_LAYERS + 3 * SHADE_LAYERS,
    CHANNEL_DENSITY,
    CHANNEL_SAMPLES,
    CHANNEL_MAPS,  // four, of records, if they are asked for
    CHANNELS = CHANNEL_MAPS + 4
};
_Static_assert(CHANNELS == sizeof channel_names / sizeof *channel_names, "a name per channel");

static void put_rgb(struct satin_film *film, int channel, size_t at, rgb value, float scale) {
    film->channel[channel][at] = value.r * scale;
    film->channel[channel + 1][at] = value.g * scale;
    film->channel[channel + 2][at] = value.b * scale;
}

// The sampled pixel that stands for (x, y): itself, or the nearest of the grids of first_look; NULL
// if there is none.
static const struct image_pixel *source_of(const struct render_image *image, int x, int y) {
    for (int stride = 1; stride <= image->coarsest; stride *= 2) {
        size_t row = (size_t)(y - y % stride), column = (size_t)(x - x % stride);
        const struct image_pixel *pixel = &image->pixel[row * (size_t)image->width + column];
        if (pixel->samples || pixel->dropped) return pixel;
    }
    return NULL;
}

static void put_pixel(struct satin_film *film, size_t at, const struct image_pixel *pixel) {
    // A few samples of a filter with negative lobes may weigh next to nothing together.
    float least = WEIGHT_LEAST * (float)pixel->samples;
    float scale = pixel->samples ? 1.0f / fmaxf(pixel->weight, least) : 0.0f;
    put_rgb(film, 0, at, pixel->beauty, scale);
    for (int k = 0; k < SHADE_LAYERS; k++)
        put_rgb(film, CHANNEL_LAYERS + 3 * k, at, pixel->layer[k], scale);
    film->channel[CHANNEL_DEPTH][at] = pixel->depth * scale;
    if (pixel->samples)
        film->channel[CHANNEL_DENSITY][at] = (float)pixel->used.count / (float)pixel->samples;
}

// What the pixel's records are like, in the mean by weight.
static void put_maps(struct satin_film *film, size_t at, const struct image_pixel *pixel) {
    const struct cache_used *used = &pixel->used;
    const float scale = pixel->samples ? 1.0f / (float)pixel->samples : 0.0f;
    const float share = used->weight > 0.0f ? 1.0f / used->weight : 0.0f;
    film->channel[CHANNEL_MAPS][at] = pixel->record * scale;
    film->channel[CHANNEL_MAPS + 1][at] = used->a * share;
    film->channel[CHANNEL_MAPS + 2][at] = used->weight * scale;
    film->channel[CHANNEL_MAPS + 3][at] = used->rays * share;
}

struct satin_film *render_film_new(int width, int height, bool maps) {
    return film_new(width, height, channel_names, maps ? CHANNELS : CHANNEL_MAPS);
}

void render_image_film(struct render *r, bool *any) {
    const struct render_image *image = r->image;
    struct satin_film *film = image->film;
    uint64_t samples = 0, dropped = 0, filled = 0;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            size_t at = (size_t)y * (size_t)image->width + (size_t)x;
            const struct image_pixel *pixel = &image->pixel[at], *source = source_of(image, x, y);
            samples += pixel->samples;
            dropped += pixel->dropped;
            filled += source != pixel;
            film->channel[CHANNEL_SAMPLES][at] = (float)pixel->samples;
            if (source) put_pixel(film, at, source);
            if (source && r->options.record_maps) put_maps(film, at, source);
        }
    stats_set(&r->stats, "image.nonfinite", (double)dropped);
    stats_set(&r->stats, "image.filled", (double)filled);
    if (dropped)
        log_message(r->log, SATIN_LOG_WARNING, "%llu samples were not finite and were dropped",
                    (unsigned long long)dropped);
    if (samples && filled && !r->cancelled)
        log_message(r->log, SATIN_LOG_WARNING,
                    "the time was too short: %.0f %% of the pixels show a neighbour's sample",
                    100.0 * (double)filled / ((double)image->width * (double)image->height));
    *any = samples > 0;
}
