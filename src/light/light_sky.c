// SPDX-License-Identifier: Apache-2.0
// The daylight of [Preetham, Shirley and Smits 1999]: the sky's luminance and chromaticity as a
// product of two exponentials [Perez et al. 1993], whose coefficients are linear in the turbidity;
// the sun as a black body behind the absorbing air. Deviation: the paper has tables over
// wavelength; here Planck's law gives the sun's spectrum and a Gaussian the absorption of ozone.
// Absorption by water vapour and mixed gases is left out, as it lies beyond the red. Units are
// those of Mitsuba 3's sunsky: a value of 1 is a luminance of 683 lm/W times the integral of y,
// which is 73 kcd/m^2.
#include "light/light.h"

enum { SKY_COLUMNS = 512, SKY_ROWS = 257 };  // an odd number of rows: one is the horizon

// The luminance, in kcd/m^2, of a value of 1.
static const double unit = 683.0 * 106.7502594 * 1e-3;

// One of the quantities Y, x or y over the sky.
struct dome {
    double zenith, c[5], at_zenith;
};

// The distribution over the angle to the zenith, given by its cosine, and the angle gamma to the
// sun.
static double perez(const double c[5], double cosine, double gamma) {
    double cos_gamma = cos(gamma);
    return (1.0 + c[0] * exp(c[1] / fmax(cosine, 1e-4))) *
           (1.0 + c[2] * exp(c[3] * gamma) + c[4] * cos_gamma * cos_gamma);
}

static struct dome dome_make(double turbidity, double theta, const double fit[5][2],
                             double zenith) {
    struct dome d = {.zenith = zenith};
    for (int i = 0; i < 5; i++) d.c[i] = fit[i][0] * turbidity + fit[i][1];
    d.at_zenith = perez(d.c, 1.0, theta);
    return d;
}

static double dome_at(const struct dome *d, double cosine, double gamma) {
    return d->zenith * perez(d->c, cosine, gamma) / d->at_zenith;
}

// The chromaticity of the zenith: cubic in the sun's zenith angle and quadratic in the turbidity.
static double zenith_chromaticity(double turbidity, double t, const double m[3][4]) {
    const double power[3] = {turbidity * turbidity, turbidity, 1.0};
    double sum = 0.0;
    for (int i = 0; i < 3; i++)
        sum += power[i] * (((m[i][0] * t + m[i][1]) * t + m[i][2]) * t + m[i][3]);
    return sum;
}

// The distributions of Y, x and y [Preetham et al. 1999, appendix A.2].
static void domes(double turbidity, double theta, struct dome out[3]) {
    static const double fit[3][5][2] = {
        {{.1787, -1.4630}, {-.3554, .4275}, {-.0227, 5.3251}, {.1206, -2.5771}, {-.0670, .3703}},
        {{-.0193, -.2592}, {-.0665, .0008}, {-.0004, .2125}, {-.0641, -.8989}, {-.0033, .0452}},
        {{-.0167, -.2608}, {-.0950, .0092}, {-.0079, .2102}, {-.0441, -1.6537}, {-.0109, .0529}}};
    static const double zenith_x[3][4] = {{.00166, -.00375, .00209, 0.0},
                                          {-.02903, .06377, -.03202, .00394},
                                          {.11693, -.21196, .06052, .25886}};
    static const double zenith_y[3][4] = {{.00275, -.00610, .00317, 0.0},
                                          {-.04214, .08970, -.04153, .00516},
                                          {.15346, -.26756, .06670, .26688}};
    double chi = (4.0 / 9.0 - turbidity / 120.0) * (M_PI - 2.0 * theta);
    double Y = (4.0453 * turbidity - 4.9710) * tan(chi) - 0.2155 * turbidity + 2.4192;
    out[0] = dome_make(turbidity, theta, fit[0], fmax(Y, 0.0) / unit);
    out[1] = dome_make(turbidity, theta, fit[1], zenith_chromaticity(turbidity, theta, zenith_x));
    out[2] = dome_make(turbidity, theta, fit[2], zenith_chromaticity(turbidity, theta, zenith_y));
}

static rgb sky_at(const struct dome d[3], double cosine, double gamma) {
    return spectrum_chromaticity(dome_at(&d[1], cosine, gamma), dome_at(&d[2], cosine, gamma),
                                 fmax(dome_at(&d[0], cosine, gamma), 0.0));
}

bool sky_image(struct arena *arena, const struct sky *sky, struct image *out) {
    float *texel = arena_array(arena, (size_t)SKY_COLUMNS * SKY_ROWS * 3, sizeof *texel);
    if (!texel) return false;
    struct dome dome[3];
    domes((double)sky->turbidity, acos((double)clampf(sky->sun.y, 0.0f, 1.0f)), dome);
    for (int row = 0; row < SKY_ROWS; row++)
        for (int column = 0; column < SKY_COLUMNS; column++) {
            float *t = texel + 3 * (row * SKY_COLUMNS + column);
            double theta = M_PI * row / (SKY_ROWS - 1),
                   phi = 2.0 * M_PI * (column + 0.5) / SKY_COLUMNS;
            vec3 w = v3((float)(sin(theta) * sin(phi)), (float)cos(theta),
                        (float)(-sin(theta) * cos(phi)));
            rgb c = rgb_grey(0.0f);
            double gamma = 2.0 * asin(fmin(0.5 * (double)v3_len(v3_sub(w, sky->sun)), 1.0));
            if (row <= SKY_ROWS / 2) c = sky_at(dome, cos(theta), gamma);
            t[0] = c.r, t[1] = c.g, t[2] = c.b;
        }
    *out = (struct image){SKY_COLUMNS, SKY_ROWS, 3, texel};
    return true;
}

// ---- The sun ------------------------------------------------------------------------------------

struct air {
    double mass;         // relative mass of the air along the ray; 1 from the zenith
    double haze, ozone;  // Angstrom's coefficient; cm at normal pressure
};

// The fraction of sunlight that the air transmits [Preetham et al. 1999, appendix A.1].
static double transmitted(const void *ctx, double nanometres) {
    const struct air *air = ctx;
    double um = 1e-3 * nanometres, band = (nanometres - 600.0) / 52.0;
    double rayleigh = 0.008735 * pow(um, -4.08), aerosol = air->haze * pow(um, -1.3);
    double ozone = air->ozone * 0.125 * exp(-0.5 * band * band);
    return exp(-air->mass * (rayleigh + aerosol + ozone));
}

rgb sky_sun(const struct sky *sky) {
    double cosine = (double)clampf(sky->sun.y, 0.0f, 1.0f), degrees = acos(cosine) * 180.0 / M_PI;
    struct air air = {.mass = 1.0 / (cosine + 0.15 * pow(93.885 - degrees, -1.253)),
                      .haze = 0.04608 * (double)sky->turbidity - 0.04586,
                      .ozone = 0.35};
    return spectrum_filtered(5778.0, transmitted, &air);
}
