// SPDX-License-Identifier: Apache-2.0
// Part of scene.h: spectra over wavelength, and their conversion to linear sRGB as in Mitsuba 3's
// RGB mode.
#ifndef SCENE_SPECTRUM_H
#define SCENE_SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>

#include "base/vec.h"

enum { SPECTRUM_CIE_FIRST = 360, SPECTRUM_CIE_STEP = 5, SPECTRUM_CIE_ROWS = 95 };
// x, y, z of the observer and D65 (scene_spectrum_cie.c).
extern const float scene_spectrum_cie[SPECTRUM_CIE_ROWS][4];

// A piecewise linear spectrum, 0 outside of its wavelengths [nm], which ascend. Arrays are from
// malloc.
struct spectrum {
    double *wavelength, *value;
    size_t count;
};
void scene_spectrum_free(struct spectrum *spectrum);

// The linear sRGB of a spectrum of light or, under D65, of a reflectance. Negative values, outside
// of the gamut, become 0.
rgb scene_spectrum_to_rgb(const struct spectrum *spectrum, bool light);
// Linear sRGB of a black body's radiance [W m^-2 sr^-1 nm^-1] between two wavelengths [nm].
rgb scene_spectrum_blackbody(double kelvin, double first, double last);

#endif
