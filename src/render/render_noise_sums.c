// SPDX-License-Identifier: Apache-2.0
// The sums of samples by which the filter of noise (render_noise_filter.c) compares pixels, and
// that show the noise of edges (render_edges_noise.c).
#include <stdlib.h>

#include "render/render_image.h"

bool render_noise_memory(struct render_image *image) {
    const size_t pixels = render_pixel_count(image);
    image->noisy_light = calloc(pixels, sizeof *image->noisy_light);
    image->change = calloc(pixels, sizeof *image->change);
    return image->noisy_light && image->change;
}

void render_noise_add(struct image_noisy *sum, int parity, const struct shade_sample *s) {
    sum->glossy = rgb_mad(sum->glossy, s->uncached_glossy, s->weight);
    sum->shown.albedo = rgb_mad(sum->shown.albedo, s->shown.albedo, s->weight);
    sum->shown.normal = rgb_mad(sum->shown.normal, s->shown.normal, s->weight);
    sum->shown.depth += s->weight * s->shown.depth;
    if (s->sampled_glossy) sum->sampled += s->weight;
    if (!(parity & 1)) return;
    if (s->sampled_glossy) sum->odd_sampled += s->weight;
    for (int k = 0; k < SHADE_EMISSION; k++)
        sum->odd[k] = rgb_mad(sum->odd[k], s->layer[k], s->weight);
    sum->odd_glossy = rgb_mad(sum->odd_glossy, s->uncached_glossy, s->weight);
    sum->weight += s->weight;
}
