// SPDX-License-Identifier: Apache-2.0
// How light becomes the tones of a picture: exposure, and the responses of a display, of film, and
// of AgX.
#include <math.h>

#include "film/film.h"

// The luminance that auto exposure makes the mean one: that of a grey card.
static const double GREY = 0.18;

float film_light_value(const struct film_light *light, float value) {
    if (light->finite && !isfinite(value)) return 0.0f;
    return light->half ? film_half(value) : value;
}

rgb film_light_at(const struct film_light *light, size_t i) {
    return rgb_make(film_light_value(light, light->plane[0][i]),
                    film_light_value(light, light->plane[1][i]),
                    film_light_value(light, light->plane[2][i]));
}

// The factor by which the mean logarithm of the luminance becomes that of GREY [Reinhard et al.
// 2002, equation 1]. Pixels that are black or not finite are left out.
double film_auto_exposure(const struct satin_film *film, const struct film_light *light) {
    const size_t pixels = (size_t)film->width * (size_t)film->height;
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < pixels; i++) {
        const double Y = (double)rgb_luminance(film_light_at(light, i));
        if (!(Y > 0.0) || !isfinite(Y)) continue;
        sum += log(Y);
        count++;
    }
    return count > 0.0 ? GREY / exp(sum / count) : 1.0;
}

// The response of film that the academy's reference transform has [Narkowicz 2016, a fit].
static float filmic(float x) {
    if (!(x > 0.0f)) return 0.0f;
    // Beyond this the fit is above 1, and squares of larger values would overflow.
    if (x > 1e3f) return 1.0f;
    return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
}

// ---- AgX ----------------------------------------------------------------------------------------

// AgX [Sobotka 2022] moves colours towards grey, so that bright ones become pale instead of
// changing their hue, applies a sigmoid to their logarithms, and moves them back.
static const float AGX_TO_GREY = 0.2f;
// The grey to which a colour moves. The weights are those of its matrix.
static const rgb AGX_GREY = {0.2120f, 0.3922f, 0.3958f};
// The stops below and above GREY that become black and white.
static const float AGX_BLACK = -10.0f, AGX_WHITE = 6.5f;
// The sigmoid: its slope at GREY, which becomes half, and the powers of its toe and its shoulder.
static const float AGX_SLOPE = 2.0f, AGX_TOE = 3.0f, AGX_SHOULDER = 3.25f;
static const float AGX_MOST = 1e30f;
static const float AGX_GAMMA = 2.2f;  // of the display for which its values are

// From (0, 0) to (1, 1): a line through the pivot with a toe and a shoulder that end there.
static float agx_sigmoid(float t) {
    const float pivot = -AGX_BLACK / (AGX_WHITE - AGX_BLACK), d = t - pivot;
    const float power = d < 0.0f ? AGX_TOE : AGX_SHOULDER;
    const float end = d < 0.0f ? pivot : 1.0f - pivot;
    const float scale = powf(2.0f * AGX_SLOPE * end, power) - 1.0f;
    return 0.5f + AGX_SLOPE * d * powf(1.0f + scale * powf(fabsf(d) / end, power), -1.0f / power);
}

// The value that AgX displays for one channel of light.
static float agx_response(float x) {
    const float stops = x > 0.0f ? log2f(x / (float)GREY) : AGX_BLACK;
    return agx_sigmoid((fminf(fmaxf(stops, AGX_BLACK), AGX_WHITE) - AGX_BLACK) /
                       (AGX_WHITE - AGX_BLACK));
}

static float agx_grey(rgb c) { return c.r * AGX_GREY.r + c.g * AGX_GREY.g + c.b * AGX_GREY.b; }

static float agx_linear(float value) { return powf(fminf(fmaxf(value, 0.0f), 1.0f), AGX_GAMMA); }

static rgb agx(rgb light) {
    // No value, and light below zero, is black; what is infinite is white.
    const rgb c = {clampf(light.r, 0.0f, AGX_MOST), clampf(light.g, 0.0f, AGX_MOST),
                   clampf(light.b, 0.0f, AGX_MOST)};
    const float k = AGX_TO_GREY, grey = agx_grey(c);
    const rgb in = {c.r + k * (grey - c.r), c.g + k * (grey - c.g), c.b + k * (grey - c.b)};
    const rgb v = {agx_response(in.r), agx_response(in.g), agx_response(in.b)};
    // Grey is what it was, so this is the inverse.
    const float out = 1.0f / (1.0f - k), at = out * k * agx_grey(v);
    return rgb_make(agx_linear(out * v.r - at), agx_linear(out * v.g - at),
                    agx_linear(out * v.b - at));
}

rgb film_tone(satin_tone tone, rgb light) {
    switch (tone) {
        case SATIN_TONE_FILMIC:
            return rgb_make(filmic(light.r), filmic(light.g), filmic(light.b));
        case SATIN_TONE_AGX:
            return agx(light);
        case SATIN_TONE_CLIP:
            break;
    }
    return light;
}
