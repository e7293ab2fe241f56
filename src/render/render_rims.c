// SPDX-License-Identifier: Apache-2.0
// Light that is seen directly. A lamp is tens of times as bright as the wall around it, so a few
// samples more or less that hit it make the pixels along its edge look jagged; and as adaptive
// sampling gives more samples to pixels that have met a lamp, their means are too dark where it is
// small. An eye ray for emitted light alone costs a small fraction of a sample. So the emission
// layer is the mean of the samples that are distributed equally, and of additional rays: a few in
// each pixel, whose number grows with that of the samples, and many where emission varies. Where
// few rays find a small lamp by chance alone, the pixels that have found it stand for those that
// have not. If enough of them are near each other, as where a lamp is seen through a pierced shade,
// all pixels around get many rays; else none does, unless the image has many such pixels.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "render/render_image.h"

enum {
    FIRST_CHUNK = 256,          // pixels per chunk of the rays of all pixels
    RIMS_CHUNK = 64,            // pixels per chunk of those at rims
    CHUNK_ROWS = 8,             // rows per chunk of the search
    CHANCE_FRACTION = 4,        // for this number of rays at rims, one more decides about them
    CHANCE_BEGIN = 0x40000000,  // index of the first of those
    RIMS_TIMED = 4096,          // pixels at rims whose rays show how long they take
    FIRST_RAYS_MOST = 1 << 16,  // rays of a pixel that is at no rim
    RARE_DOUBLED = 3            // they are doubled so often where emission is rare
};

// Emission that varies by less than this fraction, such as that of a sky, is smooth.
static const float SMOOTH = 0.1f;
// The number of rays and samples around a pixel that must be expected to find what its rays at a
// rim would find. The chance that none does is then below e^-3, and so is the fraction of the
// emission that is lost.
static const float HITS_LEAST = 3.0f;
// Pixels that have found emission by chance are near each other up to this many pixels away.
enum { NEAR_PIXELS = 8 };
// Emission is rare if more than this fraction of the pixels have it by chance. Then the error of
// the image is that of emission; single lamps do not double the time of all else.
static const float RARE_FRACTION = 0.01f;

// What is known of a pixel: whether it is at a rim, which may have been found by chance, and
// whether it is near enough of these. 0: nothing.
enum rim_known { RIM_FOUND = 1, RIM_BY_CHANCE = 2, RIM_NEAR = 4 };

// The weighted emission of a pixel's rays at a rim, and their weight.
struct rim {
    rgb sum;
    float weight;
};

struct rims {
    struct render *r;
    bool late;        // the time limit is over: only pixels without samples have first rays
    uint32_t first;   // number of rays in pixels that are at no rim
    uint32_t most;    // number of rays at rims
    int radius;       // of the film's filter, in pixels
    float *emission;  // luminance of each pixel's mean
    float *hits;      // of each pixel: how many samples and rays are expected to find emission
    uint32_t *pixel;  // y * width + x
    uint32_t *found;  // number of such pixels in each row
    size_t count;
    struct rim *rim;  // of those pixels
    size_t begin;     // index of the first pixel of a loop
    uint8_t *known;   // of each pixel of the image: enum rim_known
    size_t added;     // number of pixels that have got rays of rims
};

static rgb trace_ray(const struct rims *rims, uint32_t pixel, uint32_t index, float *weight) {
    const uint32_t width = (uint32_t)rims->r->image->width;
    return shade_emission(&rims->r->second_pass.shade, (int)(pixel % width), (int)(pixel / width),
                          index, weight);
}

// ---- The rays of all pixels ---------------------------------------------------------------------

static void trace_first(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct image_pixel *p = &rims->r->image->pixel[i];
        struct image_emission *e = &p->emission;
        if (e->weight == 0.0f)
            *e = (struct image_emission){p->layer[SHADE_EMISSION], p->weight, p->samples, 0};
        const uint32_t rays = rims->late && p->samples ? 0 : rims->first;
        for (; e->rays < rays; e->rays++) {
            float weight;
            const rgb Le = trace_ray(rims, (uint32_t)i, e->rays, &weight);
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
        rims->emission[i] = e->weight > 0.0f ? rgb_luminance(e->sum) / e->weight : 0.0f;
        rims->hits[i] = rims->emission[i] > 0.0f ? (float)(e->samples + e->rays) : 0.0f;
    }
}

// The box of pixels up to this number of pixels away.
static struct image_box box_within(const struct render_image *image, size_t pixel, int radius) {
    const int x = (int)(pixel % (size_t)image->width), y = (int)(pixel / (size_t)image->width);
    const int right = x + radius + 1, bottom = y + radius + 1;
    return (struct image_box){.x0 = x > radius ? x - radius : 0,
                              .y0 = y > radius ? y - radius : 0,
                              .x1 = right < image->width ? right : image->width,
                              .y1 = bottom < image->height ? bottom : image->height};
}

