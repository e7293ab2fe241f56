// SPDX-License-Identifier: Apache-2.0
// Light that is seen directly. A lamp is tens of times as bright as the wall around it, so a few
// samples more or less that hit it make the pixels along its edge look jagged; and as adaptive
// sampling gives more samples to pixels that have met a lamp, their means are too dark where it is
// small. An eye ray for emitted light alone costs a small fraction of a sample. So the emission
// layer is the mean of the samples that are distributed equally, and of additional rays: a few in
// each pixel, whose number grows with that of the samples, and many where emission varies.
// render_highlights.c says how much the latter count where they were found by chance.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "render/render_rims.h"

enum {
    FIRST_CHUNK = 256,            // pixels per chunk of the rays of all pixels
    RIMS_CHUNK = 64,              // pixels per chunk of those at rims
    READ_CHUNK = 8192,            // those of which the emission is read
    RIM_RAYS_BEGIN = 0x40000000,  // index of the first ray at a rim
    RIMS_TIMED = 4096,            // pixels at rims whose rays show how long they take
    FIRST_RAYS_MOST = 1 << 16,    // rays of a pixel that is at no rim
    RARE_DOUBLED = 3              // they are doubled so often where emission is rare
};

// Emission that varies by less than this fraction, such as that of a sky, is smooth.
static const float SMOOTH = 0.1f;
// Emission is rare if more than this fraction of the pixels have it by chance. Then the error of
// the image is that of emission; single lamps do not double the time of all else.
static const float RARE_FRACTION = 0.01f;

static rgb trace_ray(const struct rims *rims, const struct shade *shade, uint32_t pixel,
                     uint32_t index, float *weight) {
    const uint32_t width = (uint32_t)rims->r->image->width;
    return shade_emission(shade, (int)(pixel % width), (int)(pixel / width), index, weight);
}

// ---- The rays of all pixels ---------------------------------------------------------------------

static void trace_first(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    const struct shade *shade = &rims->r->second_pass.shade;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct image_pixel *p = &rims->r->image->pixel[i];
        struct image_emission *e = &p->emission;
        if (e->weight == 0.0f)
            *e = (struct image_emission){
                .sum = p->layer[SHADE_EMISSION], .weight = p->weight, .samples = p->samples};
        const uint32_t rays = rims->late && p->samples ? 0 : rims->first;
        for (; e->rays < rays; e->rays++) {
            float weight;
            const rgb Le = trace_ray(rims, shade, (uint32_t)i, e->rays, &weight);
            if (!rgb_finite(Le)) continue;
            weight = render_usable_weight(e->weight, e->samples + e->rays, weight);
            e->sum = rgb_mad(e->sum, Le, weight);
            e->weight += weight;
        }
    }
}

static void pack_first(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct rims *rims = ctx;
    for (size_t i = begin; i < end; i++) {
        const struct image_pixel *p = &rims->r->image->pixel[i];
        bytes_put(out, &p->emission, sizeof p->emission);
    }
}

static bool unpack_first(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct rims *rims = ctx;
    for (size_t i = begin; i < end; i++) {
        struct image_pixel *p = &rims->r->image->pixel[i];
        bytes_get(in, &p->emission, sizeof p->emission);
    }
    return true;
}

static const struct parallel_results first_results = {
    .pack = pack_first, .unpack = unpack_first, .if_cancelled = true};

// ---- The pixels at rims -------------------------------------------------------------------------

static void read_emission(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct image_emission *e = &rims->r->image->pixel[i].emission;
        rims->emission[i] = rgb_luminance(render_emission_mean(e));
        rims->hits[i] = rims->emission[i] > 0.0f ? (float)(e->samples + e->rays) : 0.0f;
    }
}

struct image_box render_rims_within(const struct rims *rims, size_t pixel, int radius) {
    const struct render_image *image = rims->r->image;
    const int x = (int)(pixel % (size_t)image->width), y = (int)(pixel / (size_t)image->width);
    const int right = x + radius + 1, bottom = y + radius + 1;
    return (struct image_box){.x0 = x > radius ? x - radius : 0,
                              .y0 = y > radius ? y - radius : 0,
                              .x1 = right < image->width ? right : image->width,
                              .y1 = bottom < image->height ? bottom : image->height};
}

