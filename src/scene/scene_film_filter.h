// SPDX-License-Identifier: Apache-2.0
// The film of a scene, and the filter by which its pixels weight samples. Included by scene.h.
#ifndef SCENE_FILM_FILTER_H
#define SCENE_FILM_FILTER_H

#include <stdbool.h>

enum filter_kind { FILTER_BOX = 0, FILTER_TENT, FILTER_GAUSSIAN, FILTER_CUBIC, FILTER_LANCZOS };

struct scene_film {
    int width, height;  // full film
    int crop_x, crop_y, crop_width, crop_height;
    enum filter_kind filter;
    float radius, stddev;  // in pixels
    float b, c;            // cubic: its parameters
    bool alpha;            // whether the image has a channel of coverage
    bool full_float;       // whether a file of the image has 32-bit floats in all channels
};

// Draws an offset from a pixel's centre by u from a film filter without negative lobes, truncated
// so that the position stays inside [lo, hi), the crop window. At the border that equals a
// renormalised filter.
float scene_film_filter_sample(const struct scene_film *film, float centre, float lo, float hi,
                               float u);

// scene_film_filter_sample by tables, for every filter. A sample counts `weight` times. That is 1
// for a filter without negative lobes; otherwise it is 1 on average and negative in the lobes.
enum { FILM_FILTER_STEPS = 1024 };
struct scene_film_filter {
    const struct scene_film *film;
    bool wide;                             // see scene_film_filter_widen
    float inverse[FILM_FILTER_STEPS + 2];  // offset at u = i / FILM_FILTER_STEPS
    // With negative lobes: the integrals from the left end of the filter and of its absolute value.
    float sum[FILM_FILTER_STEPS + 1], size[FILM_FILTER_STEPS + 1];
};
struct scene_film_offset {
    float x, weight;
};
// Whether the filter has negative values.
bool scene_film_filter_has_lobes(const struct scene_film *film);
void scene_film_filter_make(const struct scene_film *film, struct scene_film_filter *out);
// From now on offsets near the ends of the filter are drawn twice as often, with weights from .5 to
// 1.5, if it falls to zero there: its tails see what may be most of the light of a dark pixel.
void scene_film_filter_widen(struct scene_film_filter *filter);
struct scene_film_offset scene_film_filter_offset(const struct scene_film_filter *filter,
                                                  float centre, float lo, float hi, float u);

#endif
