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
#include "render/render_image.h"

// Pixels up to SEARCH away are compared by the squares of 2 * PATCH + 1 pixels around both. For
// these and the other constants see docs/experiments/denoising.md.
enum { SEARCH = 5, PATCH = 2 };
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
// Irradiance is light over albedo, which is at least this.
static const float ALBEDO_LEAST = 0.02f;

enum {
    HALVES = 2,
    TILE = 64,                    // pixels that are filtered together, in each direction
    MARGIN = SEARCH + PATCH + 3,  // three for the variance
    EXTENT = TILE + 2 * MARGIN,   // pixels that are read for a tile
    PIXELS_READ = EXTENT * EXTENT,
    COMPARED = TILE + 2 * PATCH,  // pixels that are compared for one offset
    PATCH_SIDE = 2 * PATCH + 1
};

// One half of the samples: planes of EXTENT rows.
struct half_plane {
    float light[NOISY_LAYERS][3][PIXELS_READ];  // weighted sums over the albedo
    float weight[NOISY_LAYERS][PIXELS_READ];    // of the samples that have such light
    float E[3][PIXELS_READ];                    // the mean
    float variance[3][PIXELS_READ];
};

struct noise_tile {
    struct half_plane half[HALVES];
    float albedo[3][PIXELS_READ], normal[3][PIXELS_READ];
    float inverse[PIXELS_READ];                        // of the distance; 0: no surface
    float slope_x[PIXELS_READ], slope_y[PIXELS_READ];  // its change from pixel to pixel
    bool has[NOISY_LAYERS];               // whether some pixel has samples of the layer
    bool sampled[PIXELS_READ], complete;  // whether a pixel has samples, and whether all have
    // The variance of one unit of weight in one channel, by single pixels and by 3 x 3 pixels.
    float spread[PIXELS_READ], around[PIXELS_READ];
    // The pixels that are filtered, row by row: how far surfaces differ, and weighted sums over
    // what is similar.
    float surface[TILE * TILE], sum[NOISY_LAYERS][3][TILE * TILE];
    float weight[NOISY_LAYERS][TILE * TILE];
    float difference[COMPARED * COMPARED];
    float row[COMPARED * TILE];  // sums of PATCH_SIDE of these
};

bool render_noise_filter_on(const satin_options *o) {
    return o->noise_filter && o->integrator == SATIN_TWO_PASS && !o->denoise;
}

// ---- What is compared ---------------------------------------------------------------------------

static rgb mean_albedo(const struct image_noisy *noisy, float scale) {
    const rgb albedo = rgb_scale(noisy->shown.albedo, scale);
    return rgb_make(maxf(albedo.r, ALBEDO_LEAST), maxf(albedo.g, ALBEDO_LEAST),
                    maxf(albedo.b, ALBEDO_LEAST));
}

// The sum of a layer over all samples.
static rgb sum_of(const struct render_image *image, size_t at, enum noisy_layer layer) {
    return layer == NOISY_DIRECT ? image->pixel[at].layer[SHADE_DIRECT]
                                 : image->noisy_light[at].glossy;
}

static float weight_of(const struct render_image *image, size_t at, enum noisy_layer layer) {
    return layer == NOISY_DIRECT ? image->pixel[at].weight : image->noisy_light[at].sampled;
}

static void read_half(struct half_plane *half, size_t i, enum noisy_layer layer, rgb light,
                      rgb albedo) {
    const bool usable = half->weight[layer][i] > 0.0f;
    half->light[layer][0][i] = usable ? light.r / albedo.r : 0.0f;
    half->light[layer][1][i] = usable ? light.g / albedo.g : 0.0f;
    half->light[layer][2][i] = usable ? light.b / albedo.b : 0.0f;
}