struct image_box render_rims_around(const struct rims *rims, size_t pixel) {
    return render_rims_within(rims, pixel, rims->radius);
}

// Whether emission varies around the pixel.
static bool on_rim(const void *ctx, size_t pixel) {
    const struct rims *rims = ctx;
    const struct image_box box = render_rims_around(rims, pixel);
    float least = INFINITY, most = 0.0f;
    for (int y = box.y0; y < box.y1; y++) {
        const float *row = rims->emission + (size_t)y * (size_t)rims->r->image->width;
        for (int x = box.x0; x < box.x1; x++) {
            least = row[x] < least ? row[x] : least;
            most = row[x] > most ? row[x] : most;
        }
    }
    return most - least > SMOOTH * most;
}

static void find_rims(struct rims *rims) {
    const struct render *r = rims->r;
    parallel_for_all(r->pool, render_pixel_count(r->image), READ_CHUNK, read_emission, rims);
    render_pixels_find(&rims->list, r, on_rim, rims);
    for (size_t i = 0; i < rims->list.count; i++) rims->known[rims->list.pixel[i]] = RIM_FOUND;
}

// ---- Their rays ---------------------------------------------------------------------------------

static void trace_rims(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    (void)worker;
    for (size_t i = rims->begin + begin; i < rims->begin + end; i++) {
        const uint32_t pixel = rims->list.pixel[i];
        struct rim *rim = &rims->rim[i];
        const uint32_t before = rims->r->image->pixel[pixel].emission.rim_rays;
        for (uint32_t k = rim->rays > before ? rim->rays : before; k < rims->most; k++) {
            float weight;
            const rgb Le = trace_ray(rims, &rims->wide, pixel, RIM_RAYS_BEGIN + k, &weight);
            if (!rgb_finite(Le)) continue;
            const float Y = rgb_luminance(Le), drawn = rims->wide.filter.wide ? weight : 1.0f;
            rim->sum = rgb_mad(rim->sum, Le, weight);
            rim->weight += weight;
            rim->Y += drawn * Y;
            rim->squares += drawn * sqrf(Y);
        }
        rim->rays = rims->most;
    }
}

static void pack_rims(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct rims *rims = ctx;
    bytes_put(out, rims->rim + rims->begin + begin, (end - begin) * sizeof *rims->rim);
}

static bool unpack_rims(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct rims *rims = ctx;
    bytes_get(in, rims->rim + rims->begin + begin, (end - begin) * sizeof *rims->rim);
    return true;
}

static const struct parallel_results rims_results = {
    .pack = pack_rims, .unpack = unpack_rims, .if_cancelled = true};

void render_rims_append(struct rims *rims, size_t pixel, int radius, enum rim_known known) {
    const struct image_box box = render_rims_within(rims, pixel, radius);
    for (int y = box.y0; y < box.y1; y++)
        for (int x = box.x0; x < box.x1; x++) {
            const size_t at = (size_t)y * (size_t)rims->r->image->width + (size_t)x;
            if (!rims->known[at]) rims->list.pixel[rims->list.count++] = (uint32_t)at;
            rims->known[at] |= known;
        }
}

// The hits that a pixel's samples and first rays are expected to have, as -ln of the probability
// that none finds light. A ray does with a probability of about mean^2 / mean of squares, which is
// the fraction of the pixel that a lamp covers where all else is black, and 1 where all is equal.
static float expected_hits(const struct image_emission *e, const struct rim *rim, uint32_t most) {
    const float Y = e->rim_Y + rim->Y, squares = e->rim_squares + rim->squares;
    const uint32_t rays = e->rim_rays > most ? e->rim_rays : most;
    if (!(squares > 0.0f)) return 0.0f;
    const float p = sqrf(Y) / ((float)rays * squares);
    return p < 1.0f ? -log1pf(-p) * (float)(e->samples + e->rays) : INFINITY;
}

