// SPDX-License-Identifier: Apache-2.0
// Noise of pixels at edges. The filter of noise finds few pixels that look like one at an edge, and
// where light is rare such a pixel is a bright or dark dot. But the regression predicts its light
// by that of the pixels around. Light that is farther from this than theirs is in the mean is moved
// to that distance, but not by more than its own noise, which two halves of the samples show. As
// noise becomes less, the image is what the samples give. Measured in docs/experiments/edges.md.
#include <math.h>

#include "render/render_edges.h"

enum { NOISE_AROUND = 1 };  // pixels up to so far away have the noise of one whose own is not known

static float sum_of_squares(rgb a) { return sqrf(a.r) + sqrf(a.g) + sqrf(a.b); }

// The variance of a layer by one unit of weight, summed over channels; negative if a half has no
// samples.
static float unit_variance(const struct render_image *image, size_t at, int layer) {
    const struct image_pixel *pixel = &image->pixel[at];
    const struct image_noisy *noisy = &image->noisy_light[at];
    const float odd = noisy->weight, even = pixel->weight - odd;
    if (!(odd > 0.0f && even > 0.0f)) return -1.0f;
    const rgb of_odd = rgb_scale(noisy->odd[layer], 1.0f / odd),
              of_even = rgb_scale(rgb_sub(pixel->layer[layer], noisy->odd[layer]), 1.0f / even),
              difference = rgb_sub(of_odd, of_even);
    return sum_of_squares(difference) * (even * odd / pixel->weight);
}

static float variance_around(const struct render_image *image, size_t at, int layer) {
    const int x = (int)(at % (size_t)image->width), y = (int)(at / (size_t)image->width);
    float sum = 0.0f, count = 0.0f;
    for (int v = y - NOISE_AROUND; v <= y + NOISE_AROUND; v++)
        for (int u = x - NOISE_AROUND; u <= x + NOISE_AROUND; u++) {
            if (u < 0 || v < 0 || u >= image->width || v >= image->height) continue;
            const float variance =
                unit_variance(image, (size_t)v * (size_t)image->width + (size_t)u, layer);
            if (variance < 0.0f) continue;
            sum += variance;
            count += 1.0f;
        }
    return count > 0.0f ? sum / count : INFINITY;
}

// The standard deviation of a layer of a pixel; infinite if it is not known.
static float layer_deviation(const struct render_image *image, size_t at, int layer) {
    const float own = unit_variance(image, at, layer),
                variance = own < 0.0f ? variance_around(image, at, layer) : own;
    return sqrtf(variance / image->pixel[at].weight);
}

void render_edges_quieten(const struct render_image *image, size_t at, const struct regression *g,
                          const float dx[REGRESSORS], const float light[REGRESSION_VALUES],
                          struct pixel_change *change) {
    float predicted[REGRESSION_VALUES];
    if (!image->noisy_light || !(image->pixel[at].weight > 0.0f)) return;
    render_regression_change(g, dx, predicted);
    for (int c = 0; c < REGRESSION_VALUES; c++)
        predicted[c] = clampf(predicted[c] + g->y_mean[c], g->least[c], g->most[c]);
    for (int k = 0; k < REGRESSION_LAYERS; k++) {
        const float *to = &predicted[3 * k], *from = &light[3 * k];
        const rgb way = rgb_make(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
        const float distance = sqrtf(sum_of_squares(way)),
                    beyond = distance - sqrtf(g->residual[k]);
        if (!(beyond > 0.0f) || !isfinite(distance)) continue;
        const float moved = minf(beyond, layer_deviation(image, at, k));
        change->light[k] = rgb_mad(change->light[k], way, moved / distance);
    }
}
