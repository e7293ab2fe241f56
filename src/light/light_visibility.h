// SPDX-License-Identifier: Apache-2.0
// Part of light.h: sampling of lights around a point from which only some of them are visible.
// Samples of an environment that do not go to its sun are divided: a fraction goes to bins on the
// faces of a box, the others go by radiance.
#ifndef LIGHT_VISIBILITY_H
#define LIGHT_VISIBILITY_H

#include <stdbool.h>
#include <stdint.h>

#include "base/vec.h"

struct light;
struct light_sample;
struct satin_scene;

// A box, as large as a room, onto whose faces directions are projected: a window is in the same
// bins from all points of the room, while its direction is not. Points beyond it are moved into it
// first.
struct light_box {
    vec3 lo, hi;
};
// lo < hi in all coordinates.
struct light_box light_box_make(vec3 lo, vec3 hi);

enum {
    LIGHT_HISTOGRAM_SIDE = 32,  // rows of a face, and bins of a row
    LIGHT_HISTOGRAM_ROWS = 6 * LIGHT_HISTOGRAM_SIDE,
    LIGHT_HISTOGRAM_BINS = LIGHT_HISTOGRAM_ROWS * LIGHT_HISTOGRAM_SIDE,
    LIGHT_BLOCK_SIDE = 4,  // rows of a block of bins, and bins of each
    LIGHT_BLOCK_COLUMNS = LIGHT_HISTOGRAM_SIDE / LIGHT_BLOCK_SIDE,
    LIGHT_BLOCK_ROWS = 6 * LIGHT_BLOCK_COLUMNS,
    LIGHT_BLOCKS = LIGHT_BLOCK_ROWS * LIGHT_BLOCK_COLUMNS
};
// A distribution of points over the bins: a row is drawn by u, one of its bins by v. Each cdf is as
// by sample_cdf_build.
struct light_bins {
    float row[LIGHT_HISTOGRAM_ROWS + 1];
    float column[LIGHT_HISTOGRAM_ROWS][LIGHT_HISTOGRAM_SIDE + 1];  // of each row
};
// The blocks of bins by which the environment is visible from anywhere, row by row.
struct light_blocks {
    struct light_box box;
    uint8_t rows;         // number of rows that have blocks
    uint8_t face[6 + 1];  // of each face: its first row, by index
    // Which row each one is, and its first block, by index.
    uint8_t row[LIGHT_BLOCK_ROWS];
    uint16_t first[LIGHT_BLOCK_ROWS + 1];
    // The column of each block, and its middle.
    uint8_t column[LIGHT_BLOCKS];
    float x[LIGHT_BLOCKS], y[LIGHT_BLOCKS], z[LIGHT_BLOCKS];
};
// The visible-environment histogram: how much of the environment is visible by each bin.
struct light_histogram {
    float fraction;  // of the samples, in [0, 1)
    const struct light_blocks *blocks;
    // Sums of those of their bins, of which the largest is 65535 and 0 is none.
    uint16_t weight[LIGHT_BLOCKS];
    // Weights of the bins, row by row, of which the largest of a block is 255 and 0 is none.
    uint8_t bin[LIGHT_BLOCKS][LIGHT_BLOCK_SIDE][LIGHT_BLOCK_SIDE];
};

// A point that receives light.
struct light_receiver {
    vec3 p, n;  // n: unit normal on the side on which it is lit
    bool both;  // whether it is also lit from behind
};
// The distribution of samples of the environment at a point: the product of the weight of each
// block of its cell, the solid angle of the block, and its cosine. First a row of blocks is drawn,
// then one of its blocks, then a row of this and a bin of that, rows by u and columns by v, so that
// strata of u and v stay compact regions.
struct light_product {
    const struct light_histogram *histogram;
    vec3 p;                       // from which directions to the bins are drawn
    float fraction;               // of the samples; 0 if no block has weight
    float sum;                    // of the weights of all rows
    float row[LIGHT_BLOCK_ROWS];  // weights of the rows and of the blocks
    float block[LIGHT_BLOCKS];
};