// `first`: the half that gets the even samples.
static void read_pixel(struct noise_tile *t, size_t i, const struct render_image *image, size_t at,
                       int first) {
    const struct image_pixel *p = &image->pixel[at];
    const struct image_noisy *noisy = &image->noisy_light[at];
    const float scale = render_image_scale(p);
    const rgb albedo = mean_albedo(noisy, scale), *n = &noisy->shown.normal;
    const float odd_weight[NOISY_LAYERS] = {noisy->weight, noisy->odd_sampled};
    for (enum noisy_layer layer = 0; layer < NOISY_LAYERS; layer++) {
        const rgb odd = noisy->odd[layer];
        const float all = weight_of(image, at, layer);
        struct half_plane *even_half = &t->half[first], *odd_half = &t->half[1 - first];
        even_half->weight[layer][i] = maxf(all - odd_weight[layer], 0.0f);
        odd_half->weight[layer][i] = maxf(odd_weight[layer], 0.0f);
        if (all != 0.0f) t->has[layer] = true;
        read_half(even_half, i, layer, rgb_sub(sum_of(image, at, layer), odd), albedo);
        read_half(odd_half, i, layer, odd, albedo);
    }
    t->albedo[0][i] = albedo.r;
    t->albedo[1][i] = albedo.g;
    t->albedo[2][i] = albedo.b;
    t->normal[0][i] = n->r * scale;
    t->normal[1][i] = n->g * scale;
    t->normal[2][i] = n->b * scale;
    const float distance = noisy->shown.depth * scale;
    t->inverse[i] = distance > FLT_MIN ? 1.0f / distance : 0.0f;
}

static int clamp_to(int x, int end) { return x < 0 ? 0 : x < end ? x : end - 1; }

// Whether all pixels that are read have samples. Beyond the image its border goes on.
static bool is_complete(const struct render_image *image, int x0, int y0) {
    for (int y = 0; y < EXTENT; y++)
        for (int x = 0; x < EXTENT; x++) {
            const int from_x = clamp_to(x0 + x - MARGIN, image->width),
                      from_y = clamp_to(y0 + y - MARGIN, image->height);
            if (!image->pixel[(size_t)from_y * (size_t)image->width + (size_t)from_x].samples)
                return false;
        }
    return true;
}

// The first samples of neighbours are in different halves (render_noise_add). Those of a coarser
// grid would all be in one: by all bits of the columns and rows they alternate there, too.
static int first_half(int x, int y) { return __builtin_parity((unsigned)(x ^ y) >> 1); }

// A pixel without samples looks like the one whose values it shows.
static void read_tile(struct noise_tile *t, const struct render_image *image, int x0, int y0) {
    memset(t->has, 0, sizeof t->has);
    t->complete = is_complete(image, x0, y0);
    for (int y = 0; y < EXTENT; y++)
        for (int x = 0; x < EXTENT; x++) {
            const int from_x = clamp_to(x0 + x - MARGIN, image->width),
                      from_y = clamp_to(y0 + y - MARGIN, image->height);
            const size_t i = (size_t)(y * EXTENT + x),
                         at = (size_t)from_y * (size_t)image->width + (size_t)from_x;
            t->sampled[i] = image->pixel[at].samples > 0;
            const struct image_pixel *shown =
                t->sampled[i] ? &image->pixel[at] : render_image_source(image, from_x, from_y);
            const size_t from = shown ? (size_t)(shown - image->pixel) : at;
            const int column = (int)(from % (size_t)image->width),
                      row = (int)(from / (size_t)image->width);
            read_pixel(t, i, image, from, t->complete ? 0 : first_half(column, row));
        }
}

// Leaves the light of pixels that have samples.
static void drop_unsampled(struct noise_tile *t) {
    for (size_t i = 0; i < PIXELS_READ; i++) {
        if (t->sampled[i]) continue;
        for (int h = 0; h < HALVES; h++)
            for (int layer = 0; layer < NOISY_LAYERS; layer++) {
                t->half[h].weight[layer][i] = 0.0f;
                for (int c = 0; c < 3; c++) t->half[h].light[layer][c][i] = 0.0f;
            }
    }
}

// The smaller one of the changes to both sides, as one of them may cross an edge.
static float distance_slope(const float *inverse, int step) {
    const float before = inverse[0] - inverse[-step], after = inverse[step] - inverse[0];
    return fabsf(before) < fabsf(after) ? before : after;
}

