// SPDX-License-Identifier: Apache-2.0
// Images that become coarser where memory is limited. The largest one loses its finest texels,
// again and again, until all fit; as each is read when the scene refers to it, that is done after
// every one. What is left is the same in whichever order they are read, unless two are of one size.
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
};

static double process_bytes(const struct load_images *images) {
    return PROCESS_BYTES + (images->module ? PROCESS_MODULE_BYTES : 0.0);
}

double load_images_most(const struct load_images *images) {
    if (!(images->memory > 0.0)) return INFINITY;
    return 0.5 * fmax(images->memory - process_bytes(images), 0.0);
}

double load_images_limit(const struct load_images *images, double bytes) {
    return process_bytes(images) + 2.0 * bytes;
}

static double texel_bytes(const struct image *image) {
    return (double)image->width * image->height * image->channels * sizeof *image->texel;
}

static double bytes_held(const struct load_held *held) {
    double sum = texel_bytes(held->image);
    for (int i = 0; i < held->levels - held->steps; i++) sum += texel_bytes(&held->level[i]);
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
            (!found || texel_bytes(h->image) > texel_bytes(found->image)))
            found = h;
    return found;
}

// Replaces the image by its first level, and each level by the next. The last one, a single texel,
// stays in the places behind it.
static bool coarsen(struct arena *arena, struct load_held *held) {
    const float *texel = held->image->texel;
    if (!held->levels) {
        if (!load_image_coarser(arena, held->image, held->image)) return false;
    } else {
        *held->image = held->level[0];
        for (int i = 0; i < held->levels - 1; i++) held->level[i] = held->level[i + 1];
    }
    arena_drop(arena, texel);
    held->steps++;
    return true;
}

bool load_images_keep(struct load_images *images, struct image *image, struct image *level,
                      int levels) {
    void *items = images->held;
    if (!array_reserve(&items, &images->capacity, images->count + 1, sizeof *images->held))
        return false;
    images->held = items;
    struct load_held *added = &images->held[images->count++];
    *added = (struct load_held){image, level, levels, 0};
    images->full += bytes_held(added);
    const double most = load_images_most(images);
    while (bytes_of_images(images) > most) {
        struct load_held *held = largest(images);
        if (!held) break;
        if (!coarsen(images->arena, held)) return false;
    }
    return true;
}

void load_images_end(struct load_images *images, struct log log, struct scene_images *out) {
    int coarser = 0;
    for (size_t i = 0; i < images->count; i++) coarser += images->held[i].steps > 0;
    *out = (struct scene_images){images->module, bytes_of_images(images), images->full};
    if (coarser)
        log_message(log, SATIN_LOG_WARNING,
                    "option memory: %d of %zu images %s coarser, in %.3g of %.3g MB", coarser,
                    images->count, coarser > 1 ? "are" : "is", out->bytes / 1e6, out->full / 1e6);
    free(images->held);
    *images = (struct load_images){0};
}
