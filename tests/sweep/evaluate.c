// SPDX-License-Identifier: Apache-2.0
// Compares the images of a cell by the statistic of blocks.h, channel by channel.
#include "evaluate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "blocks.h"
#include "explain.h"

// Least sigma of a block, as a fraction of its own brightness in the layer and in the beauty: a
// deviation of less than six times that, 3 %, is not visible.
static const double own_floor = 0.005, beauty_floor = 0.0025;

const struct test_evaluate_layer evaluate_layer[LAYERS] = {
    {"beauty", {"R", "G", "B"}, false},
    {"direct", {"direct.R", "direct.G", "direct.B"}, true},
    {"caustic", {"caustic.R", "caustic.G", "caustic.B"}, true},
    {"indirect_diffuse", {"indirect_diffuse.R", "indirect_diffuse.G", "indirect_diffuse.B"}, true},
    {"indirect_glossy", {"indirect_glossy.R", "indirect_glossy.G", "indirect_glossy.B"}, true},
    {"emission", {"emission.R", "emission.G", "emission.B"}, true},
    {"albedo", {"albedo.R", "albedo.G", "albedo.B"}, false},
    {"normal", {"normal.X", "normal.Y", "normal.Z"}, false},
    {"depth", {"depth.Z", NULL, NULL}, false},
};

// Scores of one channel; false if an image lacks it or has values that are not finite, or if there
// are too few images.
static bool score_channel(const struct work *w, const char *name, const double *floor,
                          struct block_scores *out) {
    const float *pixel[SEEDS_MOST];
    if (!name || w->count < BLOCK_SEEDS_LEAST) return false;
    for (int s = 0; s < w->count; s++) {
        pixel[s] = satin_film_channel(w->film[s], name);
        if (!pixel[s]) return false;
        for (int p = 0; p < w->plan->size * w->plan->size; p++)
            if (!isfinite(pixel[s][p])) return false;
    }
    const struct block_stack stack = {w->plan->size, w->plan->size, w->count, pixel, floor};
    return block_scores_make(&stack, out);
}

static void count_score(struct cell_tally *tally, double score) {
    int at = score < CELL_HISTOGRAM - 1 ? (int)score : CELL_HISTOGRAM - 1;
    tally->histogram[at]++;
    tally->worst = fmax(tally->worst, score);
}

static void add_block(struct work *w, struct flagged block) {
    const size_t size = (size_t)(w->blocks + 1) * sizeof *w->block;
    struct flagged *more = realloc(w->block, size);
    if (!more) abort();  // the parent process reports a crash
    w->block = more;
    w->block[w->blocks++] = block;
}

static void evaluate_channel(struct work *w, const struct block_scores *scores, int layer,
                             int channel) {
    for (int s = 0; s < w->count; s++)
        for (int b = 0; b < scores->count; b++) {
            const int at = s * scores->count + b;
            const double size = fabs(scores->score[at]);
            count_score(w->tally, size);
            if (size > w->plan->threshold)
                add_block(w, (struct flagged){s, layer, channel, b, scores->score[at],
                                              scores->mean[at] / scores->usual[b], NULL});
        }
}

// The floor of each block of a layer's channel, from the brightness there; normals have length 1.
static void fill_floor(const struct test_evaluate_layer *layer, const struct block_scores *plain,
                       const struct block_scores *beauty, double *floor) {
    for (int b = 0; b < plain->count; b++) {
        floor[b] = own_floor * (strcmp(layer->name, "normal") == 0 ? 1.0 : plain->brightness[b]);
        if (layer->light) floor[b] = fmax(floor[b], beauty_floor * beauty->brightness[b]);
    }
}

static void evaluate_one(struct work *w, int k, double *floor) {
    const struct test_evaluate_layer *layer = &evaluate_layer[k];
    for (int c = 0; c < 3; c++) {
        struct block_scores plain, beauty, scores;
        if (!score_channel(w, layer->channel[c], NULL, &plain)) continue;
        if (score_channel(w, evaluate_layer[0].channel[c], NULL, &beauty)) {
            fill_floor(layer, &plain, &beauty, floor);
            block_scores_free(&beauty);
            if (score_channel(w, layer->channel[c], floor, &scores)) {
                evaluate_channel(w, &scores, k, c);
                block_scores_free(&scores);
            }
        }
        block_scores_free(&plain);
    }
}

void evaluate_layers(struct work *w) {
    const int columns = w->plan->size / BLOCK_SIZE;
    double *floor = calloc((size_t)(columns * columns), sizeof *floor);
    if (!floor) return;
    for (int k = 0; k < LAYERS; k++) evaluate_one(w, k, floor);
    free(floor);
}

// ---- Lines --------------------------------------------------------------------------------------

static void report_peak(struct work *w, const struct flagged *peak, int blocks) {
    const struct test_evaluate_layer *layer = &evaluate_layer[peak->layer];
    const int columns = w->plan->size / BLOCK_SIZE;
    if (peak->few) {
        cell_line(w->cell, "few", peak->few, w->seed[peak->image], w->out);
        w->tally->few_blocks += blocks;
        w->tally->few++;
    } else {
        evaluate_flag(w, "block", peak->image);
        w->tally->blocks += blocks;
    }
    fprintf(w->out, " %s %s pixel %d,%d ratio %.3f sigmas %.1f blocks %d\n", layer->name,
            layer->channel[peak->channel], peak->block % columns * BLOCK_SIZE,
            peak->block / columns * BLOCK_SIZE, peak->ratio, peak->score, blocks);
}

// The worst of the blocks of one layer of an image that have the same explanation.
static void report_layer(struct work *w, int image, int layer, const char *few) {
    const struct flagged *peak = NULL;
    int blocks = 0;
    for (const struct flagged *f = w->block; f < w->block + w->blocks; f++) {
        if (f->image != image || f->layer != layer || f->few != few) continue;
        blocks++;
        if (!peak || fabs(f->score) > fabs(peak->score)) peak = f;
    }
    if (peak) report_peak(w, peak, blocks);
}

void evaluate_report(struct work *w) {
    for (int k = 0; k < LAYERS; k++)
        for (int i = 0; i < w->count; i++) {
            report_layer(w, i, k, NULL);
            for (int e = 0; e < EXPLANATIONS; e++) report_layer(w, i, k, explain_name[e]);
        }
}
