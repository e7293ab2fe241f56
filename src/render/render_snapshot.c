// SPDX-License-Identifier: Apache-2.0
// Snapshots: the film of an image that is being sampled, for the caller to show. They are made on
// the calling thread, between two of its own samples, while the other workers go on. A tile belongs
// to the worker that samples it or to the snapshot that reads it, so that no pixel is read while it
// changes. At the end, workers leave their tiles to the snapshot for a moment; the tile of one that
// is in the middle of a long sample keeps the values of the snapshot before. Nothing but the film
// of snapshots is written, so that the image does not depend on them.
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#include "render/render_image.h"

// A user of a tile; workers are their numbers plus 1.
enum { NO_USER = 0, SNAPSHOT_USER = -1 };

// The largest number of tiles for which a snapshot waits; there is one for each worker.
enum { MISSED_MAX = 1024 };
// For how long it waits: a sample takes microseconds, rarely a millisecond, and meanwhile those
// workers stand still that have left their tiles.
static const double WAIT_SECONDS = 0.005;

static size_t tile_count(const struct render_image *image) {
    const size_t columns = (size_t)((image->width + IMAGE_TILE - 1) / IMAGE_TILE);
    return columns * (size_t)((image->height + IMAGE_TILE - 1) / IMAGE_TILE);
}

void render_tile_begin(struct render_image *image, size_t tile, int worker) {
    if (!image->tile_user) return;
    int user = NO_USER;
    while (!atomic_compare_exchange_weak(&image->tile_user[tile], &user, worker + 1)) {
        user = NO_USER;
        sched_yield();
    }
}

void render_tile_end(struct render_image *image, size_t tile) {
    if (image->tile_user) atomic_store(&image->tile_user[tile], NO_USER);
}

void render_tile_yield(struct render_image *image, size_t tile, int worker) {
    if (!image->tile_user || !atomic_load_explicit(&image->tiles_wanted, memory_order_relaxed))
        return;
    render_tile_end(image, tile);
    while (atomic_load(&image->tiles_wanted)) sched_yield();
    render_tile_begin(image, tile, worker);
}

// ---- Memory -------------------------------------------------------------------------------------

void render_snapshot_free(struct render_snapshot *snapshot) {
    if (!snapshot) return;
    satin_film_free(snapshot->film);
    free(snapshot->has);
    free(snapshot);
}

// To be called when the first snapshot is made: an image that changes its channels before that, as
// the course does, has no snapshot yet.
static struct render_snapshot *make_snapshot(const struct render *r) {
    const struct render_image *image = r->image;
    struct render_snapshot *snapshot = calloc(1, sizeof *snapshot);
    satin_options options = r->options;
    if (!snapshot) return NULL;
    if (r->callbacks.snapshot_beauty) snprintf(options.layers, sizeof options.layers, "none");
    snapshot->pixels = snapshot->missing = render_pixel_count(image);
    snapshot->has = calloc(snapshot->pixels, 1);
    snapshot->film = render_film_new(&r->scene, &options);
    if (snapshot->has && snapshot->film) {
        snapshot->planes = render_film_planes(image, snapshot->film);
        return snapshot;
    }
    render_snapshot_free(snapshot);
    return NULL;
}

bool render_snapshot_memory(const struct render *r, struct render_image *image) {
    if (!r->callbacks.snapshot || image->tile_user) return true;
    image->tile_user = calloc(tile_count(image), sizeof *image->tile_user);
    return image->tile_user != NULL;
}

// ---- The film -----------------------------------------------------------------------------------

static void read_image_tile(struct render_snapshot *snapshot, const struct render_image *image,
                            int x0, int y0) {
    for (int y = y0; y < y0 + IMAGE_TILE && y < image->height; y++)
        for (int x = x0; x < x0 + IMAGE_TILE && x < image->width; x++) {
            const size_t at = (size_t)y * (size_t)image->width + (size_t)x;
            const struct image_pixel *pixel = &image->pixel[at];
            if (!pixel->samples && !pixel->dropped) continue;
            render_film_put(image, &snapshot->planes, at, pixel);
            snapshot->missing -= !snapshot->has[at];
            snapshot->has[at] = 1;
        }
}

