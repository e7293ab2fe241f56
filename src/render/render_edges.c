// SPDX-License-Identifier: Apache-2.0
// Edges of surfaces in the image. Of a pixel that an edge crosses, a few samples do not show how
// much each surface covers, although an eye ray for the surface alone costs a small fraction of a
// sample. So such pixels have many of these rays, and where the surfaces that the samples have met
// differ from these in the mean, light is added for the difference: by a linear regression of light
// on surfaces over the pixels around. As these are other samples, the expected value stays.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "render/render_image.h"

// The constants are measured in docs/experiments/edges.md.
enum {
    RADIUS = 3,  // of the pixels of a regression
    REGRESSION_MOST = (2 * RADIUS + 1) * (2 * RADIUS + 1) - 1,
    REGRESSORS = 7,    // albedo, normal, depth
    LIGHT_LAYERS = 4,  // those before SHADE_EMISSION
    VALUES = 3 * LIGHT_LAYERS,
    RAYS_PER_SAMPLE = 8,  // up to RAYS_PLENTY rays, from which on there are RAYS_ALWAYS
    RAYS_PLENTY = 64,
    RAYS_ALWAYS = 2,
    RAYS_MOST = 1024,
    EDGES_TIMED = 512,  // pixels that show how long one takes
    EDGES_CHUNK = 64,   // pixels per chunk
    ROWS_CHUNK = 8
};

// Surfaces are alike if no channel of albedo or normal differs by more than this, and the depth not
// by more than this fraction.
static const float EDGE_ALIKE = 0.1f;
// Added to the variance of each regressor, relative to it.
static const float RIDGE = 0.1f;
// A regressor that deviates by less than this does not vary; of depth, relative to it.
static const float VARIES_LEAST = 1e-3f;
// A regression counts as far as it explains more than this many times what noise would.
static const float EXPLAINED_LEAST = 4.0f;
// Fraction of a time limit that edges take if there are enough rays, and at most twice of it. It is
// planned again when there are so many times the samples.
static const double EDGES_FRACTION = 0.05, PLAN_AGAIN = 1.25;

struct layer_change {
    rgb layer[LIGHT_LAYERS];
};
_Static_assert(sizeof(struct layer_change) + sizeof(uint32_t) <= RENDER_EDGES_BYTES, "memory");

struct surface_edges {
    struct render *r;
    uint32_t *pixel;  // y * width + x, row by row
    uint32_t *found;  // number of them in each row
    struct layer_change *change;
    size_t count;
    uint32_t rays_per_sample;
};

static size_t image_pixels(const struct render_image *image) {
    return (size_t)image->width * (size_t)image->height;
}

// ---- Where edges are ----------------------------------------------------------------------------

static struct shade_surface mean_surface(const struct image_pixel *pixel) {
    const float scale = render_image_scale(pixel);
    return (struct shade_surface){.albedo = rgb_scale(pixel->layer[SHADE_ALBEDO], scale),
                                  .normal = rgb_scale(pixel->layer[SHADE_NORMAL], scale),
                                  .depth = pixel->depth * scale};
}

static float most_difference(rgb a, rgb b) {
    return maxf(maxf(fabsf(a.r - b.r), fabsf(a.g - b.g)), fabsf(a.b - b.b));
}

static bool alike(const struct shade_surface *a, const struct shade_surface *b) {
    return most_difference(a->albedo, b->albedo) <= EDGE_ALIKE &&
           most_difference(a->normal, b->normal) <= EDGE_ALIKE &&
           fabsf(a->depth - b->depth) <= EDGE_ALIKE * maxf(a->depth, b->depth);
}

static bool is_edge(const struct render_image *image, int x, int y) {
    const size_t at = (size_t)y * (size_t)image->width + (size_t)x;
    const struct shade_surface own = mean_surface(&image->pixel[at]);
    if (!image->pixel[at].samples) return false;
    for (int i = 0; i < 9; i++) {
        const int u = x + i % 3 - 1, v = y + i / 3 - 1;
        if (u < 0 || u >= image->width || v < 0 || v >= image->height) continue;
        const struct image_pixel *other =
            &image->pixel[(size_t)v * (size_t)image->width + (size_t)u];
        const struct shade_surface surface = mean_surface(other);
        if (other->samples && !alike(&own, &surface)) return true;
    }
    return false;
}