// Up to the filter's radius: the few rays in its tail may all miss a lamp that the pixel sees, or
// hit it by chance.
static struct image_box pixels_around(const struct rims *rims, size_t pixel) {
    return box_within(rims->r->image, pixel, rims->radius);
}

// Whether emission varies around the pixel.
static bool on_rim(const struct rims *rims, size_t pixel) {
    const struct image_box box = pixels_around(rims, pixel);
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

// Stores the pixels of each row from the index on at which the row begins.
static void search_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    const size_t width = (size_t)rims->r->image->width;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (size_t at = y * width; at < (y + 1) * width; at++)
            if (on_rim(rims, at)) rims->pixel[y * width + rims->found[y]++] = (uint32_t)at;
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

// ---- Their rays ---------------------------------------------------------------------------------

// The chance that a ray finds what gives a pixel its mean: about mean^2 / mean of squares, which is
// the fraction of the pixel that a lamp covers where all else is black, and 1 where all is equal.
// By rays that count for nothing else: if those of the mean decided whether they are added, the
// brightest would be.
static float chance_of_rays(const struct rims *rims, uint32_t pixel) {
    const uint32_t rays = rims->most / CHANCE_FRACTION;
    float sum = 0.0f, squares = 0.0f;
    for (uint32_t k = 0; k < rays; k++) {
        float weight;
        const rgb Le = trace_ray(rims, pixel, CHANCE_BEGIN + k, &weight);
        if (!rgb_finite(Le)) continue;
        sum += rgb_luminance(Le);
        squares += sqrf(rgb_luminance(Le));
    }
    return squares > 0.0f ? sqrf(sum) / ((float)rays * squares) : 0.0f;
}

static void trace_rims(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    (void)worker;
    for (size_t i = rims->begin + begin; i < rims->begin + end; i++) {
        const uint32_t pixel = rims->pixel[i];
        const struct image_emission *e = &rims->r->image->pixel[pixel].emission;
        struct rim *rim = &rims->rim[i];
        for (uint32_t k = e->rays; k < rims->most; k++) {
            float weight;
            const rgb Le = trace_ray(rims, pixel, k, &weight);
            if (!rgb_finite(Le)) continue;
            rim->sum = rgb_mad(rim->sum, Le, weight);
            rim->weight += weight;
        }
        rims->hits[pixel] = e->rays > rims->first
                                ? HITS_LEAST
                                : chance_of_rays(rims, pixel) * (float)(e->samples + e->rays);
    }
}

static void pack_rims(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct rims *rims = ctx;
    const uint32_t *pixel = rims->pixel + rims->begin;
    bytes_put(out, rims->rim + rims->begin + begin, (end - begin) * sizeof *rims->rim);
    for (size_t i = begin; i < end; i++) bytes_put(out, &rims->hits[pixel[i]], sizeof *rims->hits);
}

static bool unpack_rims(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct rims *rims = ctx;
    const uint32_t *pixel = rims->pixel + rims->begin;
    bytes_get(in, rims->rim + rims->begin + begin, (end - begin) * sizeof *rims->rim);
    for (size_t i = begin; i < end; i++) bytes_get(in, &rims->hits[pixel[i]], sizeof *rims->hits);
    return true;
}

static const struct parallel_results rims_results = {
    .pack = pack_rims, .unpack = unpack_rims, .if_cancelled = true};

static bool found_by_chance(const struct rims *rims, size_t pixel) {
    const struct image_box box = pixels_around(rims, pixel);
    float hits = 0.0f;
    for (int y = box.y0; y < box.y1; y++)
        for (int x = box.x0; x < box.x1; x++)
            hits += rims->hits[(size_t)y * (size_t)rims->r->image->width + (size_t)x];
    return hits < HITS_LEAST;
}

// Notes which rims were found by chance, and returns how many.
static size_t evaluate_rims(struct rims *rims) {
    size_t by_chance = 0;
    for (size_t i = 0; i < rims->count; i++) {
        const bool chance = found_by_chance(rims, rims->pixel[i]);
        rims->known[rims->pixel[i]] = chance ? RIM_BY_CHANCE : RIM_FOUND;
        by_chance += chance;
    }
    return by_chance;
}

static bool enough_near(const struct rims *rims, struct image_box box) {
    float hits = 0.0f;
    for (int y = box.y0; y < box.y1; y++)
        for (int x = box.x0; x < box.x1; x++) {
            const size_t at = (size_t)y * (size_t)rims->r->image->width + (size_t)x;
            if (rims->known[at] & RIM_BY_CHANCE) hits += rims->hits[at];
        }
    return hits >= HITS_LEAST;
}

// Appends the pixels around rims that were found by chance where enough of these are near.
static void find_rims_near(struct rims *rims) {
    const size_t found = rims->count;
    for (size_t i = 0; i < found; i++) {
        const struct image_box box = box_within(rims->r->image, rims->pixel[i], NEAR_PIXELS);
        if (!(rims->known[rims->pixel[i]] & RIM_BY_CHANCE) || !enough_near(rims, box)) continue;
        for (int y = box.y0; y < box.y1; y++)
            for (int x = box.x0; x < box.x1; x++) {
                const size_t at = (size_t)y * (size_t)rims->r->image->width + (size_t)x;
                if (!rims->known[at]) rims->pixel[rims->count++] = (uint32_t)at;
                rims->known[at] |= RIM_NEAR;
            }
    }
}

static void add_rims(struct rims *rims) {
    for (size_t i = 0; i < rims->count; i++) {
        struct image_emission *e = &rims->r->image->pixel[rims->pixel[i]].emission;
        if (rims->known[rims->pixel[i]] == RIM_BY_CHANCE) continue;
        e->sum = rgb_add(e->sum, rims->rim[i].sum);
        e->weight += rims->rim[i].weight;
        if (e->rays <= rims->first) rims->added++;
        if (e->rays < rims->most) e->rays = rims->most;
    }
}

// Takes the rays of the pixels from an index on. False if it was stopped early, or if there is no
// memory, which *status says.
static bool trace_from(struct rims *rims, size_t begin, satin_status *status) {
    if (rims->count == begin) return true;
    struct rim *grown = realloc(rims->rim, rims->count * sizeof *rims->rim);
    if (!grown) *status = SATIN_ERROR_MEMORY;
    if (!grown) return false;
    rims->rim = grown;
    rims->begin = begin;
    memset(rims->rim + begin, 0, (rims->count - begin) * sizeof *rims->rim);
    return parallel_for_results(rims->r->pool, rims->count - begin, RIMS_CHUNK, trace_rims, rims,
                                &rims_results);
}

static void time_rays(void *ctx, size_t begin, size_t end, int worker) {
    const struct rims *rims = ctx;
    const size_t step = rims->count / RIMS_TIMED + 1;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        float weight;
        (void)trace_ray(rims, rims->pixel[i * step], CHANCE_BEGIN, &weight);
    }
}

