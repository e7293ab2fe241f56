// SPDX-License-Identifier: Apache-2.0
// Part of scene.h: how the environment is drawn around a place that sees but a part of it, as
// through a window. Of the samples that a sun leaves, a share goes to bins of equal solid angle,
// the others to where the environment is bright.
#ifndef SCENE_LIGHT_WINDOW_H
#define SCENE_LIGHT_WINDOW_H

#include "base/vec.h"

struct light_sample;
struct satin_scene;

enum { LIGHT_WINDOW_SIDE = 32, LIGHT_WINDOW_BINS = LIGHT_WINDOW_SIDE * LIGHT_WINDOW_SIDE };
struct light_window {
    float share;       // in [0, 1)
    const float *cdf;  // of the bins, row by row, as sample_cdf_build has it
};
// The direction (world) of u, v in [0, 1) within a bin; rows and columns run by u and v of
// sample_uniform_sphere.
vec3 light_window_direction(int bin, float u, float v);
// As light_sample and light_pdf for the environment, which must be there. NULL: the whole is seen.
bool light_environment_sample(const struct satin_scene *scene, const struct light_window *window,
                              float u, float v, struct light_sample *out);
float light_environment_pdf(const struct satin_scene *scene, const struct light_window *window,
                            vec3 wi);

#endif