// Stores the pixels of each row from the index on at which the row begins.
static void search_edge_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct surface_edges *e = ctx;
    const struct render_image *image = e->r->image;
    const size_t width = (size_t)image->width;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (size_t x = 0; x < width; x++)
            if (is_edge(image, (int)x, (int)y))
                e->pixel[y * width + e->found[y]++] = (uint32_t)(y * width + x);
}

static void find_edges(struct surface_edges *e) {
    const size_t width = (size_t)e->r->image->width, height = (size_t)e->r->image->height;
    parallel_for_all(e->r->pool, height, ROWS_CHUNK, search_edge_rows, e);
    for (size_t y = 0; y < height; y++) {
        memmove(e->pixel + e->count, e->pixel + y * width, e->found[y] * sizeof *e->pixel);
        e->count += e->found[y];
    }
}

// ---- Regression ---------------------------------------------------------------------------------

struct regression {
    int count;
    float weight[REGRESSION_MOST], x[REGRESSION_MOST][REGRESSORS], y[REGRESSION_MOST][VALUES];
    float sum, x_mean[REGRESSORS], y_mean[VALUES];
    float least[VALUES], most[VALUES];
    float scale[REGRESSORS];          // one over the deviation; 0: it does not vary
    float a[REGRESSORS][REGRESSORS];  // correlations
    float b[REGRESSORS][VALUES];      // with the values
    float slope[REGRESSORS][VALUES];  // of values by scaled regressors
};

static void put_surface(const struct shade_surface *s, float x[REGRESSORS]) {
    const float all[REGRESSORS] = {s->albedo.r, s->albedo.g, s->albedo.b, s->normal.r,
                                   s->normal.g, s->normal.b, s->depth};
    memcpy(x, all, sizeof all);
}

// The light of a pixel, layer by layer.
static void put_light(const struct render_image *image, size_t at, float y[VALUES]) {
    const struct image_pixel *p = &image->pixel[at];
    const float scale = render_image_scale(p);
    rgb light[LIGHT_LAYERS];
    for (int k = 0; k < LIGHT_LAYERS; k++) light[k] = rgb_scale(p->layer[k], scale);
    if (image->change) {
        const struct image_change *change = &image->change[at];
        light[SHADE_DIRECT] = rgb_add(light[SHADE_DIRECT], change->layer[NOISY_DIRECT]);
        light[SHADE_INDIRECT_GLOSSY] =
            rgb_add(light[SHADE_INDIRECT_GLOSSY], change->layer[NOISY_GLOSSY]);
    }
    for (int k = 0; k < LIGHT_LAYERS; k++) {
        y[3 * k] = light[k].r;
        y[3 * k + 1] = light[k].g;
        y[3 * k + 2] = light[k].b;
    }
}

static void read_neighbours(const struct render_image *image, size_t at, struct regression *g) {
    const int x = (int)(at % (size_t)image->width), y = (int)(at / (size_t)image->width);
    g->count = 0;
    for (int v = y - RADIUS; v <= y + RADIUS; v++)
        for (int u = x - RADIUS; u <= x + RADIUS; u++) {
            if (u < 0 || u >= image->width || v < 0 || v >= image->height) continue;
            const size_t from = (size_t)v * (size_t)image->width + (size_t)u;
            const struct image_pixel *pixel = &image->pixel[from];
            if (from == at || !pixel->samples) continue;
            const struct shade_surface surface = mean_surface(pixel);
            put_surface(&surface, g->x[g->count]);
            put_light(image, from, g->y[g->count]);
            g->weight[g->count++] = (float)pixel->samples;
        }
}

static void take_means(struct regression *g) {
    g->sum = 0.0f;
    memset(g->x_mean, 0, sizeof g->x_mean);
    memset(g->y_mean, 0, sizeof g->y_mean);
    memcpy(g->least, g->y[0], sizeof g->least);
    memcpy(g->most, g->y[0], sizeof g->most);
    for (int i = 0; i < g->count; i++) {
        const float *x = g->x[i], *y = g->y[i], w = g->weight[i];
        g->sum += w;
        for (int k = 0; k < REGRESSORS; k++) g->x_mean[k] += w * x[k];
        for (int c = 0; c < VALUES; c++) {
            g->y_mean[c] += w * y[c];
            g->least[c] = minf(y[c], g->least[c]);
            g->most[c] = maxf(y[c], g->most[c]);
        }
    }
    for (int k = 0; k < REGRESSORS; k++) g->x_mean[k] /= g->sum;
    for (int c = 0; c < VALUES; c++) g->y_mean[c] /= g->sum;
}

