// SPDX-License-Identifier: Apache-2.0
// Reads the pixels that the filter of noise compares: two halves of their samples, with means and
// variances, and the surfaces that they show.
#include <float.h>
#include <string.h>

#include "render/render_noise_tile.h"

// Irradiance is light over albedo, which is at least this.
static const float ALBEDO_LEAST = 0.02f;

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
        const rgb odd = layer == NOISY_DIRECT ? noisy->odd[SHADE_DIRECT] : noisy->odd_glossy;
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

// Whether all pixels that are read have samples.
static bool is_complete(const struct noise_grid *g, int x0, int y0) {
    for (int y = 0; y < EXTENT; y++)
        for (int x = 0; x < EXTENT; x++)
            if (!g->image->pixel[render_noise_grid_pixel(g, x0 + x - MARGIN, y0 + y - MARGIN)]
                     .samples)
                return false;
    return true;
}

// The half that gets the even samples of a pixel, so that the first samples of neighbours are in
// different halves, as render_noise_add puts them in the finest grid; on a grid that is not
// complete also those of coarser ones, by all bits of columns and rows.
static int first_half(const struct noise_grid *g, size_t at, bool complete) {
    const unsigned column = (unsigned)(at % (size_t)g->image->width),
                   row = (unsigned)(at / (size_t)g->image->width), added = (column ^ row) & 1,
                   on_grid = (column ^ row) / (unsigned)g->stride;
    return (int)(added ^ (complete ? on_grid & 1 : (unsigned)__builtin_parity(on_grid)));
}

// A pixel without samples looks like the one whose values it shows.
static void read_tile(struct noise_tile *t, const struct noise_grid *g, int x0, int y0) {
    const struct render_image *image = g->image;
    const size_t width = (size_t)image->width;
    memset(t->has, 0, sizeof t->has);
    t->complete = is_complete(g, x0, y0);
    for (int y = 0; y < EXTENT; y++)
        for (int x = 0; x < EXTENT; x++) {
            const size_t i = (size_t)(y * EXTENT + x),
                         at = render_noise_grid_pixel(g, x0 + x - MARGIN, y0 + y - MARGIN);
            t->sampled[i] = image->pixel[at].samples > 0;
            const struct image_pixel *shown =
                t->sampled[i] ? &image->pixel[at]
                              : render_image_source(image, (int)(at % width), (int)(at / width));
            const size_t from = shown ? (size_t)(shown - image->pixel) : at;
            read_pixel(t, i, image, from, first_half(g, from, t->complete));
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

void render_noise_tile_read(struct noise_tile *t, const struct noise_grid *g, int x0, int y0) {
    read_tile(t, g, x0, y0);
    set_slopes(t);
    for (int c = 0; c < 3; c++) {
        for (int h = 0; h < HALVES; h++) set_means(&t->half[h], &t->half[1 - h], c);
        set_spread(t, c);
        set_variances(t, c);
    }
    if (!t->complete) drop_unsampled(t);
}

rgb render_noise_tile_change(const struct noise_tile *t, const struct render_image *image, int i,
                             size_t at, enum noisy_layer layer) {
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
