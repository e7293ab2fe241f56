// SPDX-License-Identifier: Apache-2.0
// The daylight of Hosek and Wilkie [2012, an analytic model for full spectral sky-dome radiance].
// The radiance of each channel is a brightness times a distribution over the angle to the zenith
// and the angle to the sun, equations 8 to 10. Brightness and distribution are polynomials in the
// cube root of the sun's elevation (equation 11), and linear between integer turbidities and in the
// albedo of the ground. The sun is that of their solar radiance function [2013], as a mean over its
// disc.
#include "light/light.h"
#include "light/light_sky_tables.h"

enum { SKY_COLUMNS = 512, SKY_ROWS = 2 * SKY_HORIZON + 1 };

// The published brightness times this is the radiance: one over the integral of y [nm].
static const double per_brightness = 1.0 / 106.7502594;

// One channel of the sky.
struct dome {
    double brightness, c[SKY_SHAPE];
};

// The part of a turbidity above the integer one of the table's row *row, in [0, 1].
static double turbidity_fraction(float turbidity, int *row) {
    const double at =
        (double)clampf(turbidity, SKY_TURBIDITY_MIN, SKY_TURBIDITY_MAX) - SKY_TURBIDITY_MIN;
    *row = (int)fmin(at, SKY_TURBIDITIES - 2);
    return at - *row;
}

// The cube root of the sun's elevation, as a fraction of 90 degrees.
static double elevation_root(const struct sky *sky) {
    return cbrt(asin((double)clampf(sky->sun.y, 0.0f, 1.0f)) / (0.5 * M_PI));
}

// The Bernstein polynomials of degree five.
static void bezier_weights(double x, double out[SKY_NODES]) {
    static const double binomial[SKY_NODES] = {1.0, 5.0, 10.0, 10.0, 5.0, 1.0};
    for (int i = 0; i < SKY_NODES; i++)
        out[i] = binomial[i] * pow(x, i) * pow(1.0 - x, SKY_NODES - 1 - i);
}

static void domes(const struct sky *sky, struct dome out[3]) {
    const double albedo[3] = {(double)sky->albedo.r, (double)sky->albedo.g, (double)sky->albedo.b};
    int row;
    double node[SKY_NODES];
    const double fraction = turbidity_fraction(sky->turbidity, &row);
    bezier_weights(elevation_root(sky), node);
    for (int k = 0; k < 3; k++) {
        out[k] = (struct dome){0};
        for (int corner = 0; corner < 4; corner++) {
            const int t = row + corner / 2, ground = corner % 2;
            const double weight =
                (corner / 2 ? fraction : 1.0 - fraction) * (ground ? albedo[k] : 1.0 - albedo[k]);
            for (int n = 0; n < SKY_NODES; n++) {
                const float *shape = &light_sky_shape[t][ground][n][k * SKY_SHAPE];
                out[k].brightness +=
                    weight * node[n] * (double)light_sky_brightness[t][ground][3 * n + k];
                for (int i = 0; i < SKY_SHAPE; i++)
                    out[k].c[i] += weight * node[n] * (double)shape[i];
            }
        }
    }
}

// The radiance in a direction above the horizon, given by the cosine of the angle to the zenith and
// by the angle gamma to the sun.
static float dome_at(const struct dome *d, double cosine, double gamma) {
    const double *c = d->c, cos_gamma = cos(gamma);
    const double glow =
        (1.0 + cos_gamma * cos_gamma) / pow(1.0 + c[8] * c[8] - 2.0 * c[8] * cos_gamma, 1.5);
    const double zenith = 1.0 + c[0] * exp(c[1] / (cosine + 0.01));
    const double sun = c[2] + c[3] * exp(c[4] * gamma) + c[5] * cos_gamma * cos_gamma +
                       c[6] * glow + c[7] * sqrt(cosine);
    return (float)fmax(per_brightness * d->brightness * zenith * sun, 0.0);
}

bool light_sky_image(struct arena *arena, const struct sky *sky, struct image *out) {
    float *texel = arena_array(arena, (size_t)SKY_COLUMNS * SKY_ROWS * 3, sizeof *texel);
    if (!texel) return false;
    struct dome dome[3];
    domes(sky, dome);
    for (int row = 0; row < SKY_ROWS; row++)
        for (int column = 0; column < SKY_COLUMNS; column++) {
            float *t = texel + 3 * (row * SKY_COLUMNS + column);
            const double theta = M_PI * row / (SKY_ROWS - 1),
                         phi = 2.0 * M_PI * (column + 0.5) / SKY_COLUMNS;
            const vec3 w = v3((float)(sin(theta) * sin(phi)), (float)cos(theta),
                              (float)(-sin(theta) * cos(phi)));
            const double gamma = 2.0 * asin(fmin(0.5 * (double)sqrtf(v3_dist2(w, sky->sun)), 1.0));
            for (int k = 0; k < 3; k++)
                t[k] = row <= SKY_HORIZON ? dome_at(&dome[k], fmax(cos(theta), 0.0), gamma) : 0.0f;
        }
    *out = scene_image_make(SKY_COLUMNS, SKY_ROWS, 3, texel);
    return true;
}

// A cubic through p[1] and p[2], with the slopes of their neighbours [Catmull and Rom 1974].
static double catmull_rom(const double p[4], double t) {
    const double second = 2.0 * p[0] - 5.0 * p[1] + 4.0 * p[2] - p[3],
                 third = 3.0 * (p[1] - p[2]) + p[3] - p[0];
    return p[1] + 0.5 * t * (p[2] - p[0] + t * (second + t * third));
}

// The cube root of the radiance is interpolated: it is nearly linear where the sun sets.
rgb light_sky_sun(const struct sky *sky) {
    int row;
    const double fraction = turbidity_fraction(sky->turbidity, &row);
    const double at = elevation_root(sky) * (SKY_SUN_NODES - 1);
    const int node = (int)fmin(at, SKY_SUN_NODES - 2);
    double L[3];
    for (int k = 0; k < 3; k++) {
        double p[4];
        for (int i = 0; i < 4; i++) {
            const int from = (int)fmin(fmax(node - 1 + i, 0), SKY_SUN_NODES - 1);
            p[i] = cbrt((1.0 - fraction) * (double)light_sky_sun_radiance[row][3 * from + k] +
                        fraction * (double)light_sky_sun_radiance[row + 1][3 * from + k]);
        }
        L[k] = pow(fmax(catmull_rom(p, at - node), 0.0), 3.0);
    }
    return rgb_make((float)L[0], (float)L[1], (float)L[2]);
}