// Subtracts the means, and scales the regressors.
static void normalize(struct regression *g) {
    float squares[REGRESSORS] = {0.0f};
    for (int i = 0; i < g->count; i++) {
        for (int c = 0; c < VALUES; c++) g->y[i][c] -= g->y_mean[c];
        for (int k = 0; k < REGRESSORS; k++) {
            g->x[i][k] -= g->x_mean[k];
            squares[k] += g->weight[i] * g->x[i][k] * g->x[i][k];
        }
    }
    for (int k = 0; k < REGRESSORS; k++) {
        const float least = VARIES_LEAST * (k == REGRESSORS - 1 ? g->x_mean[k] : 1.0f),
                    deviation = sqrtf(squares[k] / g->sum);
        g->scale[k] = deviation > least ? 1.0f / deviation : 0.0f;
    }
    for (int i = 0; i < g->count; i++)
        for (int k = 0; k < REGRESSORS; k++) g->x[i][k] *= g->scale[k];
}

static void correlate(struct regression *g) {
    memset(g->a, 0, sizeof g->a);
    memset(g->b, 0, sizeof g->b);
    for (int i = 0; i < g->count; i++)
        for (int k = 0; k < REGRESSORS; k++) {
            const float wx = g->weight[i] / g->sum * g->x[i][k];
            for (int l = 0; l < REGRESSORS; l++) g->a[k][l] += wx * g->x[i][l];
            for (int c = 0; c < VALUES; c++) g->b[k][c] += wx * g->y[i][c];
        }
}

// Solves (A + RIDGE) slope = B by the Cholesky decomposition.
static void solve(struct regression *g) {
    float c[REGRESSORS][REGRESSORS];
    for (int k = 0; k < REGRESSORS; k++)
        for (int l = 0; l <= k; l++) {
            float left = g->a[k][l] + (k == l ? RIDGE : 0.0f);
            for (int m = 0; m < l; m++) left -= c[k][m] * c[l][m];
            c[k][l] = k == l ? sqrtf(left) : left / c[l][l];
        }
    memcpy(g->slope, g->b, sizeof g->slope);
    for (int k = 0; k < REGRESSORS; k++) {
        for (int m = 0; m < k; m++)
            for (int v = 0; v < VALUES; v++) g->slope[k][v] -= c[k][m] * g->slope[m][v];
        for (int v = 0; v < VALUES; v++) g->slope[k][v] /= c[k][k];
    }
    for (int k = REGRESSORS - 1; k >= 0; k--) {
        for (int m = k + 1; m < REGRESSORS; m++)
            for (int v = 0; v < VALUES; v++) g->slope[k][v] -= c[m][k] * g->slope[m][v];
        for (int v = 0; v < VALUES; v++) g->slope[k][v] /= c[k][k];
    }
}

// Sets how far the regression of each layer counts, from 0 to 1: by its variance that the
// regressors explain, over what they would explain if it were noise.
static void find_reliance(const struct regression *g, float reliance[LIGHT_LAYERS]) {
    float squares = 0.0f, explained[VALUES] = {0.0f}, left[VALUES] = {0.0f};
    for (int i = 0; i < g->count; i++) {
        squares += sqrf(g->weight[i]);
        for (int c = 0; c < VALUES; c++) left[c] += g->weight[i] / g->sum * sqrf(g->y[i][c]);
    }
    for (int k = 0; k < REGRESSORS; k++) {
        float predicted[VALUES] = {0.0f};
        for (int l = 0; l < REGRESSORS; l++)
            for (int c = 0; c < VALUES; c++) predicted[c] += g->a[k][l] * g->slope[l][c];
        for (int c = 0; c < VALUES; c++) {
            explained[c] += g->slope[k][c] * predicted[c];
            left[c] += g->slope[k][c] * (predicted[c] - 2.0f * g->b[k][c]);
        }
    }
    // The number of pixels that would be as many if all had equal weights.
    const float n = maxf(sqrf(g->sum) / squares, REGRESSORS + 2.0f);
    for (int k = 0; k < LIGHT_LAYERS; k++) {
        const float whole = explained[3 * k] + explained[3 * k + 1] + explained[3 * k + 2],
                    noise = maxf(left[3 * k] + left[3 * k + 1] + left[3 * k + 2], 0.0f) *
                            REGRESSORS / (n - REGRESSORS - 1.0f);
        reliance[k] = whole > 0.0f ? maxf(1.0f - EXPLAINED_LEAST * noise / whole, 0.0f) : 0.0f;
    }
}

