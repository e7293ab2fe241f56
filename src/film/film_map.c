// SPDX-License-Identifier: Apache-2.0
// Pictures of values that are not light: a number per pixel as a colour, or dots over the beauty.
// The colours are a path in Oklab [Ottosson 2020]: lightness grows uniformly while the hue goes
// from blue by red to yellow, so that equal steps look equal, even in grey.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/vec.h"
#include "film/film.h"

// Lightness, hue [rad] and largest chroma of the colours, from the least value to the largest. With
// these chromas the colours are nearly inside sRGB.
static const float LIGHT[2] = {0.18f, 0.96f}, HUE[2] = {-1.75f, 1.95f}, CHROMA = 0.16f;

// The fraction of the values above 0 that are not larger than the lightest value.
static const double TOP_FRACTION = 0.995;

static const rgb DOT = {1.0f, 0.28f, 0.02f};

static float cube(float x) { return x * x * x; }

// Oklab to linear sRGB.
static rgb from_oklab(float L, float a, float b) {
    const float l = cube(L + 0.3963377774f * a + 0.2158037573f * b);
    const float m = cube(L - 0.1055613458f * a - 0.0638541728f * b);
    const float s = cube(L - 0.0894841775f * a - 1.2914855480f * b);
    return rgb_make(4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s,
                    -1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s,
                    -0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s);
}

// The colour of t in [0, 1].
static rgb ramp(float t) {
    const float L = LIGHT[0] + (LIGHT[1] - LIGHT[0]) * t, hue = HUE[0] + (HUE[1] - HUE[0]) * t;
    const float chroma = CHROMA * sqrtf(4.0f * t * (1.0f - t) * 0.75f + 0.25f);
    return from_oklab(L, chroma * cosf(hue), chroma * sinf(hue));
}

static void put_color(unsigned char *pixel, rgb value) {
    const float component[3] = {value.r, value.g, value.b};
    for (int c = 0; c < 3; c++) pixel[c] = film_encode_srgb(component[c]);
}

// The value that TOP_FRACTION of the values above 0 do not exceed; 0 if there are none. `scratch`
// has space for `count`.
static float top_of(const float *value, size_t count, float *scratch) {
    size_t n = 0;
    for (size_t i = 0; i < count; i++)
        if (value[i] > 0.0f && isfinite(value[i])) scratch[n++] = value[i];
    if (n == 0) return 0.0f;
    qsort(scratch, n, sizeof *scratch, array_compare_floats);
    return scratch[(size_t)(TOP_FRACTION * (double)(n - 1))];
}

unsigned char *film_map_pixels(const float *value, size_t count, float *top) {
    float *scratch = malloc(count * sizeof *scratch);
    unsigned char *pixel = scratch ? calloc(count, 3) : NULL;
    if (pixel) {
        const float most = top_of(value, count, scratch);
        for (size_t i = 0; i < count; i++)
            if (value[i] > 0.0f && isfinite(value[i]))
                put_color(&pixel[3 * i], ramp(fminf(value[i] / most, 1.0f)));
        *top = most;
    }
    free(scratch);
    return pixel;
}

satin_status film_write_map(const struct satin_film *film, const float *value, const char *path,
                            struct log log, float *top) {
    float most;
    unsigned char *pixel =
        film_map_pixels(value, (size_t)film->width * (size_t)film->height, &most);
    if (!pixel) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    const satin_status status =
        film_write_pixels(path, &(struct film_pixels){film->width, film->height, 3, pixel}, log);
    if (status == SATIN_OK) *top = most;
    free(pixel);
    return status;
}

satin_status film_write_dots(const struct satin_film *film, const float *dot, const char *path,
                             struct log log) {
    const size_t count = (size_t)film->width * (size_t)film->height;
    const float *beauty[3] = {satin_film_channel(film, "R"), satin_film_channel(film, "G"),
                              satin_film_channel(film, "B")};
    if (!beauty[0] || !beauty[1] || !beauty[2])
        return log_fail(log, SATIN_ERROR_INPUT, "%s: the film has no channels R, G and B", path);
    unsigned char *pixel = calloc(count, 3);
    if (!pixel) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    for (size_t i = 0; i < count; i++) {
        const float grey = rgb_luminance(rgb_make(beauty[0][i], beauty[1][i], beauty[2][i]));
        const float cover = fminf(fmaxf(dot[i], 0.0f), 1.0f);
        rgb under = rgb_grey(fminf(grey, 1.0f) * (1.0f - cover));
        put_color(&pixel[3 * i], rgb_mad(under, DOT, cover));
    }
    satin_status status =
        film_write_pixels(path, &(struct film_pixels){film->width, film->height, 3, pixel}, log);
    free(pixel);
    return status;
}
