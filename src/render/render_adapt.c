// SPDX-License-Identifier: Apache-2.0
// Adaptive sampling: pixels where direct light has penumbrae, where edges run and where glossy
// surfaces are sampled get more samples than flat walls. A pixel's error is estimated from two
// halves of its samples, and averaged over a few neighbours, as two halves may agree by chance.
// Samples depend on those of earlier passes through this choice alone, over an area, so that what
// it biases is far below the noise.
//
// With well-spread points the variance of a mean of n samples falls as n^-GAIN, GAIN between 1 and
// 2: that of a pixel cut by an edge as n^-1.5. The sum of v_i n_i^-GAIN is least at a given sum of
// n_i where n_i is in proportion to v_i^(1 / (1 + GAIN)).
#include "render/render_adapt.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/array.h"

#define GAIN 1.5f
// Of the image's mean luminance: the error of darker pixels counts absolutely.
#define DARK 0.2f
// Light samples of a sample at most: beyond, they are a sample's cost, and well spread.
#define LIGHTS_MOST 16.0f
enum {
    GROWTH = 4,   // at most so many times its samples does a pixel get in one pass by its noise
    MULTIPLE = 2  // samples are added in pairs, which are stratified among themselves
};

bool adapt_make(struct adapt *adapt, int width, int height, int lights) {
    size_t n = (size_t)width * (size_t)height;
    *adapt = (struct adapt){.width = width, .height = height};
    adapt->pixel = array_new(n, sizeof *adapt->pixel);
    adapt->scratch = array_new(4 * n, sizeof *adapt->scratch);
    if (adapt->pixel && adapt->scratch) {
        for (size_t i = 0; i < n; i++)
            adapt->pixel[i] = (struct adapt_pixel){.spread = -1.0f, .lights = (uint32_t)lights};
        return true;
    }
    adapt_destroy(adapt);
    return false;
}

void adapt_destroy(struct adapt *adapt) {
    free(adapt->pixel);
    free(adapt->scratch);
    *adapt = (struct adapt){0};
}

static size_t pixels(const struct adapt *adapt) {
    return (size_t)adapt->width * (size_t)adapt->height;
}

// The square of what is dark in this image.
static double floor2(const struct adapt *adapt) {
    double sum = 0.0;
    for (size_t i = 0; i < pixels(adapt); i++) {
        const struct adapt_pixel *p = &adapt->pixel[i];
        if (p->count) sum += (double)rgb_luminance(p->sum) / p->count;
    }
    const double dark = (double)DARK * sum / (double)pixels(adapt);
    return fmax(dark * dark, 1e-30);
}

// In doubles: squares of the brightest lights leave the range of float.
static double relative2(float difference, float mean, double floor2) {
    const double d = (double)difference, m = (double)mean;
    return d * d / (m * m + floor2);
}

void adapt_compare(struct adapt *adapt) {
    const double least2 = floor2(adapt);
    for (size_t i = 0; i < pixels(adapt); i++) {
        struct adapt_pixel *p = &adapt->pixel[i];
        uint32_t fresh = p->count - p->before;
        if (2 * fresh < p->before || fresh == 0) continue;  // too few to compare
        if (p->before > 0) {
            float n = (float)p->count, a = (float)p->before, b = (float)fresh;
            rgb mean = rgb_scale(p->sum, 1.0f / n);
            rgb d = rgb_sub(rgb_scale(p->sum_before, 1.0f / a),
                            rgb_scale(rgb_sub(p->sum, p->sum_before), 1.0f / b));
            const double error2 = relative2(d.r, mean.r, least2) + relative2(d.g, mean.g, least2) +
                                  relative2(d.b, mean.b, least2);
            // Sums that are not finite say nothing.
            p->spread = isfinite(error2) ? (float)error2 * a * b / (n * n) * powf(n, GAIN) : 0.0f;
        }
        p->sum_before = p->sum;
        p->before = p->count;
    }
}

void adapt_even(struct adapt *adapt, uint32_t count) {
    for (size_t i = 0; i < pixels(adapt); i++)
        if (adapt->pixel[i].target < count) adapt->pixel[i].target = count;
}

// One pass of a binomial filter over five pixels; pixels without a value (< 0) do not count.
static void blur(const float *from, float *to, int count, size_t step) {
    static const float weight[] = {6.0f, 4.0f, 1.0f};
    for (int i = 0; i < count; i++) {
        float sum = 0.0f, total = 0.0f;
        for (int k = -2; k <= 2; k++) {
            if (i + k < 0 || i + k >= count) continue;
            float value = from[(size_t)(i + k) * step], w = weight[abs(k)];
            if (value < 0.0f) continue;
            sum += w * value;
            total += w;
        }
        to[(size_t)i * step] = total > 0.0f ? sum / total : -1.0f;
    }
}

static void blur_image(const struct adapt *adapt, float *a, float *b) {
    const size_t width = (size_t)adapt->width;
    for (int y = 0; y < adapt->height; y++)
        blur(a + (size_t)y * width, b + (size_t)y * width, adapt->width, 1);
    for (int x = 0; x < adapt->width; x++) blur(b + x, a + x, adapt->height, width);
}

