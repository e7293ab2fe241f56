// SPDX-License-Identifier: Apache-2.0
// A cell of the sweep: one scene at one preset with one first pass, rendered with every seed, and
// the defects of these images.
#ifndef SWEEP_CELL_H
#define SWEEP_CELL_H

#include <stdbool.h>
#include <stdio.h>

#include "satin/render.h"

enum { CELL_SETTINGS = 64, CELL_HISTOGRAM = 32 };

// What all cells have in common.
struct plan {
    int seed_first, seed_count;
    int size;            // pixels, width and height
    int limit;           // seconds that one render may take; 0: any
    double threshold;    // sigmas beyond which a block is flagged
    bool worst;          // prints the worst score of every cell too
    const char *folder;  // folder for flagged images; NULL: none are kept
    const satin_define *define;
    size_t define_count;
    satin_setting setting[CELL_SETTINGS];  // beyond those of the cell
    size_t setting_count;
};

struct test_cell {
    const char *scene, *preset, *first_pass;
};

// The findings of a cell; the parent process reads them if a render has ended the child.
struct cell_tally {
    int renders;     // finished
    int seed;        // the current one
    int flags;       // lines printed as `flag`
    int blocks;      // flagged blocks, of all layers
    int few;         // lines printed as `few`
    int few_blocks;  // their blocks
    double records;  // sum of all statistics that count refused and non-finite values
    double worst;    // largest score
    long histogram[CELL_HISTOGRAM];  // blocks by score, rounded down; the last holds all above
    double seconds;                  // of wall time, of all renders
};

// Renders and evaluates; prints a line per flag to `out`. Renders on one thread.
void cell_run(const struct plan *plan, const struct test_cell *cell, struct cell_tally *tally,
              FILE *out);

// Begins a line of the form `WHAT KIND SCENE PRESET FIRST-PASS seed S`, without its end.
void cell_line(const struct test_cell *cell, const char *what, const char *kind, int seed,
               FILE *out);

// The samples per pixel of these options.
int cell_spp(const satin_options *options);

// Prints the command that makes one image again.
void cell_command(const struct plan *plan, const struct test_cell *cell, int seed, FILE *out);

#endif