// ---- The change of a pixel ----------------------------------------------------------------------

// The number of rays of a pixel, a power of two, so that they are distributed well.
static uint32_t count_edge_rays(const struct surface_edges *e, uint32_t samples) {
    const uint32_t least = (uint32_t)e->r->options.edge_rays, few = e->rays_per_sample * samples;
    uint32_t wanted = few < RAYS_PLENTY ? few : RAYS_PLENTY, rays = 1;
    if (wanted < RAYS_ALWAYS * samples) wanted = RAYS_ALWAYS * samples;
    while (rays < least || (rays < wanted && rays < RAYS_MOST)) rays *= 2;
    return rays;
}

// The mean of the surfaces that the pixel's rays see, by the filter's weights.
static struct shade_surface trace_surfaces(const struct surface_edges *e, size_t at) {
    const size_t width = (size_t)e->r->image->width;
    struct shade_surface sum = {0};
    float weights = 0.0f;
    const uint32_t rays = count_edge_rays(e, e->r->image->pixel[at].samples);
    for (uint32_t k = 0; k < rays; k++) {
        struct shade_surface s;
        const float weight =
            render_usable_weight(weights, k,
                                 shade_find_surface(&e->r->second_pass.shade, (int)(at % width),
                                                    (int)(at / width), k, &s));
        sum.albedo = rgb_mad(sum.albedo, s.albedo, weight);
        sum.normal = rgb_mad(sum.normal, s.normal, weight);
        sum.depth += s.depth * weight;
        weights += weight;
    }
    const float scale = 1.0f / weights;
    return (struct shade_surface){rgb_scale(sum.albedo, scale), rgb_scale(sum.normal, scale),
                                  sum.depth * scale};
}

// Sets the change, so that each value stays among those of the pixel and of its neighbours.
static void change_pixel(const struct render_image *image, size_t at, const struct regression *g,
                         const struct shade_surface *found, struct layer_change *out) {
    float own[VALUES], met[REGRESSORS], x[REGRESSORS], change[VALUES] = {0.0f},
                                                       reliance[LIGHT_LAYERS];
    const struct shade_surface samples = mean_surface(&image->pixel[at]);
    put_light(image, at, own);
    put_surface(&samples, met);
    put_surface(found, x);
    find_reliance(g, reliance);
    for (int k = 0; k < REGRESSORS; k++)
        for (int c = 0; c < VALUES; c++)
            change[c] += (x[k] - met[k]) * g->scale[k] * g->slope[k][c];
    for (int c = 0; c < VALUES; c++) {
        const float least = minf(own[c], g->least[c]), most = maxf(own[c], g->most[c]),
                    changed = own[c] + reliance[c / 3] * change[c];
        change[c] = isfinite(changed) ? minf(maxf(changed, least), most) - own[c] : 0.0f;
    }
    for (int k = 0; k < LIGHT_LAYERS; k++)
        out->layer[k] = rgb_make(change[3 * k], change[3 * k + 1], change[3 * k + 2]);
}

static void change_edges(void *ctx, size_t begin, size_t end, int worker) {
    const struct surface_edges *e = ctx;
    const struct render_image *image = e->r->image;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct regression g;
        const size_t at = e->pixel[i];
        read_neighbours(image, at, &g);
        if (g.count <= REGRESSORS + 1) continue;
        const struct shade_surface found = trace_surfaces(e, at);
        take_means(&g);
        normalize(&g);
        correlate(&g);
        solve(&g);
        change_pixel(image, at, &g, &found, &e->change[i]);
    }
}

