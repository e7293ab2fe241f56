// SPDX-License-Identifier: Apache-2.0
// Private to render/: the image while it is rendered.
#ifndef RENDER_IMAGE_H
#define RENDER_IMAGE_H

#include "render/render_state.h"

// The weighted sums of a pixel's samples.
struct image_pixel {
    rgb beauty;
    rgb layer[SHADE_LAYERS];
    float depth, alpha, record;
    struct cache_used used;
    float weight;  // in the film's filter
    uint32_t samples, dropped;
    rgb rim;  // weighted emission of additional eye rays (render_rims.c)
    float rim_weight;
};

// Sums over blocks of a pixel's consecutive samples. The samples of a pixel are stratified, so the
// variance of their mean is far less than it would be by the differences of single samples; the
// means of whole blocks are stratified each, and differ by little more than the mean of all.
struct image_blocks {
    rgb begun;          // the sum of the samples of the block that is not complete
    rgb sums, squares;  // of the sums of complete blocks
};
// The least number of blocks of a pixel.
enum { IMAGE_BLOCKS = 4 };

struct render_image {
    int width, height;
    struct image_pixel *pixel;
    const struct scene_aovs *aovs;
    // Weighted sums of each pixel's aovs->values, followed by those of their squares for `moment`,
    // pixel by pixel; NULL: there are none.
    float *aov;
    size_t sums;  // number of sums per pixel
    struct adaptive_sampling adapt;
    struct image_blocks *blocks;  // of path, for its variance; else NULL
    uint32_t block;               // number of samples of a block, a power of two
    uint64_t taken;               // number of samples
    uint32_t rim_rays;            // of each pixel at a rim; 0: none was found so far
    int coarsest;                 // pixels between the first samples, a power of two
    bool has_first_samples;       // whether each of these pixels has a sample
    struct satin_film *film;      // the film that is made from the image
    // Only if the image is to be denoised, else NULL:
    rgb *uncached;            // weighted sums of shade_sample.uncached, pixel by pixel
    rgb *planes;              // four images: means of `uncached`, albedo, normal, and the result
    struct film_noisy noisy;  // the denoiser's view of these
    bool denoised;            // whether there is a result
};

// The sampled pixel whose values are used at (x, y): the pixel itself, or the nearest one in the
// grids of the first samples; NULL if there is none (render_film.c).
const struct image_pixel *render_image_source(const struct render_image *image, int x, int y);
// The factor from a pixel's weighted sums to means.
float render_image_scale(const struct image_pixel *pixel);

// Allocates memory for denoising, which is freed with the image. False if there is no memory
// (render_denoise.c).
bool render_denoise_memory(struct render_image *image);

// Takes additional eye rays for emitted light where it varies between pixels, once per pixel, after
// the samples that are distributed equally. *whole is false if it was stopped early.
satin_status render_rims(struct render *r, bool *whole);

// Checks that the image has each layer of option layers; else logs one line (render_film.c).
satin_status render_film_check(const struct satin_scene *scene, const satin_options *options,
                               struct log log);
// Makes an empty film for an image; NULL if there is no memory (render_film.c).
struct satin_film *render_film_new(const struct satin_scene *scene, const satin_options *options);

#endif