static void set_slopes(struct noise_tile *t) {
    for (int y = 1; y < EXTENT - 1; y++)
        for (int i = y * EXTENT + 1; i < (y + 1) * EXTENT - 1; i++) {
            t->slope_x[i] = distance_slope(&t->inverse[i], 1);
            t->slope_y[i] = distance_slope(&t->inverse[i], EXTENT);
        }
}

// Gloss of the samples that have some, beside direct light.
static float mean_of_channel(const struct half_plane *half, int c, size_t i) {
    const float sampled = half->weight[NOISY_GLOSSY][i];
    return half->light[NOISY_DIRECT][c][i] / half->weight[NOISY_DIRECT][i] +
           (sampled > 0.0f ? half->light[NOISY_GLOSSY][c][i] / sampled : 0.0f);
}

// The mean of a pixel without samples in this half is that of its neighbours or, as the last
// resort, of the other half.
static float mean_beside(const struct half_plane *half, const struct half_plane *other, int c,
                         size_t i) {
    const size_t around[4] = {i - 1, i + 1, i - EXTENT, i + EXTENT};
    float sum = 0.0f, weight = 0.0f;
    for (int k = 0; k < 4; k++) {
        const float beside = half->weight[NOISY_DIRECT][around[k]];
        if (beside > 0.0f) sum += beside * mean_of_channel(half, c, around[k]);
        weight += beside;
    }
    if (weight > 0.0f) return sum / weight;
    return other->weight[NOISY_DIRECT][i] > 0.0f ? mean_of_channel(other, c, i) : 0.0f;
}

static void set_means(struct half_plane *half, const struct half_plane *other, int c) {
    for (int y = 1; y < EXTENT - 1; y++)
        for (size_t i = (size_t)(y * EXTENT + 1); i < (size_t)((y + 1) * EXTENT - 1); i++)
            half->E[c][i] = half->weight[NOISY_DIRECT][i] > 0.0f ? mean_of_channel(half, c, i)
                                                                 : mean_beside(half, other, c, i);
}

// Whether the mean of a half comes from its own samples, there or beside.
static bool has_mean(const struct half_plane *half, size_t i) {
    const float *weight = &half->weight[NOISY_DIRECT][i];
    return *weight > 0.0f || weight[-1] > 0.0f || weight[1] > 0.0f || weight[-EXTENT] > 0.0f ||
           weight[EXTENT] > 0.0f;
}

// The variance of one unit of weight is known by how far both halves differ. A half without samples
// counts like one sample. It is UNKNOWN amid the pixels that show one of a coarser grid, where the
// halves would not differ.
static const float UNKNOWN = -1.0f;

static void set_spread(struct noise_tile *t, int c) {
    const struct half_plane *a = &t->half[0], *b = &t->half[1];
    for (int y = 1; y < EXTENT - 1; y++)
        for (int i = y * EXTENT + 1; i < (y + 1) * EXTENT - 1; i++) {
            const float of_a =
                            a->weight[NOISY_DIRECT][i] > 0.0f ? a->weight[NOISY_DIRECT][i] : 1.0f,
                        of_b =
                            b->weight[NOISY_DIRECT][i] > 0.0f ? b->weight[NOISY_DIRECT][i] : 1.0f;
            t->spread[i] = sqrf(a->E[c][i] - b->E[c][i]) * (of_a * of_b / (of_a + of_b));
            if (!t->complete && !(has_mean(a, (size_t)i) && has_mean(b, (size_t)i)))
                t->spread[i] = UNKNOWN;
        }
}

static void set_around(struct noise_tile *t) {
    for (int y = 2; y < EXTENT - 2; y++)
        for (int i = y * EXTENT + 2; i < (y + 1) * EXTENT - 2; i++) {
            float sum = 0.0f, count = 0.0f;
            for (int row = -EXTENT; row <= EXTENT; row += EXTENT)
                for (int column = -1; column <= 1; column++) {
                    const float spread = t->spread[i + row + column];
                    sum += spread < 0.0f ? 0.0f : spread;
                    count += spread < 0.0f ? 0.0f : 1.0f;
                }
            t->around[i] = count > 0.0f ? sum / count : UNKNOWN;
        }
}

