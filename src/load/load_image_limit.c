// SPDX-License-Identifier: Apache-2.0
// Images that become coarser where memory is limited. The largest one loses its finest texels,
// again and again, until all fit; as each is read when the scene refers to it, that is done after
// every one.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/process.h"
#include "load/load_build.h"

// An environment must keep three rows.
enum { SIDE_LEAST = 6 };

struct load_held {
    struct image *image, *level;
    int levels, steps;
    bool environment;
};

// What the process leaves of the limit.
static double limit_left(const struct load_images *images) {
    return fmax(images->memory - process_bytes(images->module), 0.0);
}

static double bytes_held(const struct load_held *held) {
    double sum = scene_image_bytes(held->image);
    for (int i = 0; i < held->levels - held->steps; i++) sum += scene_image_bytes(&held->level[i]);
    return sum;
}

static double bytes_of_images(const struct load_images *images) {
    double sum = 0.0;
    for (size_t i = 0; i < images->count; i++) sum += bytes_held(&images->held[i]);
    return sum;
}

// The largest image that can become coarser, or NULL.
static struct load_held *largest(const struct load_images *images) {
    struct load_held *found = NULL;
    for (struct load_held *h = images->held; h < images->held + images->count; h++)
        if (h->image->width >= SIDE_LEAST && h->image->height >= SIDE_LEAST &&
            (!found || scene_image_bytes(h->image) > scene_image_bytes(found->image)))
            found = h;
    return found;
}

// Replaces the image by its first level, and each level by the next. The last one, a single texel,
// stays in the places behind it.
static bool coarsen(struct arena *arena, struct load_held *held) {
    const struct image finest = *held->image;
    if (!held->levels) {
        if (!load_image_coarser(arena, held->image, held->environment, held->image)) return false;
    } else {
        *held->image = held->level[0];
        for (int i = 0; i < held->levels - 1; i++) held->level[i] = held->level[i + 1];
    }
    arena_drop(arena, finest.byte ? (const void *)finest.byte : finest.texel);
    held->steps++;
    return true;
}

// Makes images coarser until all fit. False if there is no memory.
static bool fit_images(struct load_images *images) {
    if (!(images->memory > 0.0) || images->missing) return true;
    while (bytes_of_images(images) > 0.5 * limit_left(images)) {
        struct load_held *held = largest(images);
        if (!held) break;
        if (!coarsen(images->arena, held)) return false;
    }
    return true;
}

bool load_images_admit(struct load_images *images, double values, size_t size, double beside,
                       bool *admitted) {
    // The copies are floats and have a third of the texels.
    const double bytes = values * ((double)size + sizeof(float) / 3.0), read = bytes + beside;
    // Half of a limit that leaves twice this is enough for all others.
    images->needed = fmax(images->needed, read + fmin(read, images->asked));
    images->asked += bytes;
    // The image may be the first one that needs OpenImageIO, which leaves less to the others.
    if (!fit_images(images)) return false;
    *admitted = !(images->memory > 0.0) || read + bytes_of_images(images) <= limit_left(images);
    images->missing = images->missing || !*admitted;
    return true;
}

bool load_images_keep(struct load_images *images, struct image *image, struct image *level,
                      int levels, bool environment) {
    void *items = images->held;
    if (!array_reserve(&items, &images->capacity, images->count + 1, sizeof *images->held))
        return false;
    images->held = items;
    images->held[images->count++] = (struct load_held){image, level, levels, 0, environment};
    return fit_images(images);
}

void load_images_end(struct load_images *images, struct log log, struct scene_images *out) {
    int coarser = 0;
    for (size_t i = 0; i < images->count; i++) coarser += images->held[i].steps > 0;
    *out = (struct scene_images){.module = images->module,
                                 .missing = images->missing,
                                 .bytes = bytes_of_images(images),
                                 .asked = images->asked,
                                 .needed = images->needed};
    if (coarser && !images->missing)
        log_message(log, SATIN_LOG_WARNING,
                    "option memory: %d of %zu images %s coarser, in %.3g of %.3g MB", coarser,
                    images->count, coarser > 1 ? "are" : "is", out->bytes / 1e6, out->asked / 1e6);
    free(images->held);
    *images = (struct load_images){0};
}
