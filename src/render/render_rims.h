// SPDX-License-Identifier: Apache-2.0
// Private to render/: pixels at rims, where emission varies, and their rays.
#ifndef RENDER_RIMS_H
#define RENDER_RIMS_H

#include "render/render_image.h"

// What is known of a pixel at a rim: that it was found, its highlight has been visited, which was
// found by chance, and that enough of those are near. 0: nothing.
enum rim_known { RIM_FOUND = 1, RIM_VISITED = 2, RIM_BY_CHANCE = 4, RIM_NEAR = 8 };

// Sums over new rays of a pixel at a rim.
struct rim {
    rgb sum;  // weighted
    float weight, Y, squares;
    uint32_t rays;  // of the pixel, with those before
};

struct rims {
    struct render *r;
    struct shade wide;  // that of the image, with more eye rays in the tails of the film's filter
    bool late;          // the time limit is over: only pixels without samples have first rays
    uint32_t first;     // number of rays in pixels that are at no rim
    uint32_t most;      // number of rays at rims
    int radius;         // of the film's filter, in pixels
    float *emission;    // luminance of each pixel's mean
    struct pixel_list list;
    struct rim *rim;  // of those pixels
    size_t made;      // number of them
    size_t begin;     // index of the first pixel of a loop
    uint8_t *known;   // of each pixel of the image: enum rim_known
    // The hits that samples and first rays of a pixel at a rim are expected to have, and the
    // probability that its highlight is found.
    float *hits, *probability;
    uint32_t *highlight;  // pixels of the one that is visited
    size_t added;         // number of pixels that have got their first rays of rims
};

// The box of pixels up to `radius` away.
struct image_box render_rims_within(const struct rims *rims, size_t pixel, int radius);
// The box up to the filter's radius away: the few rays in its tail may all miss a lamp that the
// pixel sees, or hit it by chance.
struct image_box render_rims_around(const struct rims *rims, size_t pixel);
// Appends the pixels up to `radius` away that are not among the rims, as `known`.
void render_rims_append(struct rims *rims, size_t pixel, int radius, enum rim_known known);

// render_highlights.c

// Finds the highlights and their probabilities. Returns how many pixels were found by chance, but
// for those of the largest highlight that was: if it alone made more first rays be taken, the
// probability would depend on what was found.
size_t render_highlights_find(struct rims *rims);
// Appends the pixels around rims that were found by chance, as the former notes, where enough are
// near.
void render_highlights_append_near(struct rims *rims);

#endif
