// SPDX-License-Identifier: Apache-2.0
// Private to shade/: eye rays followed through ideal specular surfaces.
#ifndef SHADE_EYE_H
#define SHADE_EYE_H

#include "shade/shade.h"

enum { SHADE_VERTICES = 12 };

// A surface point that the eye sees, directly or through ideal specular surfaces.
struct shade_vertex {
    struct gather_point point;
    rgb T;        // throughput to the eye
    float pixel;  // width of a projected pixel there
};

// What an eye ray was drawn with.
struct shade_camera_sample {
    float spread;  // its width per distance
    float weight;  // that the film's filter gives to the sample
    vec2 film;     // where it passes the film, in pixels of all of it
    vec2 at;       // random numbers for where it leaves the lens
};

struct shade_eye {
    struct shade_vertex vertex[SHADE_VERTICES];
    int count;
    rgb emission;  // emitted light seen
    struct shade_camera_sample camera;
    // The first surface, for channels that are not light.
    bool hit;
    struct gather_point first;  // of a blend one component, drawn by its weight
};

// Follows the eye ray of a sample; reflection and refraction are both followed at the first ideal
// specular surfaces, one of them is drawn at deeper ones.
void shade_eye_trace(const struct shade *shade, int x, int y, struct sampler *sampler,
                     struct shade_eye *out);
// The eye ray itself.
struct ray shade_eye_ray(const struct shade *shade, int x, int y, struct sampler *sampler,
                         struct shade_camera_sample *camera);
// The sampler of a sample: its numbers depend on the seed, the pixel and the index alone.
struct sampler shade_eye_sampler(const struct gather *g, int x, int y, uint32_t index,
                                 enum rng_stream stream);
// The table for the point's material and side, and its colour channels; or NULL.
const struct brdf_range *shade_table(const struct shade *shade, const struct gather_point *p,
                                     int *channels);

#endif
