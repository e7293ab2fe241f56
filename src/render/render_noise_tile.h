// SPDX-License-Identifier: Apache-2.0
// Private to the filter of noise: the pixels that are filtered together, and those around them
// (render_noise_tile.c).
#ifndef RENDER_NOISE_TILE_H
#define RENDER_NOISE_TILE_H

#include "render/render_image.h"

// Pixels up to SEARCH away are compared by the squares of 2 * PATCH + 1 pixels around both. For
// these and the other constants see docs/experiments/denoising.md.
enum { SEARCH = 5, PATCH = 2 };
enum {
    HALVES = 2,
    TILE = 64,                    // pixels that are filtered together, in each direction
    MARGIN = SEARCH + PATCH + 3,  // three for the variance
    EXTENT = TILE + 2 * MARGIN,   // pixels that are read for a tile
    PIXELS_READ = EXTENT * EXTENT,
    COMPARED = TILE + 2 * PATCH,  // pixels that are compared for one offset
    PATCH_SIDE = 2 * PATCH + 1
};

// One half of the samples: planes of EXTENT rows.
struct half_plane {
    float light[NOISY_LAYERS][3][PIXELS_READ];  // weighted sums over the albedo
    float weight[NOISY_LAYERS][PIXELS_READ];    // of the samples that have such light
    float E[3][PIXELS_READ];                    // the mean
    float variance[3][PIXELS_READ];
};

// Every pixel of the image, or every second or fourth of each row and column, and so on.
struct noise_grid {
    struct render_image *image;
    int stride, width, height;
};

struct noise_tile {
    struct half_plane half[HALVES];
    float albedo[3][PIXELS_READ], normal[3][PIXELS_READ];
    float inverse[PIXELS_READ];                        // of the distance; 0: no surface
    float slope_x[PIXELS_READ], slope_y[PIXELS_READ];  // its change from pixel to pixel
    bool has[NOISY_LAYERS];               // whether some pixel has samples of the layer
    bool sampled[PIXELS_READ], complete;  // whether a pixel has samples, and whether all have
    bool filtered[TILE * TILE];           // whether this grid is the finest for a pixel
    // The variance of one unit of weight in one channel, by single pixels and by 3 x 3 pixels.
    float spread[PIXELS_READ], around[PIXELS_READ];
    // The pixels that are filtered, row by row: how far surfaces differ, and weighted sums over
    // what is similar.
    float surface[TILE * TILE], sum[NOISY_LAYERS][3][TILE * TILE];
    float weight[NOISY_LAYERS][TILE * TILE];
    float difference[COMPARED * COMPARED];
    float row[COMPARED * TILE];  // sums of PATCH_SIDE of these
};

static inline int render_noise_clamp(int x, int end) { return x < 0 ? 0 : x < end ? x : end - 1; }

// The pixel of the image at (x, y) of the grid, beyond which its border goes on.
static inline size_t render_noise_grid_pixel(const struct noise_grid *g, int x, int y) {
    const int column = render_noise_clamp(x, g->width) * g->stride,
              row = render_noise_clamp(y, g->height) * g->stride;
    return (size_t)row * (size_t)g->image->width + (size_t)column;
}

// Reads what is compared and summed of the tile whose first pixel is (x0, y0) of the grid.
void render_noise_tile_read(struct noise_tile *t, const struct noise_grid *g, int x0, int y0);
// What a layer changes by in pixel i of the tile, which is `at` in the image.
rgb render_noise_tile_change(const struct noise_tile *t, const struct render_image *image, int i,
                             size_t at, enum noisy_layer layer);

#endif
