// SPDX-License-Identifier: Apache-2.0
// A pass of the image: all samples up to the targets of the pixels, tile by tile. The samples of a
// tile depend on its earlier ones in the pass, by what is kept of them for reuse, so a tile of a
// render that has a checkpoint gets all its samples of a pass or none.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_image.h"

enum { ASK_SAMPLES = 32 };  // samples after which a worker checks for cancellation

struct image_worker {
    struct shade_worker shade;
    struct bytes before;  // state of the tile before its samples, if there is a checkpoint
    unsigned samples;     // since the worker began
    size_t tile;          // the current one
};

static struct image_box tile_box(const struct image_pass *pass, size_t tile) {
    const struct render_image *image = pass->r->image;
    const int x0 = (int)(tile % (size_t)pass->columns) * IMAGE_TILE;
    const int y0 = (int)(tile / (size_t)pass->columns) * IMAGE_TILE;
    return (struct image_box){x0, y0,
                              x0 + IMAGE_TILE < image->width ? x0 + IMAGE_TILE : image->width,
                              y0 + IMAGE_TILE < image->height ? y0 + IMAGE_TILE : image->height};
}

void render_pass_destroy(struct image_pass *pass) {
    for (int i = 0; pass->worker && i < parallel_threads(pass->r->pool); i++)
        bytes_free(&pass->worker[i].before);
    free(pass->worker);
}

bool render_pass_make(struct image_pass *pass, struct render *r) {
    const int workers = parallel_threads(r->pool);
    *pass = (struct image_pass){.r = r, .columns = (r->image->width + IMAGE_TILE - 1) / IMAGE_TILE};
    pass->worker = array_new((size_t)workers, sizeof *pass->worker);
    if (!pass->worker) return false;
    for (int i = 0; i < workers; i++) pass->worker[i].shade.gather = r->second_pass.shade.worker[i];
    return true;
}

// ---- Samples ------------------------------------------------------------------------------------

// False if the sample was not finite and was dropped.
static bool add_sample(struct image_pixel *pixel, const struct shade_sample *s) {
    if (!shade_sample_finite(s)) {
        pixel->dropped++;
        return false;
    }
    pixel->samples++;
    pixel->weight += s->weight;
    pixel->beauty = rgb_mad(pixel->beauty, s->beauty, s->weight);
    for (int i = 0; i < SHADE_LAYERS; i++)
        pixel->layer[i] = rgb_mad(pixel->layer[i], s->layer[i], s->weight);
    pixel->depth += s->weight * s->depth;
    pixel->alpha += s->weight * s->alpha;
    pixel->record += s->record;
    pixel->used = cache_used_add(pixel->used, s->used);
    return true;
}

// To be called after add_sample.
static void add_to_block(struct render_image *image, size_t at, rgb value) {
    struct image_blocks *blocks = &image->blocks[at];
    blocks->begun = rgb_add(blocks->begun, value);
    if (image->pixel[at].samples % image->block) return;
    blocks->sums = rgb_add(blocks->sums, blocks->begun);
    blocks->squares = rgb_fma(blocks->squares, blocks->begun, blocks->begun);
    blocks->begun = rgb_grey(0.0f);
}

static void add_aovs(const struct render_image *image, size_t at, const struct shade_sample *s) {
    const int values = image->aovs->values;
    float *sum = image->aov + at * image->sums;
    for (int i = 0; i < values; i++) sum[i] += s->weight * s->aov[i];
    for (int i = 0; image->aovs->moment && i < values; i++)
        sum[values + i] += s->weight * (s->aov[i] * s->aov[i]);
}

static void add_uncached(struct image_uncached *sum, int parity, const struct shade_sample *s) {
    sum->light = rgb_mad(sum->light, s->uncached, s->weight);
    if (parity & 1) {
        sum->odd = rgb_mad(sum->odd, rgb_sub(s->beauty, s->layer[SHADE_EMISSION]), s->weight);
        sum->odd_weight += s->weight;
    }
    render_features_add(sum, &s->features, s->weight);
}

// Takes the samples of a pixel in this pass. False if it was stopped.
static bool sample_pixel(const struct image_pass *pass, int x, int y, struct image_worker *worker,
                         int number) {
    struct parallel *pool = pass->r->pool;
    struct render_image *image = pass->r->image;
    const size_t at = (size_t)y * (size_t)image->width + (size_t)x;
    struct adaptive_pixel *adapt = &image->adapt.pixel[at];
    shade_pixel_begin(&worker->shade);
    while (adapt->count < adapt->target) {
        struct shade_sample sample;
        shade_pixel(&pass->r->second_pass.shade, &worker->shade, x, y, adapt->count,
                    render_adaptive_next(adapt), &sample);
        if (parallel_stopped(pool)) return false;  // it may be incomplete
        sample.weight =
            render_usable_weight(image->pixel[at].weight, image->pixel[at].samples, sample.weight);
        bool finite = add_sample(&image->pixel[at], &sample);
        if (finite && image->aov) add_aovs(image, at, &sample);
        if (finite) render_cryptomatte_add(&image->cryptomatte, at, &sample);
        if (finite && image->blocks) add_to_block(image, at, sample.beauty);
        if (finite && image->gathered) render_irradiance_gathered(&image->gathered[at], &sample);
        if (finite && image->noisy_light)
            render_noise_add(&image->noisy_light[at], x + y + (int)adapt->count, &sample);
        if (finite && image->uncached)
            add_uncached(&image->uncached[at], x + y + (int)adapt->count, &sample);
        render_adaptive_add(adapt, &sample);
        render_tile_yield(image, worker->tile, number);
        // A late pass takes thousands of samples of every pixel.
        if (++worker->samples % ASK_SAMPLES == 0 && parallel_cancelled(pool, number)) return false;
    }
    return true;
}

