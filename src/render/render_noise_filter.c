// SPDX-License-Identifier: Apache-2.0
// Filters direct light and sampled gloss by non-local means [Rousselle et al. 2012]: a pixel's
// samples are averaged with those of pixels around it whose surroundings look the same within their
// noise. Two halves of the samples are filtered, each with weights that the other one gives, so
// that no sample decides by its own brightness where it counts. As noise becomes less, fewer pixels
// look the same, and the image is what the samples give.
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/wide.h"
#include "render/render_noise_tile.h"

// Differences are counted in units, in the mean over channels: that of light is one if its square
// is as large as the variance of both pixels beyond what their noise explains; and those of
// surfaces are one if the squared distance of normals, or the squared difference of albedos over
// their product, is this.
static const float NORMAL_UNIT = 0.2f, ALBEDO_UNIT = 0.5f;
// That of inverse distances from a plane is one if it is this fraction of them, or what they change
// by from a pixel to the next: planes are linear in these.
static const float DISTANCE_UNIT = 0.05f;
// The square of a difference that noise explains, in variances of one pixel.
static const float EXPLAINED = 2.0f;
// A pixel with more than this many times the variance of another one has no more in common with it
// because of that.
static const float NOISIER_MOST = 100.0f;
// From this many units on pixels have nothing in common.
static const float UNITS_MOST = 4.0f;

bool render_noise_filter_on(const satin_options *o) {
    return o->noise_filter && o->integrator == SATIN_TWO_PASS && !o->denoise;
}

// ---- Pixels that look the same ------------------------------------------------------------------

// The pixel of a plane from which on a row is filtered, or compared with those at an offset.
static int filtered_from(int row) { return (row + MARGIN) * EXTENT + MARGIN; }
static int compared_from(int row) { return (row + MARGIN - PATCH) * EXTENT + MARGIN - PATCH; }

// How far pixel q is from the plane of p.
static float distance_units(const struct noise_tile *t, int p, int q, float dx, float dy) {
    const float from_plane =
        t->inverse[q] - t->inverse[p] - t->slope_x[p] * dx - t->slope_y[p] * dy;
    const float unit = DISTANCE_UNIT * maxf(t->inverse[p], t->inverse[q]) + fabsf(t->slope_x[p]) +
                       fabsf(t->slope_y[p]) + FLT_MIN;
    return sqrf(from_plane / unit);
}

WIDE static void compare_surfaces(struct noise_tile *t, int dx, int dy) {
    static const float of_normals = 1.0f / NORMAL_UNIT, of_albedos = 1.0f / (3.0f * ALBEDO_UNIT);
    for (int row = 0; row < TILE; row++)
        for (int k = 0; k < TILE; k++) {
            const int p = filtered_from(row) + k, q = p + dy * EXTENT + dx;
            const float normals = sqrf(t->normal[0][p] - t->normal[0][q]) +
                                  sqrf(t->normal[1][p] - t->normal[1][q]) +
                                  sqrf(t->normal[2][p] - t->normal[2][q]);
            float albedos = 0.0f;
            for (int c = 0; c < 3; c++)
                albedos +=
                    sqrf(t->albedo[c][p] - t->albedo[c][q]) / (t->albedo[c][p] * t->albedo[c][q]);
            t->surface[row * TILE + k] = of_normals * normals + of_albedos * albedos +
                                         distance_units(t, p, q, (float)dx, (float)dy);
        }
}

// The differences of pixels by one half. What is almost free of noise, such as a dark mirror, has
// nothing in common with a highlight beside it whose few samples might be as dark.
WIDE static void compare_light(struct noise_tile *t, const struct half_plane *by, int offset) {
    static const float of_channels = 1.0f / 3.0f;
    for (int row = 0; row < COMPARED; row++)
        for (int k = 0; k < COMPARED; k++) {
            const int p = compared_from(row) + k, q = p + offset;
            float sum = 0.0f;
            for (int c = 0; c < 3; c++) {
                const float of_p = by->variance[c][p], of_q = by->variance[c][q];
                const float explained = EXPLAINED * (of_p + minf(of_p, of_q));
                sum += (sqrf(by->E[c][p] - by->E[c][q]) - explained) /
                       (of_p + minf(of_q, NOISIER_MOST * of_p) + FLT_MIN);
            }
            t->difference[row * COMPARED + k] = of_channels * sum;
        }
}

