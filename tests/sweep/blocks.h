// SPDX-License-Identifier: Apache-2.0
// Compares one channel of an image over several seeds, in blocks of 8x8 pixels: which block of
// which seed deviates by more than its noise allows.
//
// Legend: s a seed, b a block, p a pixel, S the number of seeds.
//
//     d[s][p]   a pixel less its median over the seeds, so that the scene's structure is gone
//     x[s][b]   mean of d over the block without its 3 largest and 3 smallest values, so that up to
//               three bright pixels on either side, which any estimator with rare paths has, do
//               not count
//     r[s][b]   x less its median over the seeds
//     D[b]      brightness of the block, at least a tenth of the image's
//     here    1.4826 times the median of |r[.][b]|
//     around  D times the 90 % quantile of |r| / D over the 3x3 blocks around b, over 1.645
//     all     D times the 75 % quantile of around / D over the image
//     pixels  x if each pixel takes the d that one of the other seeds, drawn by chance, has there:
//             how far the farthest of 256 draws is from their mean, on the side of r, over 2.8,
//             the mean for normal noise
//     sigma   root of max(here, pixels)^2 + around^2 + all^2 + floor^2
//     score   r / sigma
//
// `here` and `around` are of the other seeds alone, so that a bad block does not raise its own
// sigma, and do not change if one or two other seeds are bad as well. The first has noise that one
// block alone has, as at the edge of a caustic; the second has tails, from 9 (S - 1) values of few
// seeds; the third keeps the sigma of a block whose noise is small by chance, or in nine seeds of
// ten, from being much too small. `pixels` is the effect of independent noise of pixels on x: where
// light falls on a few of the pixels, as on a small glossy object, the trimmed mean of most seeds
// has none of it, and `here` is near 0. It is of the other seeds, too, and a disc or blotch in one
// of these adds little to it, because the draws take single pixels of it. It takes long, so it is
// computed where the score without it is beyond BLOCK_SURE. For normal noise, equal in all blocks,
// sigma is about 1.7 standard deviations.
#ifndef SWEEP_BLOCKS_H
#define SWEEP_BLOCKS_H

#include <stdbool.h>

enum { BLOCK_SIZE = 8, BLOCK_PIXELS = BLOCK_SIZE * BLOCK_SIZE, BLOCK_TRIM = 3 };

// Least number of seeds that can separate noise from a defect: with 5 the scales are of 4 and 36
// values.
enum { BLOCK_SEEDS_LEAST = 5 };

// Scores up to this one are computed without `pixels`.
enum { BLOCK_SURE = 4 };

struct block_stack {
    int width, height;    // pixels, multiples of BLOCK_SIZE
    int seeds;            // at least BLOCK_SEEDS_LEAST
    const float **pixel;  // per seed; rows from the top
    const double *floor;  // per block: least sigma; NULL: 0
};

struct block_scores {
    int count;           // blocks, row by row from the top
    double *brightness;  // D per block
    double *mean;        // per seed and block: the plain mean of its pixels
    double *usual;       // per block: median of these over the seeds
    double *score;       // per seed and block
};

// Fills *out, which block_scores_free frees. False if memory runs out; then *out is empty.
bool block_scores_make(const struct block_stack *stack, struct block_scores *out);
void block_scores_free(struct block_scores *scores);

// The mean of a - b over a block, without the 3 largest and 3 smallest values, of two images that
// are `width` pixels wide.
double block_difference(const float *a, const float *b, int width, int block);

#endif
