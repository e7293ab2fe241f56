// SPDX-License-Identifier: Apache-2.0
// Edges of surfaces in the image. Of a pixel that an edge crosses, a few samples do not show how
// much each surface covers, although an eye ray for the surface alone costs a small fraction of a
// sample. So such pixels have many of these rays, and where the surfaces that the samples have met
// differ in the mean from those that all have, light is added for the difference: by a linear
// regression of light on surfaces over the pixels around. Whether a pixel is at an edge, and the
// regression, follow from other pixels alone, so the expected value stays. Mirrors and panes
// count as the surface that they show.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "render/render_edges.h"

// The constants are measured in docs/experiments/edges.md.
enum {
    RADIUS = 3,           // of the pixels of a regression
    EDGE_NEAR = 2,        // of those that show whether there is an edge
    RAYS_PER_SAMPLE = 2,  // at least
    RAYS_MOST = 1024,     // a pixel with as many samples has no rays
    COMPARE_CHUNK = 2048
};

// Set beside the directions in which a pixel differs: its rays see shapes that are not alike.
enum { CROSSED = 1 << 4 };

_Static_assert((2 * RADIUS + 1) * (2 * RADIUS + 1) - 1 <= REGRESSION_MOST, "pixels around");

// Pixels of a regression count by a Gaussian of their distance, of this standard deviation: light
// near other edges follows surfaces in another way.
static const float NEAR_DEVIATION = 1.5f;
// No light follows from a surface that differs by less than this.
static const float EDGE_NONE = 1e-4f;
// The light of a pixel that goes at most, so that rounding makes none negative.
static const float ALMOST_ALL = 1.0f - 1e-5f;
// ---- Where edges are ----------------------------------------------------------------------------

static struct shade_surface scale_surface(const struct shade_surface *s, float scale) {
    return (struct shade_surface){rgb_scale(s->albedo, scale), rgb_scale(s->normal, scale),
                                  s->depth * scale, s->alpha * scale};
}

static struct shade_surface mean_first(const struct image_pixel *pixel) {
    const struct shade_surface sum = {pixel->layer[SHADE_ALBEDO], pixel->layer[SHADE_NORMAL],
                                      pixel->depth, pixel->alpha};
    return scale_surface(&sum, render_image_scale(pixel));
}

// The mean of what the first surfaces show, if the filter of noise has it.
static struct shade_surface mean_shown(const struct render_image *image, size_t at) {
    const struct image_pixel *pixel = &image->pixel[at];
    if (!image->noisy_light) return mean_first(pixel);
    struct shade_surface sum = image->noisy_light[at].shown;
    sum.alpha = pixel->alpha;
    return scale_surface(&sum, render_image_scale(pixel));
}

static float most_difference(rgb a, rgb b) {
    return maxf(maxf(fabsf(a.r - b.r), fabsf(a.g - b.g)), fabsf(a.b - b.b));
}

static bool alike(const struct shade_surface *a, const struct shade_surface *b, float most) {
    return most_difference(a->albedo, b->albedo) <= most &&
           most_difference(a->normal, b->normal) <= most && fabsf(a->alpha - b->alpha) <= most &&
           fabsf(a->depth - b->depth) <= most * maxf(a->depth, b->depth);
}

enum { FORWARDS = 4 };  // directions in which each pair of neighbours is
static const int FORWARD[FORWARDS][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};

static bool in_image(const struct render_image *image, int x, int y) {
    return x >= 0 && x < image->width && y >= 0 && y < image->height;
}

static size_t index_at(const struct render_image *image, int x, int y) {
    return (size_t)y * (size_t)image->width + (size_t)x;
}

