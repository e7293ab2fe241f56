// SPDX-License-Identifier: Apache-2.0
// The statistic of blocks.h.
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "blocks.h"

// The largest of 256 normal numbers is 2.8 on average.
enum { DRAWS = 256 };
static const double BLOCKS_FARTHEST = 2.8;

static int blocks_compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Sorts `value`. The mean of the middle two of an even number.
static double blocks_median(double *value, int count) {
    qsort(value, (size_t)count, sizeof *value, blocks_compare);
    return 0.5 * (value[(count - 1) / 2] + value[count / 2]);
}

// Sorts `value`.
static double quantile(double *value, int count, double q) {
    qsort(value, (size_t)count, sizeof *value, blocks_compare);
    return count ? value[(int)ceil(q * count) - 1] : 0.0;
}

// Sorts `value`.
static double trimmed_mean(double *value, int count) {
    double sum = 0.0;
    qsort(value, (size_t)count, sizeof *value, blocks_compare);
    for (int i = BLOCK_TRIM; i < count - BLOCK_TRIM; i++) sum += value[i];
    return sum / (count - 2 * BLOCK_TRIM);
}

// Data of all steps below: `residual` is r; `row` and `all` have space for the numbers
// of which a quantile is taken, over the seeds and over all blocks.
struct blocks_work {
    const struct block_stack *stack;
    struct block_scores *out;
    double *centre, *residual, *all, *row;
    int columns;
};

static void find_centres(const struct blocks_work *w) {
    const struct block_stack *in = w->stack;
    for (size_t p = 0; p < (size_t)in->width * (size_t)in->height; p++) {
        for (int s = 0; s < in->seeds; s++) w->row[s] = (double)in->pixel[s][p];
        w->centre[p] = blocks_median(w->row, in->seeds);
    }
}

// The position of pixel `i` of a block in an image.
static size_t block_pixel(int width, int block, int i) {
    const int columns = width / BLOCK_SIZE;
    const int x = block % columns * BLOCK_SIZE + i % BLOCK_SIZE;
    const int y = block / columns * BLOCK_SIZE + i / BLOCK_SIZE;
    return (size_t)y * (size_t)width + (size_t)x;
}

// d of a pixel of the image.
static double pixel_residual(const struct blocks_work *w, int seed, size_t p) {
    return (double)w->stack->pixel[seed][p] - w->centre[p];
}

static void measure_block(const struct blocks_work *w, int seed, int block) {
    double d[BLOCK_PIXELS], sum = 0.0;
    for (int i = 0; i < BLOCK_PIXELS; i++) {
        const size_t p = block_pixel(w->stack->width, block, i);
        d[i] = pixel_residual(w, seed, p);
        sum += (double)w->stack->pixel[seed][p];
    }
    int at = seed * w->out->count + block;
    w->out->mean[at] = sum / BLOCK_PIXELS;
    w->residual[at] = trimmed_mean(d, BLOCK_PIXELS);
}

// Subtracts the median over the seeds from a block's residuals.
static void centre_block(const struct blocks_work *w, int block) {
    const int seeds = w->stack->seeds, count = w->out->count;
    for (int s = 0; s < seeds; s++) w->row[s] = w->residual[s * count + block];
    double usual = blocks_median(w->row, seeds);
    for (int s = 0; s < seeds; s++) w->residual[s * count + block] -= usual;
    for (int s = 0; s < seeds; s++) w->row[s] = w->out->mean[s * count + block];
    w->out->usual[block] = blocks_median(w->row, seeds);
}

static void find_brightness(const struct blocks_work *w) {
    double sum = 0.0;
    for (int b = 0; b < w->out->count; b++) sum += fabs(w->out->usual[b]);
    for (int b = 0; b < w->out->count; b++)
        w->out->brightness[b] = fmax(fabs(w->out->usual[b]), 0.1 * sum / w->out->count);
}

// The scale of the residuals of the other seeds at the block.
static double scale_here(const struct blocks_work *w, int seed, int block) {
    int n = 0;
    for (int s = 0; s < w->stack->seeds; s++)
        if (s != seed) w->row[n++] = fabs(w->residual[s * w->out->count + block]);
    return 1.4826 * blocks_median(w->row, n);
}