// Reads a tile, unless a worker has it. The calling thread is worker 0, and is between two samples.
static bool try_tile(struct render_snapshot *snapshot, struct render_image *image, size_t tile) {
    const size_t columns = (size_t)((image->width + IMAGE_TILE - 1) / IMAGE_TILE);
    int user = NO_USER;
    const bool taken =
        atomic_compare_exchange_strong(&image->tile_user[tile], &user, SNAPSHOT_USER);
    if (!taken && user != 0 + 1) return false;
    read_image_tile(snapshot, image, (int)(tile % columns) * IMAGE_TILE,
                    (int)(tile / columns) * IMAGE_TILE);
    if (taken) atomic_store(&image->tile_user[tile], NO_USER);
    return true;
}

// Asks all workers to leave their tiles between two samples, and reads those that were missed.
static void read_missed(struct render_snapshot *snapshot, struct render_image *image, size_t *tile,
                        size_t count) {
    const double end = stats_wall() + WAIT_SECONDS;
    if (count == 0) return;
    atomic_store(&image->tiles_wanted, true);
    while (count > 0 && stats_wall() < end) {
        size_t left = 0;
        for (size_t i = 0; i < count; i++)
            if (!try_tile(snapshot, image, tile[i])) tile[left++] = tile[i];
        count = left;
        sched_yield();
    }
    atomic_store(&image->tiles_wanted, false);
}

static void read_all_tiles(struct render_snapshot *snapshot, struct render_image *image) {
    size_t missed[MISSED_MAX], count = 0;
    for (size_t tile = 0; tile < tile_count(image); tile++)
        if (!try_tile(snapshot, image, tile) && count < MISSED_MAX) missed[count++] = tile;
    read_missed(snapshot, image, missed, count);
}

// The pixel whose values are shown at (x, y), as render_image_source finds it in the image.
static bool find_source(const struct render_snapshot *snapshot, const struct render_image *image,
                        int x, int y, size_t *source) {
    for (int stride = 2; stride <= image->coarsest; stride *= 2) {
        *source = (size_t)(y - y % stride) * (size_t)image->width + (size_t)(x - x % stride);
        if (snapshot->has[*source]) return true;
    }
    return false;
}

// Gives pixels that have no sample so far the values of a neighbour, in all channels but that of
// the number of samples.
static void complete_pixels(struct render_snapshot *snapshot, const struct render_image *image) {
    const struct satin_film *film = snapshot->film;
    const float *samples = snapshot->planes.of[CHANNEL_SAMPLES];
    if (!snapshot->missing) return;
    for (size_t at = 0; at < snapshot->pixels; at++) {
        size_t source;
        if (snapshot->has[at] || !find_source(snapshot, image, (int)(at % (size_t)image->width),
                                              (int)(at / (size_t)image->width), &source))
            continue;
        for (int i = 0; i < film->channel_count; i++)
            if (film->channel[i] != samples) film->channel[i][at] = film->channel[i][source];
    }
}

// ---- When ---------------------------------------------------------------------------------------

void render_snapshot_send(struct render *r) {
    struct render_image *image = r->image;
    const double begin = stats_wall();
    if (!r->callbacks.snapshot || r->progress.stage != STAGE_IMAGE || render_cancelled(r)) return;
    if (image->state != IMAGE_SAMPLING || render_steps(r)->coarse) return;
    if (r->snapshot && begin < r->snapshot->next) return;
    if (!r->snapshot) r->snapshot = make_snapshot(r);
    if (!r->snapshot) {
        log_message(r->log, SATIN_LOG_WARNING, "not enough memory to show the image so far");
        r->callbacks.snapshot = NULL;
        return;
    }
    read_all_tiles(r->snapshot, image);
    complete_pixels(r->snapshot, image);
    r->callbacks.snapshot(r->callbacks.snapshot_user, r->snapshot->film);
    const double end = stats_wall(), spent = end - begin;
    r->snapshot->next = end + render_budget_snapshot(spent, parallel_threads(r->pool));
    stats_add(&r->stats, "image.snapshots", 1.0);
    stats_add(&r->stats, "time.snapshots_s", spent);
}
