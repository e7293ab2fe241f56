// SPDX-License-Identifier: Apache-2.0
// Private to render/: Cryptomatte layers of an image.
#ifndef RENDER_MATTES_H
#define RENDER_MATTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "satin/options.h"
#include "shade/shade.h"

struct satin_film;
struct satin_scene;

enum {
    MATTES = 2,       // of objects and of materials
    MATTE_RANKS = 6,  // pairs of an id and its coverage in the film
    MATTE_IDS = 8,    // of a pixel, of which the film has the largest
    MATTE_CHANNELS = 2 * MATTE_RANKS
};

// What a pixel shows: ids, each with the sum of the weights of its samples. 0 is no id.
struct matte_pixel {
    uint32_t id[MATTE_IDS];
    float weight[MATTE_IDS];
};

// All zero: there are none.
struct render_mattes {
    uint32_t *id[MATTES];  // of each shape of the scene; NULL: this matte is not wanted
    struct matte_pixel *pixel[MATTES];
};

// The bits of a float that stands for a name: its MurmurHash3, with an exponent of a normal number.
uint32_t matte_id(const char *name);
// Adds a sample to a pixel that shows an id. If the pixel has MATTE_IDS others, that of the least
// weight gives way unless it weighs more.
void matte_add(struct matte_pixel *pixel, uint32_t id, float weight);
// The ids of a pixel and their coverage, the largest first, as the channels of the film have them:
// the id of rank 0, its coverage, the id of rank 1 and so on. `scale` is from weights to means.
void matte_ranks(const struct matte_pixel *pixel, float scale, float out[MATTE_CHANNELS]);

// Makes the mattes that the options ask for. False if there is no memory.
bool render_mattes_make(struct render_mattes *mattes, const struct satin_scene *scene,
                        const satin_options *options);
void render_mattes_destroy(struct render_mattes *mattes);  // a zeroed one is allowed
// Adds a sample of pixel `at`.
void render_mattes_add(struct render_mattes *mattes, size_t at, const struct shade_sample *sample);
// Sets the attributes of the film by which a reader finds the mattes and the names of ids. False if
// there is no memory.
bool render_mattes_describe(const struct satin_scene *scene, const satin_options *options,
                            struct satin_film *film);

#endif
