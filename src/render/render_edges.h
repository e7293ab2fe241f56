// SPDX-License-Identifier: Apache-2.0
// Private to render/: edges of surfaces in the image (render_edges.c), their noise
// (render_edges_noise.c), and which of them a time limit allows (render_edges_plan.c).
#ifndef RENDER_EDGES_H
#define RENDER_EDGES_H

#include "render/render_image.h"
#include "render/render_regression.h"

enum {
    EDGES_CHUNK = 64,   // edges per chunk
    RAY_SHIFT_MOST = 4  // their numbers of rays are divided by 1 << this, at most, for a time limit
};

// Surfaces are alike if no channel of albedo or normal, nor alpha, differs by more than this, and
// the depth not by more than this fraction.
static const float EDGE_ALIKE = 0.1f;

// What is added to the means of a pixel.
struct pixel_change {
    rgb light[REGRESSION_LAYERS];
    struct shade_surface surface;  // the first one
};
_Static_assert(sizeof(struct pixel_change) + sizeof(uint32_t) + 1 <= RENDER_EDGES_BYTES, "memory");

struct surface_edges {
    struct render *r;
    uint8_t *differs;  // of each pixel: a bit for each neighbour in directions FORWARD, and CROSSED
    struct pixel_list list;
    struct pixel_change *change;
    int ray_shift;  // the numbers of rays are divided by 1 << ray_shift
    float alike;    // by how much surfaces differ at most if there is no edge between them
};

// Finds the edges of the image. False if it is not to have any and, with *failed, if there is no
// memory.
bool render_edges_make(struct surface_edges *e, struct render *r, bool *failed);
void render_edges_destroy(struct surface_edges *e);
// Finds them again, by e->alike.
void render_edges_find(struct surface_edges *e);
// The number of rays of a pixel with so many samples.
uint32_t render_edge_rays(const struct surface_edges *e, double samples);
// Whether there is no time limit, or it may leave time for edges, after render_edges_plan.
bool render_edges_have_time(const struct render *r);
// Leaves out rays and edges for which it has no time.
void render_edges_fit(struct surface_edges *e);
// Adds to `change` what takes noise from the light of a pixel, which includes that change. dx: what
// it shows, less the means of the regressors.
void render_edges_quieten(const struct render_image *image, size_t at, const struct regression *g,
                          const float dx[REGRESSORS], const float light[REGRESSION_VALUES],
                          struct pixel_change *change);
// Finds the changes of edges [begin, end) of the list: a parallel_fn.
void render_edges_change(void *ctx, size_t begin, size_t end, int worker);

#endif