static void compare_neighbours(void *ctx, size_t begin, size_t end, int worker) {
    const struct surface_edges *e = ctx;
    const struct render_image *image = e->r->image;
    (void)worker;
    for (size_t at = begin; at < end; at++) {
        const int x = (int)(at % (size_t)image->width), y = (int)(at / (size_t)image->width);
        const struct shade_surface own = mean_shown(image, at);
        e->differs[at] = 0;
        for (int i = 0; i < FORWARDS && image->pixel[at].samples; i++) {
            const int u = x + FORWARD[i][0], v = y + FORWARD[i][1];
            if (!in_image(image, u, v)) continue;
            const size_t other = index_at(image, u, v);
            const struct shade_surface surface = mean_shown(image, other);
            if (image->pixel[other].samples && !alike(&own, &surface, e->alike))
                e->differs[at] |= (uint8_t)(1 << i);
        }
    }
}

// Whether pixel (u, v) differs from a neighbour forward of it that is near pixel (x, y), but not
// that pixel itself.
static bool differs_beside(uint8_t bits, int u, int v, int x, int y) {
    for (int i = 0; i < FORWARDS; i++) {
        const int dx = u + FORWARD[i][0] - x, dy = v + FORWARD[i][1] - y;
        if (bits >> i & 1 && abs(dx) <= EDGE_NEAR && dy <= EDGE_NEAR && (dx || dy)) return true;
    }
    return false;
}

// Whether two neighbours near the pixel differ. If its own samples decided, those of which the
// surface is rare would be corrected more often, and it would vanish.
static bool is_edge(const void *ctx, size_t at) {
    const struct surface_edges *e = ctx;
    const struct render_image *image = e->r->image;
    const int x = (int)(at % (size_t)image->width), y = (int)(at / (size_t)image->width);
    const uint32_t samples = image->pixel[at].samples;
    if (!samples || samples >= RAYS_MOST) return false;
    for (int v = y - EDGE_NEAR; v <= y + EDGE_NEAR; v++)
        for (int u = x - EDGE_NEAR; u <= x + EDGE_NEAR; u++) {
            if (!in_image(image, u, v) || (u == x && v == y)) continue;
            const uint8_t bits = e->differs[index_at(image, u, v)];
            if (bits && differs_beside(bits, u, v, x, y)) return true;
        }
    return false;
}

// ---- Regression ---------------------------------------------------------------------------------

static void put_surface(const struct shade_surface *s, float x[REGRESSORS]) {
    const float all[REGRESSORS] = {s->albedo.r, s->albedo.g, s->albedo.b, s->normal.r,
                                   s->normal.g, s->normal.b, s->depth,    s->alpha};
    memcpy(x, all, sizeof all);
}

// The light of a pixel, layer by layer, as filters leave it.
static void put_light(const struct render_image *image, size_t at, float y[REGRESSION_VALUES]) {
    const struct image_pixel *p = &image->pixel[at];
    const float scale = render_image_scale(p);
    rgb light[REGRESSION_LAYERS];
    for (int k = 0; k < REGRESSION_LAYERS; k++) light[k] = rgb_scale(p->layer[k], scale);
    if (image->irradiance)
        light[SHADE_INDIRECT_DIFFUSE] =
            rgb_add(light[SHADE_INDIRECT_DIFFUSE], image->irradiance[at]);
    if (image->change) {
        const struct image_change *change = &image->change[at];
        light[SHADE_DIRECT] = rgb_add(light[SHADE_DIRECT], change->layer[NOISY_DIRECT]);
        light[SHADE_INDIRECT_GLOSSY] =
            rgb_add(light[SHADE_INDIRECT_GLOSSY], change->layer[NOISY_GLOSSY]);
    }
    for (int k = 0; k < REGRESSION_LAYERS; k++) {
        y[3 * k] = light[k].r;
        y[3 * k + 1] = light[k].g;
        y[3 * k + 2] = light[k].b;
    }
}

static float near_weight(int dx, int dy) {
    return expf(-0.5f / sqrf(NEAR_DEVIATION) * (float)(dx * dx + dy * dy));
}

