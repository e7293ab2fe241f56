// SPDX-License-Identifier: Apache-2.0
// Part of light.h: how lights are drawn around a place that sees but a part of them. Of the samples
// of an environment that its sun leaves, a fraction goes to bins of equal solid angle, the others
// to where it is bright.
#ifndef LIGHT_SEEN_H
#define LIGHT_SEEN_H

#include <stdbool.h>
#include <stdint.h>

#include "base/vec.h"

struct light;
struct light_sample;
struct satin_scene;

enum { LIGHT_WINDOW_SIDE = 32, LIGHT_WINDOW_BINS = LIGHT_WINDOW_SIDE * LIGHT_WINDOW_SIDE };
struct light_window {
    float fraction;    // of the samples, in [0, 1)
    const float *cdf;  // of the bins, row by row, as sample_cdf_build has it
};

// Up to this many lights are weighed for each point; beyond, they are chosen through a tree.
enum { LIGHT_WEIGHED_MAX = 16 };
// What is seen; NULL: all.
struct light_seen {
    const struct light_window *window;  // of the environment
    const float *fraction;              // of each light, of what light_estimate expects; > 0
};
#define LIGHT_SEEN_ALL ((struct light_seen){NULL, NULL})

// An estimate of the irradiance (luminance) at p; 0 only if the light brings none (light.c).
float light_estimate(const struct satin_scene *scene, const struct light *light, vec3 p);
// Chooses a light for direct lighting at p; *probability > 0. Needs light_count > 0. Fractions are
// for scenes of up to LIGHT_WEIGHED_MAX lights.
uint32_t light_choose(const struct satin_scene *scene, vec3 p, struct light_seen seen, float u,
                      float *probability);
float light_choose_probability(const struct satin_scene *scene, vec3 p, struct light_seen seen,
                               uint32_t light);
// The probabilities of all lights, where there are up to LIGHT_WEIGHED_MAX.
void light_choose_weigh(const struct satin_scene *scene, vec3 p, struct light_seen seen,
                        float probability[LIGHT_WEIGHED_MAX]);
// As light_sample, which draws as if all were seen.
bool light_sample_seen(const struct satin_scene *scene, uint32_t i, struct light_seen seen, vec3 p,
                       float u, float v, struct light_sample *out);

// The direction (world) of u, v in [0, 1) within a bin; rows and columns run by u and v of
// sample_uniform_sphere.
vec3 light_window_direction(int bin, float u, float v);
// As light_sample and light_pdf for the environment, which must be there. NULL: the whole is seen.
bool light_environment_sample(const struct satin_scene *scene, const struct light_window *window,
                              float u, float v, struct light_sample *out);
float light_environment_pdf(const struct satin_scene *scene, const struct light_window *window,
                            vec3 wi);

#endif