WIDE static void sum_patch_rows(struct noise_tile *t) {
    for (int row = 0; row < COMPARED; row++) {
        const float *from = t->difference + row * COMPARED;
        for (int k = 0; k < TILE; k++) {
            float sum = 0.0f;
            for (int i = 0; i < PATCH_SIDE; i++) sum += from[k + i];
            t->row[row * TILE + k] = sum;
        }
    }
}

// What lies in the image of a tile at an offset: pixels [begin, end) of each row, and of rows.
struct tile_range {
    int begin, end;
};

static struct tile_range range_inside(int tile, int offset, int size) {
    const int begin = -(tile + offset), end = size - (tile + offset);
    return (struct tile_range){begin > 0 ? begin : 0, end < TILE ? end : TILE};
}

// What a pixel at an offset counts. It falls smoothly, lest a bright sample become a square.
static float nearness(int dx, int dy) {
    static const float of_radius = 1.0f / ((SEARCH + 1) * (SEARCH + 1));
    return maxf(1.0f - of_radius * (float)(dx * dx + dy * dy), 0.0f);
}

// How similar the pixels of a row are, as the sums of patches say that are summed in rows, times
// how near they are. Loops of one step each, as compilers make jumps of a maximum whose result is
// multiplied: this takes less than half of the time of one loop.
WIDE_INLINE void find_similar(const float *restrict sums, const float *restrict surface,
                              float *restrict similar, float near) {
    static const float of_patch = 1.0f / (PATCH_SIDE * PATCH_SIDE), of_most = 1.0f / UNITS_MOST;
    for (int k = 0; k < TILE; k++) {
        float sum = 0.0f;
        for (int i = 0; i < PATCH_SIDE; i++) sum += sums[i * TILE + k];
        similar[k] = sum * of_patch;
    }
    for (int k = 0; k < TILE; k++) similar[k] = at_least(similar[k], 0.0f);
    for (int k = 0; k < TILE; k++) similar[k] = 1.0f - of_most * (similar[k] + surface[k]);
    for (int k = 0; k < TILE; k++) similar[k] = maxf(similar[k], 0.0f);
    for (int k = 0; k < TILE; k++) similar[k] = near * sqrf(sqrf(similar[k]));
}

WIDE_INLINE void add_similar_row(float *restrict to, const float *restrict from,
                                 const float *restrict similar, struct tile_range columns) {
    for (int k = columns.begin; k < columns.end; k++) to[k] += similar[k] * from[k];
}

// Adds the samples of `half` at the offset, by how near and how similar in the other half that is.
WIDE static void add_similar(struct noise_tile *t, const struct half_plane *half, int offset,
                             struct tile_range rows, struct tile_range columns, float near) {
    float similar[TILE];
    for (int row = rows.begin; row < rows.end; row++) {
        const int to = row * TILE, q = filtered_from(row) + offset;
        find_similar(t->row + to, t->surface + to, similar, near);
        for (int layer = 0; layer < NOISY_LAYERS; layer++) {
            if (!t->has[layer]) continue;
            for (int c = 0; c < 3; c++)
                add_similar_row(t->sum[layer][c] + to, half->light[layer][c] + q, similar, columns);
            add_similar_row(t->weight[layer] + to, half->weight[layer] + q, similar, columns);
        }
    }
}

// ---- Tiles --------------------------------------------------------------------------------------

static bool has_samples(const struct render_image *image, int x, int y) {
    return x >= 0 && y >= 0 && x < image->width && y < image->height &&
           image->pixel[(size_t)y * (size_t)image->width + (size_t)x].samples > 0;
}

// The stride of the finest grid on which a pixel has a neighbour with samples.
static int stride_around(const struct render_image *image, int x, int y) {
    int stride = 1;
    while (stride < image->coarsest && !((x | y) & stride) && !has_samples(image, x - stride, y) &&
           !has_samples(image, x + stride, y) && !has_samples(image, x, y - stride) &&
           !has_samples(image, x, y + stride))
        stride *= 2;
    return stride;
}