// The time of one core for one ray at each rim, measured at some of them by rays that do not count.
static double ray_seconds(struct rims *rims) {
    struct parallel *pool = rims->r->pool;
    const size_t step = rims->count / RIMS_TIMED + 1, timed = rims->count / step;
    const double start = stats_wall();
    parallel_for_all(pool, timed, RIMS_CHUNK, time_rays, rims);
    return render_agreed(rims->r, stats_wall() - start) * parallel_threads(pool) * (double)step;
}

// Likewise, of all pixels at rims.
static bool sample_rims(struct rims *rims, satin_status *status) {
    struct render *r = rims->r;
    const double pixels = (double)r->image->width * (double)r->image->height;
    if (rims->count == 0) return true;
    const struct render_rim_rays known = {
        .fraction = (double)rims->count / pixels,
        .seconds = r->options.time > 0.0 ? ray_seconds(rims) : 0.0,
        .first = rims->first,
        .late = rims->late};
    rims->most = render_budget_rim_rays(&r->options, render_core_seconds(r), &known);
    if (!trace_from(rims, 0, status)) return false;
    const size_t found = rims->count;
    if ((double)evaluate_rims(rims) > RARE_FRACTION * pixels)
        r->image->rare_emission = true;
    else
        find_rims_near(rims);
    if (!trace_from(rims, found, status)) return false;
    add_rims(rims);
    return true;
}

static bool sample_emission(struct rims *rims, satin_status *status) {
    struct render_image *image = rims->r->image;
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    if (!parallel_for_results(rims->r->pool, pixels, FIRST_CHUNK, trace_first, rims,
                              &first_results))
        return false;
    find_rims(rims);
    if (!sample_rims(rims, status)) return false;
    image->rims_taken = image->taken;
    return true;
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
    const size_t width = (size_t)image->width, height = (size_t)image->height;
    struct rims rims = {.r = r, .late = late, .first = late ? 1 : first_rays(r)};
    rims.radius = (int)ceilf(r->second_pass.shade.filter.film->radius);
    rims.emission = array_new_unset(width * height, sizeof *rims.emission);
    rims.hits = array_new_unset(width * height, sizeof *rims.hits);
    rims.pixel = array_new_unset(width * height, sizeof *rims.pixel);
    rims.found = array_new(height, sizeof *rims.found);
    rims.known = array_new(width * height, sizeof *rims.known);
    satin_status status = SATIN_OK;
    parallel_begin_part(r->pool, "rims");
    if (rims.emission && rims.hits && rims.pixel && rims.found && rims.known)
        *whole = sample_emission(&rims, &status);
    else
        status = SATIN_ERROR_MEMORY;
    stats_add(&r->stats, "image.rim_pixels", (double)rims.added);
    free(rims.emission);
    free(rims.hits);
    free(rims.pixel);
    free(rims.found);
    free(rims.known);
    free(rims.rim);
    return status;
}
