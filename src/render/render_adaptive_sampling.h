// SPDX-License-Identifier: Apache-2.0
// Private to render/: spreading the samples of an image over its pixels.
#ifndef RENDER_ADAPTIVE_SAMPLING_H
#define RENDER_ADAPTIVE_SAMPLING_H

#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"

// What is known of one pixel's samples.
struct adapt_pixel {
    rgb sum, sum_before;     // of all samples, and of those before the last comparison
    uint32_t count, before;  // how many
    float spread;            // variance of the mean times count^GAIN, relative; < 0: not known yet
    uint32_t target;         // the next pass samples up to this count
    float squares;           // of the samples' luminances, summed
    float light_variance;    // of them by one light sample, summed
    uint32_t lights;         // light samples that the next sample takes
    uint32_t lights_taken;   // by all samples
};

struct adapt {
    int width, height;
    struct adapt_pixel *pixel;  // row by row
    float *scratch;             // 4 per pixel
    double *sum;                // by chunk of pixels
    struct parallel *pool;      // of the caller, which sets it; NULL: one thread
};

// False without memory. `lights`: light samples of the first samples.
bool adapt_make(struct adapt *adapt, int width, int height, int lights);
void adapt_destroy(struct adapt *adapt);  // a zeroed one is allowed

static inline void adapt_add(struct adapt_pixel *pixel, rgb value, float light_variance) {
    pixel->sum = rgb_add(pixel->sum, value);
    pixel->squares += sqrf(rgb_luminance(value));
    pixel->light_variance += light_variance;
    pixel->lights_taken += pixel->lights;
    pixel->count++;
}

// After a pass: compares each pixel's new samples with those before.
void adapt_compare(struct adapt *adapt);
// Targets of the next pass: `count` samples in every pixel.
void adapt_even(struct adapt *adapt, uint32_t count);
// Targets of the next pass: `samples` more where they lower the relative squared error of the image
// most; what noisy pixels cannot take in one pass is spread evenly.
void adapt_spread(struct adapt *adapt, uint64_t samples);

// The relative squared error of the image, summed over channels, that one sample per pixel would
// leave where adapt_spread wants it; of n samples it is this over n^1.5.
double adapt_variance(struct adapt *adapt);
// After a pass: how many light samples each pixel's next samples take. `cost`: of a sample without
// them, over one of them.
void adapt_lights(struct adapt *adapt, float cost);
// Mean number that a sample took.
double adapt_light_samples(const struct adapt *adapt);

#endif
