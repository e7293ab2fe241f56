// SPDX-License-Identifier: Apache-2.0
// Private to render/: the image in the making.
#ifndef RENDER_IMAGE_H
#define RENDER_IMAGE_H

#include "render/render_state.h"

// The weighted sums of a pixel's samples.
struct image_pixel {
    rgb beauty;
    rgb layer[SHADE_LAYERS];
    float depth, record;
    struct cache_used used;
    float weight;  // that the film's filter gives to them
    uint32_t samples, dropped;
    rgb rim;  // emission of further eye rays, weighted (render_rims.c)
    float rim_weight;
};

struct render_image {
    int width, height;
    struct image_pixel *pixel;
    const struct scene_aovs *aovs;
    // Weighted sums of a pixel's aovs->values, and of `moment` those of their squares after them,
    // pixel by pixel; NULL: there are none.
    float *aov;
    size_t sums;  // of a pixel
    struct adapt adapt;
    uint64_t taken;           // samples
    uint32_t rim_rays;        // of each pixel at a rim; 0: render_rims has not been here
    int coarsest;             // pixels between the first samples, a power of two
    bool looked;              // each of these pixels has one
    struct satin_film *film;  // what it becomes
    // Of a render that denoises; else NULL.
    rgb *uncached;            // weighted sums of what shade_sample.uncached is, pixel by pixel
    rgb *planes;              // four images: means of `uncached`, albedo, normal, the result
    struct film_noisy noisy;  // these
    bool denoised;            // the result is there
};

// The sampled pixel that stands for (x, y): itself, or the nearest of the grids of the first look;
// NULL if there is none (render_film.c).
const struct image_pixel *render_image_source(const struct render_image *image, int x, int y);
// What makes means of a pixel's weighted sums.
float render_image_scale(const struct image_pixel *pixel);

// Memory for denoising, freed with the image; false without memory (render_denoise.c).
bool render_denoise_memory(struct render_image *image);

// Takes further eye rays for emitted light alone where it varies from pixel to pixel, once per
// pixel, when the image has its even samples. *whole: it was not cut short.
satin_status render_rims(struct render *r, bool *whole);

// The film, empty, of an image; NULL without memory (render_film.c).
struct satin_film *render_film_new(int width, int height, const struct scene_aovs *aovs,
                                   const satin_options *options);

#endif
