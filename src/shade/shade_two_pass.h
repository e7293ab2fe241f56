// SPDX-License-Identifier: Apache-2.0
// Private to shade/: light at one vertex.
#ifndef SHADE_TWO_PASS_H
#define SHADE_TWO_PASS_H

#include "shade/shade_eye.h"

struct shade_job {
    const struct shade *shade;
    const struct shade_vertex *vertex;
    struct shade_worker *worker;
    struct sampler sampler;
    struct gather_light_samples light_samples;
    uint64_t stream;           // random numbers of this vertex of this sample
    uint64_t pixel_stream;     // random numbers that all samples of the pixel have in common
    struct shade_sample *out;  // the layers to which light is added, times the vertex's throughput
};

// Integrator two-pass: adds direct, caustic, cached, gathered and importance-sampled light at the
// vertex.
void shade_vertex_two_pass(struct shade_job *job);

#endif
