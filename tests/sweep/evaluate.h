// SPDX-License-Identifier: Apache-2.0
// The pictures of a cell, one per seed, and their layers.
#ifndef SWEEP_EVALUATE_H
#define SWEEP_EVALUATE_H

#include "cell.h"

enum { SEEDS_MOST = 64, LAYERS = 9 };

struct layer {
    const char *name, *channel[3];
    bool light;  // a part of the beauty
};

extern const struct layer evaluate_layer[LAYERS];  // the beauty first

struct work {
    const struct plan *plan;
    const struct cell *cell;
    struct tally *tally;
    FILE *out;
    int count;  // pictures
    int seed[SEEDS_MOST];
    satin_film *film[SEEDS_MOST];
    bool flagged[SEEDS_MOST];
    char message[512];  // the last one of level error
};

// Begins a line for a flag of picture `i`.
void evaluate_flag(struct work *w, const char *kind, int i);

// Flags blocks that differ from those of the other pictures, a line for each layer of a picture.
void evaluate_layers(struct work *w);

#endif
