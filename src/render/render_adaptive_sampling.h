// SPDX-License-Identifier: Apache-2.0
// Private to render/: distribution of the samples of an image to its pixels.
#ifndef RENDER_ADAPTIVE_SAMPLING_H
#define RENDER_ADAPTIVE_SAMPLING_H

#include <stdint.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "shade/shade.h"

// Samples of direct light in the samples of one pixel.
struct adaptive_direct {
    float variance;  // sum of the samples' variances by one of them
    uint32_t next;   // in the next sample
    uint32_t taken;  // in all samples
};

// Gather rays in the samples of one pixel that meet no record.
struct adaptive_gathers {
    float variance;    // sum of the variances by one ray, of the samples with more than one
    uint32_t known;    // the number of these samples
    uint32_t samples;  // that of all that gather
    uint32_t next;     // rays in the next sample
    uint32_t taken;    // in all samples
};

// Statistics of one pixel's samples.
struct adaptive_pixel {
    rgb sum, sum_before;           // of all samples, and of those before the last comparison
    uint32_t count, before;        // their numbers
    float variance;                // variance of the mean times count^GAIN, relative; < 0: unknown
    uint32_t target;               // number of samples after the next pass
    float squares;                 // sum of the squares of the samples' luminances
    struct adaptive_direct light;  // light samples
    struct adaptive_direct lobe;   // BRDF samples of a glossy lobe
    struct adaptive_gathers gather;
};

struct adaptive_sampling {
    int width, height;
    struct adaptive_pixel *pixel;  // row by row
    float *scratch;                // 5 floats per pixel
    double *sum;                   // by chunk of pixels
    struct parallel *pool;         // of the caller, which sets it; NULL: one thread
};

// False if there is no memory. `direct` is the number of samples of direct light of either kind in
// the first samples, `gathers` that of gather rays.
bool render_adaptive_make(struct adaptive_sampling *adapt, int width, int height, int direct,
                          int gathers);
void render_adaptive_destroy(struct adaptive_sampling *adapt);  // a zeroed one is allowed

// What the next sample of a pixel takes.
static inline struct shade_sample_counts render_adaptive_next(const struct adaptive_pixel *pixel) {
    return (struct shade_sample_counts){{(int)pixel->light.next, pixel->light.taken},
                                        {(int)pixel->lobe.next, pixel->lobe.taken},
                                        {(int)pixel->gather.next, pixel->gather.taken}};
}
// Adds that sample; one that is not finite counts as black.
void render_adaptive_add(struct adaptive_pixel *pixel, const struct shade_sample *sample);

// To be called after a pass: compares each pixel's new samples with those before.
void render_adaptive_compare(struct adaptive_sampling *adapt);
// Sets the targets of the next pass to at least `count` samples in every pixel of a grid. `stride`
// is the number of pixels from one of them to the next, in both directions.
void render_adaptive_equal(struct adaptive_sampling *adapt, int stride, uint32_t count);
// Sets them to at least `count` samples in this fraction of the pixels, which are distributed over
// the image.
void render_adaptive_some(struct adaptive_sampling *adapt, double fraction, uint32_t count);
// Sets the targets of the next pass to `samples` more, where they lower the relative squared error
// of the image most. Samples beyond what noisy pixels may get in one pass are distributed
// uniformly.
void render_adaptive_distribute(struct adaptive_sampling *adapt, uint64_t samples);

// The relative squared error of the image, summed over channels, of one sample per pixel
// distributed by render_adaptive_distribute. Of n samples it is this over n^1.5.
double render_adaptive_variance(struct adaptive_sampling *adapt);
// To be called after a pass: sets the numbers of samples of direct light in each pixel's next
// samples, and with `gathers` that of gather rays. `cost` is the cost of a sample without them,
// over that of a light sample.
void render_adaptive_counts(struct adaptive_sampling *adapt, float cost, bool gathers);
// Sets those of direct light, or of gather rays, of all pixels to `count`.
void render_adaptive_direct(struct adaptive_sampling *adapt, uint32_t count);
void render_adaptive_gathers(struct adaptive_sampling *adapt, uint32_t count);
// The mean number of light samples of a sample.
double render_adaptive_light_samples(const struct adaptive_sampling *adapt);

#endif
