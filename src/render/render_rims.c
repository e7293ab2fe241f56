// SPDX-License-Identifier: Apache-2.0
// Rims of lights that are seen. A lamp is tens of times as bright as the wall around it, so a few
// samples more or less that hit it make the pixels along its edge look jagged. An eye ray for
// emitted light alone costs a small fraction of a sample: pixels near which emission varies get
// many of them, once, and the emission layer is the mean of all. Lights that are so small that the
// first samples miss them are found after later samples. Where a time limit leaves no sample to a
// pixel, it does not take the emission of its neighbour.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "render/render_image.h"

enum {
    RIMS_CHUNK = 64,  // pixels per chunk of rays
    CHUNK_ROWS = 8    // rows per chunk of the search
};

// Emission that varies by less than this fraction, such as that of a sky, is smooth.
static const float SMOOTH = 0.1f;

struct rims {
    struct render *r;
    float *emission;  // luminance of each pixel's samples
    uint32_t *pixel;  // y * width + x
    uint32_t *found;  // number of such pixels in each row
    size_t count;
};

static void read_emission(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct image_pixel *p = &rims->r->image->pixel[i];
        rims->emission[i] =
            p->samples ? rgb_luminance(p->layer[SHADE_EMISSION]) / (float)p->samples : 0.0f;
    }
}

// Whether emission varies between the pixel and those up to `radius` away, that is within the
// filter: the few samples of its tail may all miss a lamp that the pixel sees, or hit it by chance.
static bool on_rim(const struct rims *rims, int x, int y, int radius) {
    const struct render_image *image = rims->r->image;
    const int left = x > radius ? x - radius : 0, top = y > radius ? y - radius : 0;
    float least = INFINITY, most = 0.0f;
    for (int v = top; v <= y + radius && v < image->height; v++) {
        const float *row = rims->emission + (size_t)v * (size_t)image->width;
        for (int u = left; u <= x + radius && u < image->width; u++) {
            least = row[u] < least ? row[u] : least;
            most = row[u] > most ? row[u] : most;
        }
    }
    return most - least > SMOOTH * most;
}

// Whether the pixel has no sample and would take the emission of another one.
static bool copies_emission(const struct render_image *image, int x, int y) {
    const struct image_pixel *p = &image->pixel[(size_t)y * (size_t)image->width + (size_t)x];
    if (p->samples || p->dropped) return false;
    const struct image_pixel *source = render_image_source(image, x, y);
    return source && rgb_max(source->layer[SHADE_EMISSION]) > 0.0f;
}

// Stores the pixels of each row from the index on at which the row begins.
static void search_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    const struct render_image *image = rims->r->image;
    const size_t width = (size_t)image->width;
    const int radius = (int)ceilf(rims->r->second_pass.shade.filter.film->radius);
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (size_t at = y * width; at < (y + 1) * width; at++)
            if (!(image->pixel[at].rim_weight > 0.0f) &&
                (on_rim(rims, (int)(at - y * width), (int)y, radius) ||
                 copies_emission(image, (int)(at - y * width), (int)y)))
                rims->pixel[y * width + rims->found[y]++] = (uint32_t)at;
}

static void find_rims(struct rims *rims) {
    const struct render_image *image = rims->r->image;
    const size_t width = (size_t)image->width, height = (size_t)image->height;
    parallel_for_all(rims->r->pool, width * height, CHUNK_ROWS * width, read_emission, rims);
    parallel_for_all(rims->r->pool, height, CHUNK_ROWS, search_rows, rims);
    for (size_t y = 0; y < height; y++) {
        memmove(rims->pixel + rims->count, rims->pixel + y * width,
                rims->found[y] * sizeof *rims->pixel);
        rims->count += rims->found[y];
    }
}

static void trace_rims(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    struct render_image *image = rims->r->image;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const int x = (int)(rims->pixel[i] % (uint32_t)image->width);
        const int y = (int)(rims->pixel[i] / (uint32_t)image->width);
        struct image_pixel *p = &image->pixel[rims->pixel[i]];
        for (uint32_t k = 0; k < image->rim_rays; k++) {
            float weight;
            const rgb Le = shade_emission(&rims->r->second_pass.shade, x, y, k, &weight);
            if (!rgb_finite(Le)) continue;
            p->rim = rgb_mad(p->rim, Le, weight);
            p->rim_weight += weight;
        }
    }
}

static void pack_rims(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct rims *rims = ctx;
    for (size_t i = begin; i < end; i++) {
        const struct image_pixel *p = &rims->r->image->pixel[rims->pixel[i]];
        bytes_put(out, &p->rim, sizeof p->rim);
        bytes_put(out, &p->rim_weight, sizeof p->rim_weight);
    }
}

static bool unpack_rims(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct rims *rims = ctx;
    for (size_t i = begin; i < end; i++) {
        struct image_pixel *p = &rims->r->image->pixel[rims->pixel[i]];
        bytes_get(in, &p->rim, sizeof p->rim);
        bytes_get(in, &p->rim_weight, sizeof p->rim_weight);
    }
    return true;
}

static const struct parallel_results rims_results = {
    .pack = pack_rims, .unpack = unpack_rims, .if_cancelled = true};

bool render_has_rims(const struct render *r) {
    return r->progress.replaced || !gather_traces_paths(&r->options);
}

satin_status render_rims(struct render *r, bool late, bool *whole) {
    struct rims rims = {.r = r};
    struct render_image *image = r->image;
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    parallel_begin_part(r->pool, "rims");
    rims.emission = array_new_unset(pixels, sizeof *rims.emission);
    rims.pixel = array_new_unset(pixels, sizeof *rims.pixel);
    rims.found = array_new((size_t)image->height, sizeof *rims.found);
    if (!rims.emission || !rims.pixel || !rims.found) {
        free(rims.emission);
        free(rims.pixel);
        free(rims.found);
        return SATIN_ERROR_MEMORY;
    }
    find_rims(&rims);
    if (image->rim_rays == 0 && rims.count > 0)
        image->rim_rays =
            render_budget_rim_rays(&r->options, render_core_seconds(r), pixels, rims.count, late);
    *whole =
        parallel_for_results(r->pool, rims.count, RIMS_CHUNK, trace_rims, &rims, &rims_results);
    stats_add(&r->stats, "image.rim_pixels", (double)rims.count);
    free(rims.emission);
    free(rims.pixel);
    free(rims.found);
    return SATIN_OK;
}