static void read_neighbours(const struct render_image *image, size_t at, struct regression *g) {
    const int x = (int)(at % (size_t)image->width), y = (int)(at / (size_t)image->width);
    g->count = 0;
    for (int v = y - RADIUS; v <= y + RADIUS; v++)
        for (int u = x - RADIUS; u <= x + RADIUS; u++) {
            if (!in_image(image, u, v)) continue;
            const size_t from = index_at(image, u, v);
            const struct image_pixel *pixel = &image->pixel[from];
            if (from == at || !pixel->samples) continue;
            const struct shade_surface surface = mean_shown(image, from);
            put_surface(&surface, g->x[g->count]);
            put_light(image, from, g->y[g->count]);
            g->weight[g->count++] = (float)pixel->samples * near_weight(u - x, v - y);
        }
}

// ---- Rays ---------------------------------------------------------------------------------------

// The number of rays of a pixel with so many samples, a power of two, so that they are distributed
// well.
uint32_t render_edge_rays(const struct surface_edges *e, double samples) {
    const double most = fmax(RAYS_PER_SAMPLE * samples, e->r->options.edge_rays);
    uint32_t rays = 1;
    while (rays < fmin(most, RAYS_MOST)) rays *= 2;
    rays >>= e->ray_shift;
    return rays ? rays : 1;
}

static bool same_shape(const struct shade_surface *a, const struct shade_surface *b) {
    struct shade_surface other = *b;
    other.albedo = a->albedo;
    return alike(a, &other, EDGE_ALIKE);
}

// The first surfaces of a pixel, and what they show.
struct pixel_surfaces {
    struct shade_surface first, shown;
};

static void add_surface(struct shade_surface *sum, const struct shade_surface *s, float weight) {
    sum->albedo = rgb_mad(sum->albedo, s->albedo, weight);
    sum->normal = rgb_mad(sum->normal, s->normal, weight);
    sum->depth += s->depth * weight;
    sum->alpha += s->alpha * weight;
}

// The means of the surfaces that the rays of a pixel see, by the filter's weights.
static struct pixel_surfaces trace_surfaces(const struct surface_edges *e, size_t at) {
    const struct render_image *image = e->r->image;
    const size_t width = (size_t)image->width;
    const struct shade *shade = &e->r->second_pass.shade;
    const uint32_t rays = render_edge_rays(e, image->pixel[at].samples);
    struct pixel_surfaces begin = {0}, sum = {0};
    float weights = 0.0f;
    for (uint32_t k = 0; k < rays; k++) {
        struct pixel_surfaces s;
        const float found = shade_find_surface(shade, (int)(at % width), (int)(at / width), k,
                                               &s.first, image->noisy_light ? &s.shown : NULL);
        if (!image->noisy_light) s.shown = s.first;
        const float weight = render_usable_weight(weights, k, found);
        if (k == 0) begin = s;
        if (!same_shape(&begin.shown, &s.shown)) e->differs[at] |= CROSSED;
        add_surface(&sum.first, &s.first, weight);
        add_surface(&sum.shown, &s.shown, weight);
        weights += weight;
    }
    return (struct pixel_surfaces){scale_surface(&sum.first, 1.0f / weights),
                                   scale_surface(&sum.shown, 1.0f / weights)};
}

// ---- The change of a pixel ----------------------------------------------------------------------

// What the mean over samples and rays differs by from that over samples alone. The variance of
// either falls as the power 1.5 of their number, where an edge crosses the pixel.
static struct shade_surface surface_change(const struct shade_surface *samples, uint32_t count,
                                           const struct shade_surface *found, uint32_t rays) {
    const float n = (float)count * sqrtf((float)count), m = (float)rays * sqrtf((float)rays);
    const float part = m / (n + m);
    return (struct shade_surface){rgb_scale(rgb_sub(found->albedo, samples->albedo), part),
                                  rgb_scale(rgb_sub(found->normal, samples->normal), part),
                                  part * (found->depth - samples->depth),
                                  part * (found->alpha - samples->alpha)};
}