// Evaluates the new rays of a pixel. If they find light where none was known, the pixels around get
// rays, too.
static void evaluate_rim(struct rims *rims, size_t i) {
    const uint32_t pixel = rims->list.pixel[i];
    const struct rim *rim = &rims->rim[i];
    rims->hits[pixel] = expected_hits(&rims->r->image->pixel[pixel].emission, rim, rims->most);
    if (rims->emission[pixel] != 0.0f || !(rim->Y > 0.0f)) return;
    rims->emission[pixel] = rim->Y / (float)rims->most;
    render_rims_append(rims, pixel, rims->radius, RIM_FOUND);
}

// Takes the rays of the pixels from an index on, and of those that are appended. False if it was
// stopped early, or if there is no memory, which *status says.
static bool trace_from(struct rims *rims, size_t begin, satin_status *status) {
    while (begin < rims->list.count) {
        const size_t end = rims->list.count;
        struct rim *grown = realloc(rims->rim, end * sizeof *rims->rim);
        if (!grown) *status = SATIN_ERROR_MEMORY;
        if (!grown) return false;
        rims->rim = grown;
        rims->begin = begin;
        if (end > rims->made)
            memset(rims->rim + rims->made, 0, (end - rims->made) * sizeof *rims->rim);
        rims->made = end;
        if (!parallel_for_results(rims->r->pool, end - begin, RIMS_CHUNK, trace_rims, rims,
                                  &rims_results))
            return false;
        for (; begin < end; begin++) evaluate_rim(rims, begin);
    }
    return true;
}

static void add_rims(struct rims *rims) {
    for (size_t i = 0; i < rims->list.count; i++) {
        const uint32_t pixel = rims->list.pixel[i];
        struct image_emission *e = &rims->r->image->pixel[pixel].emission;
        const struct rim *rim = &rims->rim[i];
        e->sum = rgb_add(e->sum, rim->sum);
        e->rim_weight += rim->weight;
        e->rim_Y += rim->Y;
        e->rim_squares += rim->squares;
        e->probability = fmaxf(e->probability, rims->probability[pixel]);
        if (e->rim_rays == 0) rims->added++;
        if (e->rim_rays < rims->most) e->rim_rays = rims->most;
    }
}

// ---- All rays -----------------------------------------------------------------------------------

// Takes the rays of the pixels at rims up to the number of rays, of those around them where they
// find light, and of those that are near enough of what was found by chance.
static bool trace_stage(struct rims *rims, satin_status *status) {
    struct render_image *image = rims->r->image;
    if (!trace_from(rims, 0, status)) return false;
    const size_t found = rims->list.count;
    if ((double)render_highlights_find(rims) > RARE_FRACTION * (double)render_pixel_count(image))
        image->rare_emission = true;
    else
        render_highlights_append_near(rims);
    if (!trace_from(rims, found, status)) return false;
    if (rims->list.count > found) (void)render_highlights_find(rims);
    return true;
}

// The number of rays that all stages have taken.
static double rays_taken(const struct rims *rims) {
    double taken = 0.0;
    for (size_t i = 0; i < rims->list.count; i++) {
        const uint32_t before = rims->r->image->pixel[rims->list.pixel[i]].emission.rim_rays;
        if (rims->most > before) taken += (double)(rims->most - before);
    }
    return taken;
}

static uint32_t planned_rays(const struct rims *rims, double ray_seconds) {
    const struct render *r = rims->r;
    const double count = (double)rims->list.count;
    const struct render_rim_rays known = {.fraction = count / (double)render_pixel_count(r->image),
                                          .seconds = count * ray_seconds,
                                          .first = rims->first,
                                          .late = rims->late};
    return render_budget_rim_rays(&r->options, render_core_seconds(r), &known);
}

