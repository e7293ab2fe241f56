// SPDX-License-Identifier: Apache-2.0
// Part of light_sky.c: the fitted coefficients of its model, for red, green and blue.
#ifndef LIGHT_SKY_TABLES_H
#define LIGHT_SKY_TABLES_H

enum {
    SKY_TURBIDITIES = 10,  // turbidity 1, 2, ... 10
    SKY_NODES = 6,         // control points of the polynomial over the sun's elevation
    SKY_SHAPE = 9,         // coefficients of the distribution over the sky
    SKY_SUN_NODES = 16     // elevations (i / 15)^3 of 90 degrees
};

// Coefficients of red come first, then those of green and of blue. The second index is the albedo
// of the ground, 0 or 1.
extern const float light_sky_shape[SKY_TURBIDITIES][2][SKY_NODES][3 * SKY_SHAPE];
// The brightness, red, green and blue for each control point.
extern const float light_sky_brightness[SKY_TURBIDITIES][2][SKY_NODES * 3];
// The mean radiance of the sun's disc, red, green and blue for each elevation, in the units of
// light_sky.h.
extern const float light_sky_sun_radiance[SKY_TURBIDITIES][SKY_SUN_NODES * 3];

#endif
