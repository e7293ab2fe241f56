// SPDX-License-Identifier: Apache-2.0
// Private to shade/: light at one vertex.
#ifndef SHADE_TWO_PASS_H
#define SHADE_TWO_PASS_H

#include "shade/shade_eye.h"

// The light of one vertex: what it is computed from, and where it is added.
struct shade_lighting {
    const struct shade *shade;
    const struct shade_vertex *vertex;
    struct shade_worker *worker;
    struct sampler sampler;
    struct shade_sample_counts samples;
    uint64_t stream;           // random numbers of this vertex of this sample
    uint64_t pixel_stream;     // random numbers that all samples of the pixel have in common
    struct shade_sample *out;  // the layers to which light is added, times the vertex's throughput
    struct light_visibility visibility;  // of the lights, while shade_direct finds them
};

// Adds light that is from a record.
static inline void shade_add_cached(struct shade_lighting *lighting, enum shade_layer layer,
                                    rgb L) {
    lighting->out->layer[layer] = rgb_fma(lighting->out->layer[layer], lighting->vertex->T, L);
}

// Adds light that is from no record.
static inline void shade_add_uncached(struct shade_lighting *lighting, enum shade_layer layer,
                                      rgb L) {
    shade_add_cached(lighting, layer, L);
    lighting->out->uncached = rgb_fma(lighting->out->uncached, lighting->vertex->T, L);
    if (layer != SHADE_INDIRECT_GLOSSY) return;
    lighting->out->uncached_glossy =
        rgb_fma(lighting->out->uncached_glossy, lighting->vertex->T, L);
    lighting->out->sampled_glossy = true;
}

// Adds direct light (shade_direct.c). `rays` gather rays of the lobes `sampled`, drawn by the
// caller, find lights too. Returns how many BRDF samples of these lobes find lights: those rays,
// and further samples that shade_direct has taken. They are weighted by that number.
int shade_direct(struct shade_lighting *lighting, unsigned sampled, int rays);

// Integrator two-pass: adds direct, caustic, cached, gathered and importance-sampled light at the
// vertex.
void shade_vertex_two_pass(struct shade_lighting *lighting);

#endif
