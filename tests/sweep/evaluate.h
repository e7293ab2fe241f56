// SPDX-License-Identifier: Apache-2.0
// The images of a cell, one per seed, and their layers.
#ifndef SWEEP_EVALUATE_H
#define SWEEP_EVALUATE_H

#include "cell.h"

enum { SEEDS_MOST = 64, LAYERS = 9 };

struct test_evaluate_layer {
    const char *name, *channel[3];
    bool light;  // a part of the beauty
};

extern const struct test_evaluate_layer evaluate_layer[LAYERS];  // the beauty first

// A block of a channel that differs from those of the other images.
struct flagged {
    int image, layer, channel, block;
    double score, ratio;  // the ratio is of its mean to the median of those of all images
    const char *few;      // what it had too few of, see explain.h; NULL: that is not known
};

struct work {
    const struct plan *plan;
    const struct test_cell *cell;
    struct cell_tally *tally;
    FILE *out;
    int count;  // images
    int seed[SEEDS_MOST];
    satin_film *film[SEEDS_MOST];
    bool flagged[SEEDS_MOST];
    struct flagged *block;  // the flagged blocks
    int blocks;
    char message[512];  // the last error
};

// Begins a line for a flag of image `i`.
void evaluate_flag(struct work *w, const char *kind, int i);

// Finds the blocks that differ from those of the other images.
void evaluate_layers(struct work *w);

// Prints these, a line for each layer of an image, and one more for those that are explained.
void evaluate_report(struct work *w);

#endif