// Finds the pixels of a tile that have samples and of which this is the finest grid.
static bool find_finest_pixels(struct noise_tile *t, const struct noise_grid *g, int x0, int y0) {
    bool any = false;
    for (int i = 0; i < TILE * TILE; i++) {
        const int x = (x0 + i % TILE) * g->stride, y = (y0 + i / TILE) * g->stride;
        t->filtered[i] = has_samples(g->image, x, y) && stride_around(g->image, x, y) == g->stride;
        any = any || t->filtered[i];
    }
    return any;
}

static void filter_tile(struct noise_tile *t, const struct noise_grid *g, int x0, int y0) {
    if (!find_finest_pixels(t, g, x0, y0)) return;
    render_noise_tile_read(t, g, x0, y0);
    memset(t->sum, 0, sizeof t->sum);
    memset(t->weight, 0, sizeof t->weight);
    for (int dy = -SEARCH; dy <= SEARCH; dy++)
        for (int dx = -SEARCH; dx <= SEARCH; dx++) {
            const float near = nearness(dx, dy);
            if (!(near > 0.0f)) continue;
            const int offset = dy * EXTENT + dx;
            compare_surfaces(t, dx, dy);
            for (int h = 0; h < HALVES; h++) {
                compare_light(t, &t->half[1 - h], offset);
                sum_patch_rows(t);
                add_similar(t, &t->half[h], offset, range_inside(y0, dy, g->height),
                            range_inside(x0, dx, g->width), near);
            }
        }
    for (int i = 0; i < TILE * TILE; i++) {
        if (!t->filtered[i]) continue;
        const size_t at = render_noise_grid_pixel(g, x0 + i % TILE, y0 + i / TILE);
        for (enum noisy_layer layer = 0; layer < NOISY_LAYERS; layer++)
            g->image->change[at].layer[layer] = render_noise_tile_change(t, g->image, i, at, layer);
    }
}

struct noise_filter {
    struct noise_grid grid;
    struct noise_tile *tile;  // one for each worker
    size_t columns;
};

static void filter_tiles(void *ctx, size_t begin, size_t end, int worker) {
    const struct noise_filter *f = ctx;
    for (size_t i = begin; i < end; i++)
        filter_tile(&f->tile[worker], &f->grid, (int)(i % f->columns) * TILE,
                    (int)(i / f->columns) * TILE);
}

static struct noise_grid grid_of(struct render_image *image, int stride) {
    return (struct noise_grid){image, stride, (image->width - 1) / stride + 1,
                               (image->height - 1) / stride + 1};
}

// Pixels whose neighbours have no samples are filtered on the grid on which these have some.
bool render_noise_change(struct render_image *image, struct parallel *pool) {
    struct noise_tile *tile = array_new((size_t)parallel_threads(pool), sizeof *tile);
    if (!tile) return false;
    memset(image->change, 0, render_pixel_count(image) * sizeof *image->change);
    for (int stride = 1; stride == 1 || stride <= image->coarsest; stride *= 2) {
        const struct noise_grid grid = grid_of(image, stride);
        const size_t columns = ((size_t)grid.width + TILE - 1) / TILE,
                     rows = ((size_t)grid.height + TILE - 1) / TILE;
        struct noise_filter f = {grid, tile, columns};
        parallel_for_all(pool, columns * rows, 1, filter_tiles, &f);
    }
    free(tile);
    return true;
}

double render_noise_pixel_seconds(void) {
    struct render_image *trial = calloc(1, sizeof *trial);
    struct noise_tile *tile = array_new(1, sizeof *tile);
    double seconds = 0.0;
    if (trial) {
        trial->width = trial->height = TILE;
        trial->pixel = calloc(TILE * TILE, sizeof *trial->pixel);
    }
    if (tile && trial && trial->pixel && render_noise_memory(trial)) {
        for (int i = 0; i < TILE * TILE; i++) {
            trial->pixel[i].samples = 1;
            trial->pixel[i].weight = 1.0f;
            trial->noisy_light[i].sampled = 1.0f;
        }
        const struct noise_grid grid = grid_of(trial, 1);
        const double start = stats_thread();
        filter_tile(tile, &grid, 0, 0);
        seconds = (stats_thread() - start) / (TILE * TILE);
    }
    render_image_free(trial);
    free(tile);
    return seconds;
}

bool render_noise_filter(struct render *r) {
    if (!r->image->noisy_light || !render_budget_filters_noise(r)) return true;
    parallel_begin_part(r->pool, "noise_filter");
    return render_noise_change(r->image, r->pool);
}