// The deviation of the block's mean, on the side of `sign`, by independent noise of its pixels that
// is as strong as in the other seeds.
static double scale_pixels(const struct blocks_work *w, int seed, int block, double sign) {
    struct rng rng = rng_make((uint64_t)seed, RNG_TEST, (uint64_t)block);
    double sum = 0.0, most = -INFINITY;
    for (int k = 0; k < DRAWS; k++) {
        double d[BLOCK_PIXELS];
        for (int i = 0; i < BLOCK_PIXELS; i++) {
            const int drawn = (int)(rng_u32(&rng) % (uint32_t)(w->stack->seeds - 1));
            d[i] =
                pixel_residual(w, drawn + (drawn >= seed), block_pixel(w->stack->width, block, i));
        }
        const double x = copysign(1.0, sign) * trimmed_mean(d, BLOCK_PIXELS);
        sum += x;
        most = fmax(most, x);
    }
    return (most - sum / DRAWS) / BLOCKS_FARTHEST;
}

// The scale of the residuals of the block and those around it, over their brightness.
static double scale_around(const struct blocks_work *w, int seed, int block) {
    const int columns = w->columns, rows = w->out->count / columns;
    int n = 0;
    for (int i = 0; i < 9; i++) {
        int x = block % columns + i % 3 - 1, y = block / columns + i / 3 - 1, b = y * columns + x;
        if (x < 0 || x >= columns || y < 0 || y >= rows || !(w->out->brightness[b] > 0.0)) continue;
        for (int s = 0; s < w->stack->seeds; s++)
            if (s != seed)
                w->row[n++] = fabs(w->residual[s * w->out->count + b]) / w->out->brightness[b];
    }
    return quantile(w->row, n, 0.9) / 1.645;
}

// Fills `out->score` with the scales around and returns their quantile over the image.
static double scale_of_image(const struct blocks_work *w) {
    const int count = w->out->count, all = count * w->stack->seeds;
    for (int i = 0; i < all; i++) w->out->score[i] = scale_around(w, i / count, i % count);
    memcpy(w->all, w->out->score, (size_t)all * sizeof *w->all);
    return quantile(w->all, all, 0.75);
}

// Replaces the scales in `out->score`.
static void find_scores(const struct blocks_work *w) {
    const double image = scale_of_image(w);
    for (int i = 0; i < w->out->count * w->stack->seeds; i++) {
        const int block = i % w->out->count;
        const double brightness = w->out->brightness[block], r = w->residual[i];
        const double around = hypot(w->out->score[i], image) * brightness;
        const double floor = w->stack->floor ? w->stack->floor[block] : 0.0;
        const double here = scale_here(w, i / w->out->count, block), rest = hypot(around, floor);
        double score = r == 0.0 ? 0.0 : r / hypot(here, rest);
        if (fabs(score) > BLOCK_SURE)
            score = r / hypot(fmax(here, scale_pixels(w, i / w->out->count, block, r)), rest);
        w->out->score[i] = score;
    }
}

void block_scores_free(struct block_scores *scores) {
    free(scores->brightness);
    free(scores->mean);
    free(scores->usual);
    free(scores->score);
    *scores = (struct block_scores){0};
}

double block_difference(const float *a, const float *b, int width, int block) {
    double d[BLOCK_PIXELS];
    for (int i = 0; i < BLOCK_PIXELS; i++) {
        const size_t p = block_pixel(width, block, i);
        d[i] = (double)a[p] - (double)b[p];
    }
    return trimmed_mean(d, BLOCK_PIXELS);
}

static double *numbers(size_t count) { return calloc(count, sizeof(double)); }

static void score_all(const struct blocks_work *w) {
    for (int s = 0; s < w->stack->seeds; s++)
        for (int b = 0; b < w->out->count; b++) measure_block(w, s, b);
    for (int b = 0; b < w->out->count; b++) centre_block(w, b);
    find_brightness(w);
    find_scores(w);
}

bool block_scores_make(const struct block_stack *stack, struct block_scores *out) {
    const int columns = stack->width / BLOCK_SIZE, count = columns * (stack->height / BLOCK_SIZE);
    const size_t blocks = (size_t)count, all = blocks * (size_t)stack->seeds;
    *out =
        (struct block_scores){count, numbers(blocks), numbers(all), numbers(blocks), numbers(all)};
    struct blocks_work w = {.stack = stack,
                            .out = out,
                            .centre = numbers(blocks * BLOCK_PIXELS),
                            .residual = numbers(all),
                            .all = numbers(all),
                            .row = numbers((size_t)stack->seeds * 9),
                            .columns = columns};
    const bool good = out->brightness && out->mean && out->usual && out->score && w.centre &&
                      w.residual && w.all && w.row;
    if (good) {
        find_centres(&w);
        score_all(&w);
    } else {
        block_scores_free(out);
    }
    free(w.centre);
    free(w.residual);
    free(w.all);
    free(w.row);
    return good;
}
