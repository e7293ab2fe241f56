// SPDX-License-Identifier: Apache-2.0
// Private to render/: spreading the samples of an image over its pixels.
#ifndef RENDER_ADAPT_H
#define RENDER_ADAPT_H

#include <stdint.h>

#include "base/vec.h"

// What is known of one pixel's samples.
struct adapt_pixel {
    rgb sum, sum_before;     // of all samples, and of those before the last judgement's new ones
    uint32_t count, before;  // how many
    float spread;            // variance of the mean times count^GAIN, relative; < 0: not judged yet
    uint32_t target;         // the next pass samples up to this count
};

struct adapt {
    int width, height;
    struct adapt_pixel *pixel;  // row by row
    float *scratch;             // 2 per pixel
};

// False without memory.
bool adapt_make(struct adapt *adapt, int width, int height);
void adapt_destroy(struct adapt *adapt);  // a zeroed one is allowed

static inline void adapt_add(struct adapt_pixel *pixel, rgb value) {
    pixel->sum = rgb_add(pixel->sum, value);
    pixel->count++;
}

// After a pass: compares each pixel's new samples with those before.
void adapt_judge(struct adapt *adapt);
// Targets of the next pass: `count` samples in every pixel.
void adapt_even(struct adapt *adapt, uint32_t count);
// Targets of the next pass: `samples` more where they lower the relative squared error of the image
// most; what noisy pixels cannot take in one pass is spread evenly.
void adapt_spread(struct adapt *adapt, uint64_t samples);

#endif
