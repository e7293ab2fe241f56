// SPDX-License-Identifier: Apache-2.0
// Integrates spectra against the standard observer. The steps and the scale of the integral are
// those of Mitsuba 3, measured on its RGB mode, so that colours agree to the last digits.
#include "scene/scene_spectrum.h"

#include <math.h>
#include <stdlib.h>

enum { SPECTRUM_STEPS = 1000 };
// The integral of y over wavelength, by which a constant spectrum of 1 has luminance 1; and the
// divisor of D65 by which white under it has luminance 1.
static const double y_integral = 106.7502593994140625, d65_scale = 98.99741751876255;

void scene_spectrum_free(struct spectrum *spectrum) {
    free(spectrum->wavelength);
    free(spectrum->value);
    *spectrum = (struct spectrum){0};
}

// Interpolates the CIE's table at a wavelength within its range.
static void observer_at(double wavelength, double out[4]) {
    double at = (wavelength - SPECTRUM_CIE_FIRST) / SPECTRUM_CIE_STEP;
    int i = (int)fmin(fmax(at, 0.0), SPECTRUM_CIE_ROWS - 2);
    for (int k = 0; k < 4; k++) {
        double a = scene_spectrum_cie[i][k], b = scene_spectrum_cie[i + 1][k];
        out[k] = a + (at - i) * (b - a);
    }
}

static double spectrum_value_at(const struct spectrum *s, double wavelength, size_t *at) {
    if (!s->count || wavelength < s->wavelength[0] || wavelength > s->wavelength[s->count - 1])
        return 0.0;
    while (*at + 2 < s->count && s->wavelength[*at + 1] < wavelength) ++*at;
    if (s->count == 1) return s->value[0];
    double a = s->wavelength[*at], b = s->wavelength[*at + 1];
    return s->value[*at] + (wavelength - a) / (b - a) * (s->value[*at + 1] - s->value[*at]);
}

// h c^2 and h c / k in SI units.
static double planck(double nanometres, double kelvin) {
    const double h = 6.62607004e-34, c = 2.99792458e8, k = 1.38064852e-23;
    double l = nanometres * 1e-9;
    return 1e-9 * 2.0 * h * c * c / (pow(l, 5.0) * expm1(h * c / (l * k * kelvin)));
}

// `scale` is the step of an integral, or 1.
static rgb xyz_to_rgb(const double xyz[3], double scale) {
    static const double m[3][3] = {{3.240479, -1.537150, -0.498535},
                                   {-0.969256, 1.875991, 0.041556},
                                   {0.055648, -0.204043, 1.057311}};
    float c[3];
    for (int i = 0; i < 3; i++) {
        double sum = m[i][0] * xyz[0] + m[i][1] * xyz[1] + m[i][2] * xyz[2];
        c[i] = (float)fmax(sum * scale, 0.0);
    }
    return rgb_make(c[0], c[1], c[2]);
}

static double step_wavelength(int i) {
    const double range = SPECTRUM_CIE_STEP * (SPECTRUM_CIE_ROWS - 1);
    return SPECTRUM_CIE_FIRST + range * i / (SPECTRUM_STEPS - 1);
}

// The step of an integral by SPECTRUM_STEPS steps over the integral of y.
static double step_fraction(void) {
    const double range = SPECTRUM_CIE_STEP * (SPECTRUM_CIE_ROWS - 1);
    return range / SPECTRUM_STEPS / y_integral;
}

rgb scene_spectrum_to_rgb(const struct spectrum *spectrum, bool light) {
    double xyz[3] = {0.0, 0.0, 0.0}, row[4];
    size_t at = 0;
    for (int i = 0; i < SPECTRUM_STEPS; i++) {
        double wavelength = step_wavelength(i), y = spectrum_value_at(spectrum, wavelength, &at);
        observer_at(wavelength, row);
        if (!light) y *= row[3] / d65_scale;
        for (int k = 0; k < 3; k++) xyz[k] += row[k] * y;
    }
    return xyz_to_rgb(xyz, step_fraction());
}

rgb scene_spectrum_blackbody(double kelvin, double first, double last) {
    double xyz[3] = {0.0, 0.0, 0.0}, row[4];
    for (int i = 0; i < SPECTRUM_STEPS; i++) {
        const double wavelength = step_wavelength(i);
        if (wavelength < first || wavelength > last) continue;
        observer_at(wavelength, row);
        for (int k = 0; k < 3; k++) xyz[k] += row[k] * planck(wavelength, kelvin);
    }
    return xyz_to_rgb(xyz, step_fraction());
}