// Up to this many lights are weighted individually at each point; more are chosen by a tree.
enum { LIGHT_WEIGHTS_MAX = 16 };
// The visibility of the lights around a point. A NULL member means that all is visible.
struct light_visibility {
    const struct light_product *product;  // of the environment, at the point that is lit
    const float *fraction;  // of each light: the visible fraction of light_estimate, > 0
};
#define LIGHT_ALL_VISIBLE ((struct light_visibility){NULL, NULL})

// An estimate of the irradiance (luminance) at p, which is 0 only if the light contributes none
// (light.c).
float light_estimate(const struct satin_scene *scene, const struct light *light, vec3 p);
// Chooses a light for direct lighting at p; *probability > 0. light_count must be > 0. Fractions
// are for scenes of up to LIGHT_WEIGHTS_MAX lights. *u is rescaled to [0, 1) within the choice, so
// that the light can be sampled by it: strata of one pair of numbers are then strata of the lights
// and of positions on each of them.
uint32_t light_choose(const struct satin_scene *scene, vec3 p, struct light_visibility visibility,
                      float *u, float *probability);
float light_choose_probability(const struct satin_scene *scene, vec3 p,
                               struct light_visibility visibility, uint32_t light);
// The probabilities of all lights, of which there must be at most LIGHT_WEIGHTS_MAX.
void light_choose_probabilities(const struct satin_scene *scene, vec3 p,
                                struct light_visibility visibility,
                                float probability[LIGHT_WEIGHTS_MAX]);
// Does what light_sample_wi does, but with regard to the visibility.
bool light_sample_visible(const struct satin_scene *scene, uint32_t i,
                          struct light_visibility visibility, vec3 p, float u, float v,
                          struct light_sample *out);
// Does the same in two steps, of which the second is only needed if the light arrives: to read a
// sky takes as long as a shadow ray. The first step may leave a sample of the environment `unread`,
// and the second sets its pdf_w and multiplies its L, which is 1 before, by the radiance. Either
// returns false if the light cannot contribute.
bool light_sample_draw(const struct satin_scene *scene, uint32_t i,
                       struct light_visibility visibility, vec3 p, float u, float v,
                       struct light_sample *out);
bool light_sample_read(const struct satin_scene *scene, struct light_visibility visibility,
                       struct light_sample *s);

// The direction (unit) from p of u, v in [0, 1) within a bin, in which they are uniform; v is along
// its row. *density is that of the direction over solid angle [sr^-1].
vec3 light_box_direction(const struct light_box *box, vec3 p, int bin, float u, float v,
                         float *density);
// The bin of a direction (unit) from p, and the density by which light_box_direction draws it.
int light_box_bin(const struct light_box *box, vec3 p, vec3 w, float *density);
// The point in a bin by two numbers in [0, 1), and the area of each bin across an axis.
vec3 light_box_point(const struct light_box *box, int bin, float u, float v);
float light_box_bin_area(const struct light_box *box, int axis);
// The bins around a bin on its face, and itself. Returns their number.
int light_box_around(int bin, int around[9]);
// Distributes points over the bins in proportion to their weights, which are row by row.
void light_bins_build(const float weight[LIGHT_HISTOGRAM_BINS], struct light_bins *out);
float light_bins_probability(const struct light_bins *bins, int row, int column);
// Finds the blocks that have some of the bins.
void light_blocks_build(const struct light_box *box, const bool bin[LIGHT_HISTOGRAM_BINS],
                        struct light_blocks *out);
// Makes the histogram of these weights, row by row, of bins in the blocks, which must outlive it.
// Some of the weights must be > 0, and all finite.
void light_histogram_build(const float weight[LIGHT_HISTOGRAM_BINS], float fraction,
                           const struct light_blocks *blocks, struct light_histogram *out);
// Makes the product for a receiver. With a normal of 0 there is no cosine.
void light_product_make(const struct light_histogram *histogram, const struct light_receiver *at,
                        struct light_product *out);
// As light_sample_draw, light_sample_read and light_pdf for the environment, which must exist, at
// the point of the product. NULL: all of it is visible.
bool light_environment_draw(const struct satin_scene *scene, const struct light_product *product,
                            float u, float v, struct light_sample *out);
bool light_environment_read(const struct satin_scene *scene, const struct light_product *product,
                            struct light_sample *s);
float light_environment_pdf(const struct satin_scene *scene, const struct light_product *product,
                            vec3 wi);

#endif
