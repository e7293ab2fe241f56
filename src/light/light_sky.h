// SPDX-License-Identifier: Apache-2.0
// Part of light.h: a clear sky with its sun.
#ifndef LIGHT_SKY_H
#define LIGHT_SKY_H

#include "base/arena.h"
#include "base/vec.h"

struct image;

// Where the models were fitted.
#define SKY_TURBIDITY_MIN 2.0f
#define SKY_TURBIDITY_MAX 10.0f

#define SKY_SUN_APERTURE 0.5338f  // that the sun fills, degrees

struct sky {
    float turbidity;
    vec3 sun;  // direction towards it, unit, y up; not below the horizon
};

// Tabulates the sky as an image for an envmap: linear sRGB, black below the horizon. False without
// memory.
bool sky_image(struct arena *arena, const struct sky *sky, struct image *out);
// Radiance of the sun's disc at the elevation that its direction has.
rgb sky_sun(const struct sky *sky);

#endif