static const int LAYER_OF[NOISY_LAYERS] = {
    [NOISY_DIRECT] = SHADE_DIRECT, [NOISY_GLOSSY] = SHADE_INDIRECT_GLOSSY};

// The part of what the filter of noise adds to a layer of a pixel that is not noise, but an error:
// it mixes the samples of a pixel that an edge crosses with those of pixels which have met its
// surfaces in other proportions. It is known by the light that the regression predicts for the
// surfaces that the samples have met: noise is farther from that than filtered light.
static rgb filter_error(const struct surface_edges *e, size_t at, const struct regression *g,
                        const float predicted[REGRESSION_VALUES],
                        const float own[REGRESSION_VALUES], enum noisy_layer layer) {
    const rgb added = e->r->image->change[at].layer[layer];
    const float by_channel[3] = {added.r, added.g, added.b};
    float with = 0.0f, without = 0.0f;
    for (int c = 0; c < 3; c++) {
        const int value = 3 * LAYER_OF[layer] + c;
        const float off = own[value] - g->y_mean[value] - predicted[value];
        with += sqrf(off);
        without += sqrf(off - by_channel[c]);
    }
    return with > without ? rgb_scale(added, 1.0f - without / with) : rgb_grey(0.0f);
}

// Subtracts the errors of the filter of noise from `own`, and sets the light of `out` to that
// change.
static void take_filter_back(const struct surface_edges *e, size_t at, const struct regression *g,
                             const struct shade_surface *met, float own[REGRESSION_VALUES],
                             struct pixel_change *out) {
    float dx[REGRESSORS], predicted[REGRESSION_VALUES];
    if (!e->r->image->change || !(e->differs[at] & CROSSED)) return;
    put_surface(met, dx);
    for (int k = 0; k < REGRESSORS; k++) dx[k] -= g->x_mean[k];
    render_regression_change(g, dx, predicted);
    for (enum noisy_layer layer = 0; layer < NOISY_LAYERS; layer++) {
        const rgb error = filter_error(e, at, g, predicted, own, layer);
        float *value = &own[3 * LAYER_OF[layer]];
        value[0] -= error.r;
        value[1] -= error.g;
        value[2] -= error.b;
        out->light[LAYER_OF[layer]] = rgb_scale(error, -1.0f);
    }
}

// Changes the light as the surfaces that are shown do. It does not leave the range of that of the
// pixels around, and is not negative.
static void change_light(const struct surface_edges *e, size_t at, const struct regression *g,
                         const struct shade_surface *met, const struct shade_surface *shown,
                         struct pixel_change *out) {
    float own[REGRESSION_VALUES], dx[REGRESSORS], around[REGRESSORS], change[REGRESSION_VALUES];
    put_light(e->r->image, at, own);
    take_filter_back(e, at, g, met, own, out);
    put_surface(shown, dx);
    render_regression_change(g, dx, change);
    for (int c = 0; c < REGRESSION_VALUES; c++) {
        const float all = -at_least(ALMOST_ALL * own[c], 0.0f);
        const float down = maxf(minf(g->least[c] - own[c], 0.0f), all),
                    up = maxf(g->most[c] - own[c], 0.0f);
        change[c] = isfinite(change[c]) ? clampf(change[c], down, up) : 0.0f;
    }
    for (int k = 0; k < REGRESSION_LAYERS; k++)
        out->light[k] =
            rgb_add(out->light[k], rgb_make(change[3 * k], change[3 * k + 1], change[3 * k + 2]));
    for (int c = 0; c < REGRESSION_VALUES; c++) own[c] += change[c];
    put_surface(met, around);
    for (int k = 0; k < REGRESSORS; k++) dx[k] += around[k] - g->x_mean[k];
    render_edges_quieten(e->r->image, at, g, dx, own, out);
}