// With a time limit, in stages of twice the rays: how many pixels are at rims, and how long their
// rays take, shows as they are traced.
static bool sample_rims(struct rims *rims, satin_status *status) {
    struct render *r = rims->r;
    if (rims->list.count == 0) return true;
    const double before = parallel_loop_seconds(r->pool);
    uint32_t planned = planned_rays(rims, 0.0);
    const bool timed = r->options.time > 0.0;
    for (uint32_t most = timed ? 1 : planned; most <= planned; most *= 2) {
        rims->most = most;
        if (!trace_stage(rims, status)) return false;
        if (!timed) break;
        const double seconds = render_agreed(r, parallel_loop_seconds(r->pool) - before),
                     taken = rays_taken(rims);
        if (taken > 0.0) r->progress.rim_ray_seconds = seconds / taken;
        planned = planned_rays(rims, r->progress.rim_ray_seconds);
    }
    add_rims(rims);
    return true;
}

static bool sample_emission(struct rims *rims, satin_status *status) {
    struct render_image *image = rims->r->image;
    const size_t pixels = render_pixel_count(image);
    if (!parallel_for_results(rims->r->pool, pixels, FIRST_CHUNK, trace_first, rims,
                              &first_results))
        return false;
    find_rims(rims);
    if (!sample_rims(rims, status)) return false;
    image->rims_taken = image->taken;
    return true;
}

// ---- Forecast -----------------------------------------------------------------------------------

static void time_first(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    const size_t step = render_pixel_count(rims->r->image) / RIMS_TIMED + 1;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        float weight;
        (void)trace_ray(rims, &rims->r->second_pass.shade, (uint32_t)(i * step), 0, &weight);
    }
}

double render_rims_ray_seconds(struct render *r) {
    struct rims rims = {.r = r};
    const size_t pixels = render_pixel_count(r->image), timed = pixels / (pixels / RIMS_TIMED + 1);
    const double before = parallel_loop_seconds(r->pool);
    parallel_begin_part(r->pool, "rims");
    parallel_for_all(r->pool, timed, RIMS_CHUNK, time_first, &rims);
    return render_agreed(r, parallel_loop_seconds(r->pool) - before) / (double)timed;
}

bool render_has_rims(const struct render *r) {
    return r->progress.replaced || !gather_traces_paths(&r->options);
}

// Up to twice as many as the samples that are not distributed equally, which do not count, and more
// where emission is rare. A power of two, so that they are distributed well.
static uint32_t first_rays(const struct render *r) {
    const struct render_image *image = r->image;
    const uint64_t pixels = (uint64_t)image->width * (uint64_t)image->height;
    const uint64_t others = image->taken / pixels - render_budget_equal_samples(&r->options);
    uint32_t rays = 1;
    while (rays <= others && rays < FIRST_RAYS_MOST) rays *= 2;
    for (int i = 0; image->rare_emission && i < RARE_DOUBLED && rays < FIRST_RAYS_MOST; i++)
        rays *= 2;
    return rays;
}

satin_status render_rims(struct render *r, bool late, bool *whole) {
    const struct render_image *image = r->image;
    const size_t pixels = render_pixel_count(image);
    struct rims rims = {.r = r, .late = late, .first = late ? 1 : first_rays(r)};
    rims.wide = r->second_pass.shade;
    scene_film_filter_widen(&rims.wide.filter);
    rims.radius = (int)ceilf(r->second_pass.shade.filter.film->radius);
    rims.emission = array_new_unset(pixels, sizeof *rims.emission);
    rims.hits = array_new_unset(pixels, sizeof *rims.hits);
    rims.probability = array_new(pixels, sizeof *rims.probability);
    rims.highlight = array_new_unset(pixels, sizeof *rims.highlight);
    rims.known = array_new(pixels, sizeof *rims.known);
    satin_status status = SATIN_OK;
    parallel_begin_part(r->pool, "rims");
    if (rims.emission && rims.hits && rims.probability && rims.highlight && rims.known &&
        render_pixels_make(&rims.list, image))
        *whole = sample_emission(&rims, &status);
    else
        status = SATIN_ERROR_MEMORY;
    stats_add(&r->stats, "image.rim_pixels", (double)rims.added);
    free(rims.emission);
    free(rims.hits);
    free(rims.probability);
    free(rims.highlight);
    render_pixels_destroy(&rims.list);
    free(rims.known);
    free(rims.rim);
    return status;
}
