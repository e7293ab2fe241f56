// SPDX-License-Identifier: Apache-2.0
// Private to render/: Cryptomatte layers of an image.
#ifndef RENDER_CRYPTOMATTE_H
#define RENDER_CRYPTOMATTE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "satin/options.h"
#include "shade/shade.h"

struct satin_film;
struct satin_scene;

enum {
    CRYPTOMATTES = 2,       // of objects and of materials
    CRYPTOMATTE_RANKS = 6,  // pairs of an id and its coverage in the film
    CRYPTOMATTE_IDS = 8,    // of a pixel, of which the film has the largest
    CRYPTOMATTE_CHANNELS = 2 * CRYPTOMATTE_RANKS
};

// What a pixel shows: ids, each with the sum of the weights of its samples. 0 is no id.
struct cryptomatte_pixel {
    uint32_t id[CRYPTOMATTE_IDS];
    float weight[CRYPTOMATTE_IDS];
};

// All zero: there are none.
struct render_cryptomatte {
    uint32_t *id[CRYPTOMATTES];  // of each shape of the scene; NULL: this matte is not wanted
    struct cryptomatte_pixel *pixel[CRYPTOMATTES];
};

// The bits of a float that stands for a name: its MurmurHash3, with an exponent of a normal number.
uint32_t render_cryptomatte_id(const char *name);
// Adds a sample to a pixel that shows an id. If the pixel has CRYPTOMATTE_IDS others, that of the
// least weight gives way unless it weighs more.
void render_cryptomatte_pixel_add(struct cryptomatte_pixel *pixel, uint32_t id, float weight);
// The ids of a pixel and their coverage, the largest first, as the channels of the film have them:
// the id of rank 0, its coverage, the id of rank 1 and so on. `scale` is from weights to means.
void render_cryptomatte_ranks(const struct cryptomatte_pixel *pixel, float scale,
                              float out[CRYPTOMATTE_CHANNELS]);

// Makes the mattes that the options ask for. False if there is no memory.
bool render_cryptomatte_make(struct render_cryptomatte *mattes, const struct satin_scene *scene,
                             const satin_options *options);
void render_cryptomatte_destroy(struct render_cryptomatte *mattes);  // a zeroed one is allowed
// Adds a sample of pixel `at`.
void render_cryptomatte_add(struct render_cryptomatte *mattes, size_t at,
                            const struct shade_sample *sample);
// Sets the attributes of the film by which a reader finds the mattes and the names of ids. False if
// there is no memory.
bool render_cryptomatte_describe(const struct satin_scene *scene, const satin_options *options,
                                 struct satin_film *film);

#endif
