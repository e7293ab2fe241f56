// SPDX-License-Identifier: Apache-2.0
// Private to render/: the option `memory`. What must be there is estimated before the work begins:
// the program, the scene, and the sums of the pixels or, before these, the sites of records. Of the
// rest a quarter is for scratch memory of threads, two thirds for the photons while their maps are
// built, and what the maps leave of three quarters for records. All of it depends on the scene and
// the options alone, and so does the image; the threads, on which it does not depend, are limited
// in number.
#ifndef RENDER_MEMORY_H
#define RENDER_MEMORY_H

#include "photon/photon.h"
#include "satin/film.h"
#include "scene/scene.h"

struct render;

// In bytes. Without a limit all are 0.
struct render_memory {
    double limit;       // of the options
    double kept;        // program, scene, film, what is visible of the lights
    double found;       // sites of records while they are found, or the sums of the pixels
    double compared;    // sites while adaptive caching compares the records at them
    double fixed;       // what is kept and the larger one of these
    double thread;      // of each thread
    double visibility;  // of the lights; it is part of `kept`
    double photons;     // of making the maps, at the most
    struct photon_memory per_path;
};

// Estimates what must be there, and limits the threads of r->options. SATIN_ERROR_INPUT, logged
// with the bytes that are needed, if that is more than the limit.
satin_status render_memory_begin(struct render *r);
// Limits the photons of r->options, with a warning. To be called when all ranks have begun.
// SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status render_memory_photons(struct render *r);
// Reduces the factors of counts whose fraction is 1 to what fits; 1 always fits.
struct render_photon_counts;
void render_memory_grow(struct render *r, struct render_photon_counts *counts);
// Limits the memory of a cache, which is one of so many.
struct cache;
void render_memory_limit_cache(const struct render *r, struct cache *cache, int caches);
// The most points that adaptive caching may compare in a view.
size_t render_memory_adapted(const struct render *r);
// Warns if the cache was limited, and sets statistics.
void render_memory_end(struct render *r);

#endif