// ---- Tiles --------------------------------------------------------------------------------------

static bool sample_tile(const struct image_pass *pass, struct image_box box,
                        struct image_worker *worker, int number) {
    bool whole = true;
    shade_tile_begin(&worker->shade);
    for (int y = box.y0; y < box.y1 && whole; y++)
        for (int x = box.x0; x < box.x1 && whole; x++)
            whole = sample_pixel(pass, x, y, worker, number);
    return whole;
}

// Takes the samples of a tile in this pass. If it was stopped and the render has a checkpoint, the
// tile is as it was before.
static bool render_tile(const struct image_pass *pass, size_t tile, int number) {
    struct image_worker *worker = &pass->worker[number];
    struct render_image *image = pass->r->image;
    const struct image_box box = tile_box(pass, tile);
    const struct shade_counts counts = worker->shade.counts;
    const unsigned samples = worker->samples;
    const bool restores = render_has_checkpoint(pass->r);
    worker->before.count = 0;
    if (restores) render_image_pack_box(image, box, &worker->before);
    const bool whole = sample_tile(pass, box, worker, number);
    if (whole && worker->samples != samples) {
        atomic_store(&image->progressed, true);
        atomic_store(&image->unwritten, true);
    }
    struct bytes_reader before = {worker->before.data, worker->before.count, false};
    if (!whole && restores) {
        render_image_unpack_box(image, box, &before);
        worker->shade.counts = counts;
    }
    return whole;
}

static void render_tiles(void *ctx, size_t begin, size_t end, int worker) {
    const struct image_pass *pass = ctx;
    bool whole = true;
    for (size_t tile = begin; tile < end && whole; tile++) {
        pass->worker[worker].tile = tile;
        render_tile_begin(pass->r->image, tile, worker);
        whole = render_tile(pass, tile, worker);
        render_tile_end(pass->r->image, tile);
    }
}

static void pack_tiles(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct image_pass *pass = ctx;
    for (size_t tile = begin; tile < end; tile++)
        render_image_pack_box(pass->r->image, tile_box(pass, tile), out);
}

static bool unpack_tiles(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct image_pass *pass = ctx;
    for (size_t tile = begin; tile < end; tile++)
        render_image_unpack_box(pass->r->image, tile_box(pass, tile), in);
    atomic_store(&pass->r->image->unwritten, true);
    return true;
}

static const struct parallel_results tiles_results = {
    .pack = pack_tiles, .unpack = unpack_tiles, .if_cancelled = true};

// Takes the counts of all workers of this rank.
static struct shade_counts take_counts(struct image_pass *pass) {
    struct shade_counts sum = {0};
    for (int i = 0; i < parallel_threads(pass->r->pool); i++) {
        shade_counts_add(&sum, &pass->worker[i].shade.counts);
        pass->worker[i].shade.counts = (struct shade_counts){0};
    }
    return sum;
}

// Adds the counts of all ranks to those of the image.
static void collect_counts(struct image_pass *pass) {
    struct shade_counts sum = take_counts(pass);
    parallel_sum(pass->r->pool, (uint64_t *)&sum, sizeof sum / sizeof(uint64_t));
    shade_counts_add(&pass->r->image->counts, &sum);
}

void render_pass_collect_own(struct image_pass *pass) {
    const struct shade_counts sum = take_counts(pass);
    shade_counts_add(&pass->r->image->counts, &sum);
}

bool render_pass_run(struct image_pass *pass) {
    struct render *r = pass->r;
    struct render_image *image = r->image;
    const bool first = image->state == IMAGE_EMPTY;
    const size_t rows = (size_t)((image->height + IMAGE_TILE - 1) / IMAGE_TILE);
    parallel_begin_part(r->pool, "image");
    for (;;) {
        image->state = first ? IMAGE_BEGINNING : IMAGE_SAMPLING;
        image->pass = pass;
        const bool whole = parallel_for_results(r->pool, (size_t)pass->columns * rows, 1,
                                                render_tiles, pass, &tiles_results);
        image->state = first && !whole ? IMAGE_EMPTY : IMAGE_PAUSED;
        collect_counts(pass);
        if (whole || !render_checkpoint_pause(r)) return whole;
    }
}
