// SPDX-License-Identifier: Apache-2.0
// Part of light.h: a clear sky with the sun.
//
// Units are those of Mitsuba 3's sunsky: a value of 1 is a luminance of 683 lm/W times the integral
// of y, which is 73 kcd/m^2.
#ifndef LIGHT_SKY_H
#define LIGHT_SKY_H

#include "base/arena.h"
#include "base/vec.h"

struct image;

// The range of turbidity for which the model was fitted.
#define SKY_TURBIDITY_MIN 1.0f
#define SKY_TURBIDITY_MAX 10.0f

#define SKY_SUN_APERTURE 0.5358f  // angle that the sun subtends, degrees
#define SKY_HORIZON 128           // the row of the image of a sky that is the horizon

struct sky {
    float turbidity;
    rgb albedo;  // of the ground, in [0, 1]
    vec3 sun;    // direction towards it, unit, y up; not below the horizon
};

// Tabulates the sky as an image for an envmap, in linear sRGB and black below the horizon. False if
// there is no memory.
bool light_sky_image(struct arena *arena, const struct sky *sky, struct image *out);
// The mean radiance of the sun's disc at its elevation, if it subtends SKY_SUN_APERTURE.
rgb light_sky_sun(const struct sky *sky);

#endif