static void apply_changes(const struct surface_edges *e) {
    for (size_t i = 0; i < e->count; i++) {
        struct image_pixel *pixel = &e->r->image->pixel[e->pixel[i]];
        for (int k = 0; k < LIGHT_LAYERS; k++) {
            const rgb change = rgb_scale(e->change[i].layer[k], pixel->weight);
            if (!rgb_finite(change)) continue;
            pixel->beauty = rgb_add(pixel->beauty, change);
            pixel->layer[k] = rgb_add(pixel->layer[k], change);
        }
    }
}

bool render_edges_on(const satin_options *o) {
    return o->edge_rays > 0 && o->integrator == SATIN_TWO_PASS && !o->denoise;
}

// ---- The image ----------------------------------------------------------------------------------

static void edges_destroy(struct surface_edges *e) {
    free(e->pixel);
    free(e->found);
    free(e->change);
}

// Finds the edges of the image. False if it is not to have any and, with *failed, if there is no
// memory.
static bool edges_make(struct surface_edges *e, struct render *r, bool *failed) {
    const size_t pixels = image_pixels(r->image);
    *e = (struct surface_edges){.r = r, .rays_per_sample = RAYS_PER_SAMPLE};
    *failed = false;
    if (!render_edges_on(&r->options) || r->image->taken < pixels) return false;
    parallel_begin_part(r->pool, "edges");
    e->pixel = array_new_unset(pixels, sizeof *e->pixel);
    e->found = array_new((size_t)r->image->height, sizeof *e->found);
    if (e->pixel && e->found) find_edges(e);
    e->change = array_new(e->count, sizeof *e->change);
    *failed = !e->pixel || !e->found || !e->change;
    if (*failed) edges_destroy(e);
    return !*failed;
}

static void time_edges(void *ctx, size_t begin, size_t end, int worker) {
    const struct surface_edges *e = ctx;
    const size_t step = e->count / EDGES_TIMED + 1;
    for (size_t i = begin; i < end; i++) change_edges(ctx, i * step, i * step + 1, worker);
}

// The time that all edges take, measured at some, whose changes are not applied.
static double edges_seconds(struct surface_edges *e) {
    const size_t step = e->count / EDGES_TIMED + 1, timed = e->count / step;
    const double start = stats_wall();
    parallel_for_all(e->r->pool, timed, EDGES_CHUNK / 8, time_edges, e);
    return (stats_wall() - start) * (double)step;
}

void render_edges_plan(struct render *r) {
    struct render_image *image = r->image;
    struct surface_edges e;
    bool failed;
    if (!(r->options.time > 0.0) || (double)image->taken < PLAN_AGAIN * image->edges_planned)
        return;
    image->edge_rays = 0;
    image->edge_seconds = 0.0;
    image->edges_planned = image->taken;
    if (!edges_make(&e, r, &failed)) return;
    // Up to twice as many samples will be there at the next plan, or at the end.
    const double more = fmax(render_time_left(r), 0.0) / image->sample_seconds,
                 growth = fmin(1.0 + more / (double)image->taken, 2.0),
                 most = EDGES_FRACTION * r->options.time;
    double seconds = growth * render_agreed(r, edges_seconds(&e));
    while (seconds > most && e.rays_per_sample > 1) {
        e.rays_per_sample /= 2;
        seconds = growth * render_agreed(r, edges_seconds(&e));
    }
    if (seconds <= 2.0 * most) {
        image->edge_rays = e.rays_per_sample;
        image->edge_seconds = seconds;
    }
    edges_destroy(&e);
}

bool render_edges(struct render *r) {
    struct surface_edges e;
    bool failed;
    if (r->options.time > 0.0 && !r->image->edge_rays) return true;
    if (!edges_make(&e, r, &failed)) return !failed;
    if (r->options.time > 0.0) e.rays_per_sample = r->image->edge_rays;
    parallel_for_all(r->pool, e.count, EDGES_CHUNK, change_edges, &e);
    apply_changes(&e);
    stats_set(&r->stats, "image.edge_pixels", (double)e.count);
    edges_destroy(&e);
    return true;
}