// Two values alone say little, so the variance is that of 3 x 3 pixels: of those with the pixel in
// the middle or at a corner the quietest. What is quiet beside a noisy highlight then stays so.
// Where none is known, noise is as large as the light.
static void set_variances(struct noise_tile *t, int c) {
    static const int corner[4] = {-EXTENT - 1, -EXTENT + 1, EXTENT - 1, EXTENT + 1};
    set_around(t);
    for (int y = 3; y < EXTENT - 3; y++)
        for (int i = y * EXTENT + 3; i < (y + 1) * EXTENT - 3; i++) {
            float least = t->around[i] < 0.0f ? INFINITY : t->around[i];
            for (int k = 0; k < 4; k++) {
                const float there = t->around[i + corner[k]];
                least = there < 0.0f ? least : minf(least, there);
            }
            if (!(least < INFINITY)) least = sqrf(t->half[0].E[c][i]);
            for (int h = 0; h < HALVES; h++) {
                const float weight = t->half[h].weight[NOISY_DIRECT][i];
                t->half[h].variance[c][i] = least / (weight > 0.0f ? weight : 1.0f);
            }
        }
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

static rgb change_of(const struct noise_tile *t, const struct render_image *image, int i, size_t at,
                     enum noisy_layer layer) {
    const struct image_pixel *p = &image->pixel[at];
    if (!p->samples || !(t->weight[layer][i] > 0.0f)) return rgb_grey(0.0f);
    const float(*sum)[TILE * TILE] = t->sum[layer];
    const float fraction = weight_of(image, at, layer) * render_image_scale(p);
    const rgb E =
        rgb_scale(rgb_make(sum[0][i], sum[1][i], sum[2][i]), fraction / t->weight[layer][i]);
    const rgb own = rgb_scale(sum_of(image, at, layer), render_image_scale(p));
    const rgb change =
        rgb_sub(rgb_mul(E, mean_albedo(&image->noisy_light[at], render_image_scale(p))), own);
    return rgb_finite(change) ? change : rgb_grey(0.0f);
}

static void filter_tile(struct noise_tile *t, struct render_image *image, int x0, int y0) {
    read_tile(t, image, x0, y0);
    set_slopes(t);
    for (int c = 0; c < 3; c++) {
        for (int h = 0; h < HALVES; h++) set_means(&t->half[h], &t->half[1 - h], c);
        set_spread(t, c);
        set_variances(t, c);
    }
    if (!t->complete) drop_unsampled(t);
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
                add_similar(t, &t->half[h], offset, range_inside(y0, dy, image->height),
                            range_inside(x0, dx, image->width), near);
            }
        }
    for (int y = y0; y < y0 + TILE && y < image->height; y++)
        for (int x = x0; x < x0 + TILE && x < image->width; x++) {
            const size_t at = (size_t)y * (size_t)image->width + (size_t)x;
            for (enum noisy_layer layer = 0; layer < NOISY_LAYERS; layer++)
                image->change[at].layer[layer] =
                    change_of(t, image, (y - y0) * TILE + x - x0, at, layer);
        }
}

struct noise_filter {
    struct render_image *image;
    struct noise_tile *tile;  // one for each worker
    size_t columns;
};

static void filter_tiles(void *ctx, size_t begin, size_t end, int worker) {
    const struct noise_filter *f = ctx;
    for (size_t i = begin; i < end; i++)
        filter_tile(&f->tile[worker], f->image, (int)(i % f->columns) * TILE,
                    (int)(i / f->columns) * TILE);
}

bool render_noise_change(struct render_image *image, struct parallel *pool) {
    struct noise_filter f = {.image = image, .columns = ((size_t)image->width + TILE - 1) / TILE};
    const size_t rows = ((size_t)image->height + TILE - 1) / TILE;
    f.tile = array_new((size_t)parallel_threads(pool), sizeof *f.tile);
    if (!f.tile) return false;
    parallel_for_all(pool, f.columns * rows, 1, filter_tiles, &f);
    free(f.tile);
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
            trial->pixel[i].weight = 1.0f;
            trial->noisy_light[i].sampled = 1.0f;
        }
        const double start = stats_thread();
        filter_tile(tile, trial, 0, 0);
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
