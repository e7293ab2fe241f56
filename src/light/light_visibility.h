// SPDX-License-Identifier: Apache-2.0
// Part of light.h: how lights are drawn around a point that sees but some of them. Of the samples
// of an environment that its sun leaves, a fraction goes to bins of equal solid angle, the others
// to where it is bright.
#ifndef LIGHT_VISIBILITY_H
#define LIGHT_VISIBILITY_H

#include <stdbool.h>
#include <stdint.h>

#include "base/vec.h"

struct light;
struct light_sample;
struct satin_scene;

enum {
    LIGHT_HISTOGRAM_SIDE = 32,
    LIGHT_HISTOGRAM_BINS = LIGHT_HISTOGRAM_SIDE * LIGHT_HISTOGRAM_SIDE,
    LIGHT_HISTOGRAM_CUTS = 64
};
// The visible-environment histogram: directions of the world in which the environment is visible.
struct light_histogram {
    float fraction;       // of the samples, in [0, 1)
    const float *cdf;     // of the bins, row by row, as sample_cdf_build has it
    const uint32_t *cut;  // LIGHT_HISTOGRAM_CUTS + 1, as sample_cuts_build has them
};

// Up to this many lights are weighed for each point; beyond, they are chosen through a tree.
enum { LIGHT_WEIGHED_MAX = 16 };
// What is visible of the lights from around a point; NULL: all.
struct light_visibility {
    const struct light_histogram *histogram;  // of the environment
    const float *fraction;                    // of each light, of what light_estimate expects; > 0
};
#define LIGHT_ALL_VISIBLE ((struct light_visibility){NULL, NULL})

// An estimate of the irradiance (luminance) at p; 0 only if the light brings none (light.c).
float light_estimate(const struct satin_scene *scene, const struct light *light, vec3 p);
// Chooses a light for direct lighting at p; *probability > 0. Needs light_count > 0. Fractions are
// for scenes of up to LIGHT_WEIGHED_MAX lights.
uint32_t light_choose(const struct satin_scene *scene, vec3 p, struct light_visibility visibility,
                      float u, float *probability);
float light_choose_probability(const struct satin_scene *scene, vec3 p,
                               struct light_visibility visibility, uint32_t light);
// The probabilities of all lights, where there are up to LIGHT_WEIGHED_MAX.
void light_choose_weigh(const struct satin_scene *scene, vec3 p, struct light_visibility visibility,
                        float probability[LIGHT_WEIGHED_MAX]);
// As light_sample, which draws as if all of the light were visible.
bool light_sample_visible(const struct satin_scene *scene, uint32_t i,
                          struct light_visibility visibility, vec3 p, float u, float v,
                          struct light_sample *out);

// The direction (world) of u, v in [0, 1) within a bin; rows and columns run by u and v of
// sample_uniform_sphere.
vec3 light_histogram_direction(int bin, float u, float v);
// As light_sample and light_pdf for the environment, which must be there. NULL: all of it is
// visible.
bool light_environment_sample(const struct satin_scene *scene,
                              const struct light_histogram *histogram, float u, float v,
                              struct light_sample *out);
float light_environment_pdf(const struct satin_scene *scene,
                            const struct light_histogram *histogram, vec3 wi);

#endif