// Into scratch: what each pixel's number of samples is to be in proportion to.
static const float *wanted(struct adapt *adapt) {
    size_t n = pixels(adapt);
    float *a = adapt->scratch;
    for (size_t i = 0; i < n; i++) a[i] = adapt->pixel[i].spread;
    blur_image(adapt, a, a + n);
    for (size_t i = 0; i < n; i++) a[i] = powf(fmaxf(a[i], 0.0f), 1.0f / (1.0f + GAIN));
    return a;
}

static double more(const struct adapt *adapt, const float *want, float factor) {
    double sum = 0.0;
    for (size_t i = 0; i < pixels(adapt); i++) {
        float count = (float)adapt->pixel[i].count;
        sum += (double)(clampf(factor * want[i], count, GROWTH * count) - count);
    }
    return sum;
}

// The factor that gives so many samples, or the largest number where no factor does. It is found
// among the bits of positive floats, which ascend as their values do: to the last digit, however
// far apart the wanted counts lie.
static float find_factor(const struct adapt *adapt, const float *want, double samples) {
    union {
        uint32_t bits;
        float value;
    } lo = {.value = 0.0f}, hi = {.value = FLT_MAX}, middle;
    while (hi.bits - lo.bits > 1) {
        middle.bits = lo.bits + (hi.bits - lo.bits) / 2;
        if (more(adapt, want, middle.value) < samples)
            lo = middle;
        else
            hi = middle;
    }
    return hi.value;
}

double adapt_variance(struct adapt *adapt) {
    const float *want = wanted(adapt);
    double sum = 0.0;
    for (size_t i = 0; i < pixels(adapt); i++) sum += (double)want[i];
    return pow(sum / (double)pixels(adapt), 1.0 + (double)GAIN);
}

void adapt_spread(struct adapt *adapt, uint64_t samples) {
    const float *want = wanted(adapt);
    const float factor = find_factor(adapt, want, (double)samples);
    // Where the noise is confined to a few pixels the rest of the samples is spread evenly.
    const double rest = fmax((double)samples - more(adapt, want, factor), 0.0);
    const double even = rest / (double)pixels(adapt);
    double owed = 0.0;  // what rounding to whole groups has kept back so far
    uint64_t given = 0;
    struct adapt_pixel *last = adapt->pixel;
    for (size_t i = 0; i < pixels(adapt); i++) {
        struct adapt_pixel *p = &adapt->pixel[i];
        const float count = (float)p->count;
        owed += (double)(clampf(factor * want[i], count, GROWTH * count) - count) + even;
        const double groups = fmax(floor(owed / MULTIPLE + 0.5), 0.0);
        p->target = p->count + MULTIPLE * (uint32_t)groups;
        owed -= MULTIPLE * groups;
        given += MULTIPLE * (uint64_t)groups;
        if (groups > 0.0) last = p;
    }
    // Half a group that is left over or too much.
    last->target += (uint32_t)(samples - given);
}

// With m light samples of variance v each, and w the variance of a sample for all other reasons, n
// samples leave w n^-GAIN + v (n m)^-GAIN and cost n (cost + m): least for
// m = (v cost / w)^(1 / (1 + GAIN)).
void adapt_lights(struct adapt *adapt, float cost) {
    const size_t n = pixels(adapt);
    float *light = adapt->scratch, *rest = light + n, *other = rest + n;
    for (size_t i = 0; i < n; i++) {
        const struct adapt_pixel *p = &adapt->pixel[i];
        const float count = (float)p->count, m = (float)p->lights_taken / fmaxf(count, 1.0f);
        const float mean = rgb_luminance(p->sum) / fmaxf(count, 1.0f);
        const float all = (p->squares - count * sqrf(mean)) / fmaxf(count - 1.0f, 1.0f);
        light[i] = p->light_variance / fmaxf(count, 1.0f);
        rest[i] = all - light[i] / fmaxf(m, 1.0f);
        const bool known = p->count > 1 && isfinite(light[i]) && isfinite(rest[i]);
        light[i] = known ? light[i] : -1.0f;  // does not count
        rest[i] = known ? fmaxf(rest[i], 0.0f) : -1.0f;
    }
    blur_image(adapt, light, other);
    blur_image(adapt, rest, other);
    for (size_t i = 0; i < n; i++) {
        struct adapt_pixel *p = &adapt->pixel[i];
        if (!(light[i] > 0.0f)) continue;  // nothing is known, or there is no noise of lights
        const float m = powf(light[i] * cost / fmaxf(rest[i], 1e-30f), 1.0f / (1.0f + GAIN));
        p->lights = (uint32_t)clampf(m, 1.0f, LIGHTS_MOST);
        if (p->lights < 2) p->lights = 2;  // or the next judgement knows nothing
    }
}

double adapt_light_samples(const struct adapt *adapt) {
    double lights = 0.0, samples = 0.0;
    for (size_t i = 0; i < pixels(adapt); i++) {
        lights += adapt->pixel[i].lights_taken;
        samples += adapt->pixel[i].count;
    }
    return samples > 0.0 ? lights / samples : 0.0;
}