// Finds the change of a pixel by its rays.
static void change_edge(const struct surface_edges *e, size_t at, struct pixel_change *change) {
    const struct render_image *image = e->r->image;
    const struct image_pixel *pixel = &image->pixel[at];
    const uint32_t samples = pixel->samples, rays = render_edge_rays(e, samples);
    const struct pixel_surfaces met = {mean_first(pixel), mean_shown(image, at)},
                                found = trace_surfaces(e, at);
    struct regression g;
    *change = (struct pixel_change){0};
    if (alike(&met.shown, &found.shown, EDGE_NONE)) return;
    read_neighbours(image, at, &g);
    if (g.count < REGRESSION_LEAST) return;
    change->surface = surface_change(&met.first, samples, &found.first, rays);
    const struct shade_surface shown = surface_change(&met.shown, samples, &found.shown, rays);
    render_regression_fit(&g);
    change_light(e, at, &g, &met.shown, &shown, change);
}

void render_edges_change(void *ctx, size_t begin, size_t end, int worker) {
    const struct surface_edges *e = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) change_edge(e, e->list.pixel[i], &e->change[i]);
}

static void change_sum(rgb *sum, rgb change, float weight) {
    change = rgb_scale(change, weight);
    if (rgb_finite(change)) *sum = rgb_add(*sum, change);
}

static void apply_changes(const struct surface_edges *e) {
    for (size_t i = 0; i < e->list.count; i++) {
        struct image_pixel *pixel = &e->r->image->pixel[e->list.pixel[i]];
        const struct pixel_change *change = &e->change[i];
        const float weight = pixel->weight;
        for (int k = 0; k < REGRESSION_LAYERS; k++) {
            change_sum(&pixel->beauty, change->light[k], weight);
            change_sum(&pixel->layer[k], change->light[k], weight);
        }
        change_sum(&pixel->layer[SHADE_ALBEDO], change->surface.albedo, weight);
        change_sum(&pixel->layer[SHADE_NORMAL], change->surface.normal, weight);
        pixel->depth += change->surface.depth * weight;
        pixel->alpha += change->surface.alpha * weight;
    }
}

bool render_edges_on(const satin_options *o) {
    return o->edge_rays > 0 && o->integrator == SATIN_TWO_PASS && !o->denoise;
}

// ---- The image ----------------------------------------------------------------------------------

void render_edges_destroy(struct surface_edges *e) {
    render_pixels_destroy(&e->list);
    free(e->differs);
    free(e->change);
}

void render_edges_find(struct surface_edges *e) {
    const size_t pixels = render_pixel_count(e->r->image);
    parallel_for_all(e->r->pool, pixels, COMPARE_CHUNK, compare_neighbours, e);
    render_pixels_find(&e->list, e->r, is_edge, e);
}

bool render_edges_make(struct surface_edges *e, struct render *r, bool *failed) {
    const size_t pixels = render_pixel_count(r->image);
    *e = (struct surface_edges){.r = r, .alike = EDGE_ALIKE};
    *failed = false;
    if (!render_edges_on(&r->options) || r->image->taken < pixels) return false;
    parallel_begin_part(r->pool, "edges");
    e->differs = array_new_unset(pixels, sizeof *e->differs);
    *failed = !e->differs || !render_pixels_make(&e->list, r->image);
    if (!*failed) {
        render_edges_find(e);
        e->change = array_new(e->list.count, sizeof *e->change);
        *failed = !e->change;
    }
    if (*failed) render_edges_destroy(e);
    return !*failed;
}

bool render_edges(struct render *r) {
    struct surface_edges e;
    bool failed;
    if (!render_edges_have_time(r)) return true;
    if (!render_edges_make(&e, r, &failed)) return !failed;
    render_edges_fit(&e);
    parallel_for_all(r->pool, e.list.count, EDGES_CHUNK, render_edges_change, &e);
    apply_changes(&e);
    stats_set(&r->stats, "image.edge_pixels", (double)e.list.count);
    render_edges_destroy(&e);
    return true;
}
