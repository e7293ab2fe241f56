// SPDX-License-Identifier: Apache-2.0
// Adaptive sampling: pixels with penumbrae, edges or sampled glossy reflection get more samples
// than flat walls. The error of a pixel is estimated from two halves of its samples, and averaged
// over a few neighbours, because two halves may agree by chance. Samples depend on earlier ones
// only through this estimate over an area. That makes light of rare samples darker in the mean, as
// a pixel that has met one gets more samples (docs/experiments/direct-light.md). Emission, where it
// is worst, is not made of these samples (render_rims.c).
//
// With low-discrepancy points the variance of a mean of n samples falls as n^-GAIN, with GAIN
// between 1 and 2: that of a pixel with an edge as n^-1.5. The sum of v_i n_i^-GAIN for a given sum
// of n_i is least where n_i is in proportion to v_i^(1 / (1 + GAIN)).
#include "render/render_adaptive_sampling.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "render/render_budget.h"

#define GAIN 1.5f
// The factor of the variance of direct light in its number of samples. It is more than 1, as those
// of a pixel are stratified together: with 1 and 3, living-room (640x360, 60 CPU seconds) has an
// error of .0069 and .0066, vase (200x200) .000061 and .000057 at 8, and cornell-glossy,
// cornell-metal, indirect-room and hall the same within 4 %.
#define DIRECT_MORE 3.0f
// Fraction of the image's mean luminance below which the error of a pixel is absolute.
#define DARK 0.2f
enum {
    MULTIPLE = 2,           // samples are added in pairs, which are stratified together
    ADAPTIVE_CHUNK = 4096,  // pixels per chunk
    ADAPTIVE_ROWS = 8,
    ADAPTIVE_COLUMNS = 16  // a line of the processor's cache, in floats
};

bool render_adaptive_make(struct adaptive_sampling *adapt, int width, int height, int direct,
                          int gathers) {
    size_t n = (size_t)width * (size_t)height;
    *adapt = (struct adaptive_sampling){.width = width, .height = height};
    adapt->pixel = array_new(n, sizeof *adapt->pixel);
    adapt->scratch = array_new(5 * n, sizeof *adapt->scratch);
    adapt->sum = array_new(n / ADAPTIVE_CHUNK + 1, sizeof *adapt->sum);
    if (adapt->pixel && adapt->scratch && adapt->sum) {
        for (size_t i = 0; i < n; i++)
            adapt->pixel[i] = (struct adaptive_pixel){.variance = -1.0f,
                                                      .light = {.next = (uint32_t)direct},
                                                      .lobe = {.next = (uint32_t)direct},
                                                      .gather = {.next = (uint32_t)gathers}};
        return true;
    }
    render_adaptive_destroy(adapt);
    return false;
}

void render_adaptive_destroy(struct adaptive_sampling *adapt) {
    free(adapt->pixel);
    free(adapt->scratch);
    free(adapt->sum);
    *adapt = (struct adaptive_sampling){0};
}

static size_t pixels(const struct adaptive_sampling *adapt) {
    return (size_t)adapt->width * (size_t)adapt->height;
}

// Context of the loops over pixels, rows or columns.
struct adapting {
    const struct adaptive_sampling *adapt;
    const float *from;
    float *to;
    float factor;
    double floor2, fraction;
    size_t stride;
    uint32_t count;
    bool gathers;
};

static void each_chunk(const struct adaptive_sampling *adapt, parallel_fn fn,
                       struct adapting *loop) {
    parallel_for_all(adapt->pool, pixels(adapt), ADAPTIVE_CHUNK, fn, loop);
}

// Adds the results of fn for all chunks, in their order.
static double sum_chunks(const struct adaptive_sampling *adapt, parallel_fn fn,
                         struct adapting *loop) {
    double sum = 0.0;
    each_chunk(adapt, fn, loop);
    for (size_t i = 0; i * ADAPTIVE_CHUNK < pixels(adapt); i++) sum += adapt->sum[i];
    return sum;
}

static void sum_luminances(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    double sum = 0.0;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct adaptive_pixel *p = &loop->adapt->pixel[i];
        if (p->count) sum += (double)rgb_luminance(p->sum) / p->count;
    }
    loop->adapt->sum[begin / ADAPTIVE_CHUNK] = sum;
}

// The squared luminance below which the error of a pixel is absolute.
static double floor2(const struct adaptive_sampling *adapt) {
    struct adapting loop = {.adapt = adapt};
    const double sum = sum_chunks(adapt, sum_luminances, &loop);
    const double dark = (double)DARK * sum / (double)pixels(adapt);
    return fmax(dark * dark, 1e-30);
}

// In double, because the squares of the brightest lights overflow in float.
static double relative2(float difference, float mean, double floor2) {
    const double d = (double)difference, m = (double)mean;
    return d * d / (m * m + floor2);
}

static void compare_pixels(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    const double least2 = loop->floor2;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct adaptive_pixel *p = &loop->adapt->pixel[i];
        uint32_t fresh = p->count - p->before;
        if (2 * fresh < p->before || fresh == 0) continue;  // too few for a comparison
        if (p->before > 0) {
            float n = (float)p->count, a = (float)p->before, b = (float)fresh;
            rgb mean = rgb_scale(p->sum, 1.0f / n);
            rgb d = rgb_sub(rgb_scale(p->sum_before, 1.0f / a),
                            rgb_scale(rgb_sub(p->sum, p->sum_before), 1.0f / b));
            const double error2 = relative2(d.r, mean.r, least2) + relative2(d.g, mean.g, least2) +
                                  relative2(d.b, mean.b, least2);
            // Sums that are not finite are ignored.
            p->variance = isfinite(error2) ? (float)error2 * a * b / (n * n) * powf(n, GAIN) : 0.0f;
        }
        p->sum_before = p->sum;
        p->before = p->count;
    }
}

void render_adaptive_compare(struct adaptive_sampling *adapt) {
    struct adapting loop = {.adapt = adapt, .floor2 = floor2(adapt)};
    each_chunk(adapt, compare_pixels, &loop);
}

static void target_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    const size_t width = (size_t)loop->adapt->width, stride = loop->stride;
    (void)worker;
    for (size_t y = begin * stride; y < end * stride; y += stride)
        for (size_t i = y * width; i < (y + 1) * width; i += stride) {
            struct adaptive_pixel *p = &loop->adapt->pixel[i];
            if (p->target < loop->count) p->target = loop->count;
        }
}

void render_adaptive_equal(struct adaptive_sampling *adapt, int stride, uint32_t count) {
    struct adapting loop = {.adapt = adapt, .stride = (size_t)stride, .count = count};
    const size_t rows = (size_t)((adapt->height + stride - 1) / stride);
    parallel_for_all(adapt->pool, rows, ADAPTIVE_ROWS, target_rows, &loop);
}

// The fraction of the pixels that a pixel follows, by a lattice with no short vectors.
static double lattice_order(size_t x, size_t y) {
    const double u = 0.7548776662 * (double)x + 0.5698402910 * (double)y;
    return u - floor(u);
}

static void target_some(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    const size_t width = (size_t)loop->adapt->width;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct adaptive_pixel *p = &loop->adapt->pixel[i];
        if (lattice_order(i % width, i / width) < loop->fraction && p->target < loop->count)
            p->target = loop->count;
    }
}

void render_adaptive_some(struct adaptive_sampling *adapt, double fraction, uint32_t count) {
    struct adapting loop = {.adapt = adapt, .fraction = fraction, .count = count};
    each_chunk(adapt, target_some, &loop);
}

// One pass of a binomial filter over five pixels. Pixels without a value (< 0) are ignored.
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

static void blur_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    const size_t width = (size_t)loop->adapt->width;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        blur(loop->from + y * width, loop->to + y * width, loop->adapt->width, 1);
}

static void blur_columns(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    (void)worker;
    for (size_t x = begin; x < end; x++)
        blur(loop->from + x, loop->to + x, loop->adapt->height, (size_t)loop->adapt->width);
}

static void blur_image(const struct adaptive_sampling *adapt, float *a, float *b) {
    struct adapting loop = {.adapt = adapt, .from = a, .to = b};
    parallel_for_all(adapt->pool, (size_t)adapt->height, ADAPTIVE_ROWS, blur_rows, &loop);
    loop = (struct adapting){.adapt = adapt, .from = b, .to = a};
    parallel_for_all(adapt->pool, (size_t)adapt->width, ADAPTIVE_COLUMNS, blur_columns, &loop);
}

static void copy_variances(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) loop->to[i] = loop->adapt->pixel[i].variance;
}

static void wanted_by_variance(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        loop->to[i] = powf(fmaxf(loop->to[i], 0.0f), 1.0f / (1.0f + GAIN));
}

// Computes, in scratch, numbers to which the samples of the pixels are to be proportional.
static const float *find_wanted(struct adaptive_sampling *adapt) {
    float *a = adapt->scratch;
    struct adapting loop = {.adapt = adapt, .to = a};
    each_chunk(adapt, copy_variances, &loop);
    blur_image(adapt, a, a + pixels(adapt));
    each_chunk(adapt, wanted_by_variance, &loop);
    return a;
}

// The number of samples that a pixel of `count` should have after a pass, if it is to have
// `wanted`.
static float limit_samples(float wanted, float count) {
    return clampf(wanted, count,
                  clampf(0.5f * count, RENDER_GROWTH_LEAST, RENDER_GROWTH_MOST) * count);
}

static void sum_added(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    double sum = 0.0;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const float count = (float)loop->adapt->pixel[i].count;
        sum += (double)(limit_samples(loop->factor * loop->from[i], count) - count);
    }
    loop->adapt->sum[begin / ADAPTIVE_CHUNK] = sum;
}

static double added_samples(const struct adaptive_sampling *adapt, const float *want,
                            float factor) {
    struct adapting loop = {.adapt = adapt, .from = want, .factor = factor};
    return sum_chunks(adapt, sum_added, &loop);
}

// The factor that gives this number of samples, or the largest factor if none does. It is found by
// bisection over the bits of positive floats, whose order is that of their values, so it is exact
// whatever the range of the wanted counts.
static float find_factor(const struct adaptive_sampling *adapt, const float *want, double samples) {
    union {
        uint32_t bits;
        float value;
    } lo = {.value = 0.0f}, hi = {.value = FLT_MAX}, middle;
    while (hi.bits - lo.bits > 1) {
        middle.bits = lo.bits + (hi.bits - lo.bits) / 2;
        if (added_samples(adapt, want, middle.value) < samples)
            lo = middle;
        else
            hi = middle;
    }
    return hi.value;
}

double render_adaptive_variance(struct adaptive_sampling *adapt) {
    const float *want = find_wanted(adapt);
    double sum = 0.0;
    for (size_t i = 0; i < pixels(adapt); i++) sum += (double)want[i];
    return pow(sum / (double)pixels(adapt), 1.0 + (double)GAIN);
}

void render_adaptive_distribute(struct adaptive_sampling *adapt, uint64_t samples) {
    const float *want = find_wanted(adapt);
    const float factor = find_factor(adapt, want, (double)samples);
    // If the noise is in a few pixels, the rest of the samples is distributed uniformly.
    const double rest = fmax((double)samples - added_samples(adapt, want, factor), 0.0);
    const double equal = rest / (double)pixels(adapt);
    double owed = 0.0;  // fractions of multiples that rounding has left over so far
    uint64_t given = 0;
    struct adaptive_pixel *last = adapt->pixel;
    for (size_t i = 0; i < pixels(adapt); i++) {
        struct adaptive_pixel *p = &adapt->pixel[i];
        const float count = (float)p->count;
        owed += (double)(limit_samples(factor * want[i], count) - count) + equal;
        const double multiples = fmax(floor(owed / MULTIPLE + 0.5), 0.0);
        p->target = p->count + MULTIPLE * (uint32_t)multiples;
        owed -= MULTIPLE * multiples;
        given += MULTIPLE * (uint64_t)multiples;
        if (multiples > 0.0) last = p;
    }
    // Corrects for up to half of MULTIPLE.
    last->target += (uint32_t)(samples - given);
}

// ---- Counts of a sample -------------------------------------------------------------------------

static void add_direct_samples(struct adaptive_direct *direct, float variance) {
    direct->variance += variance;
    direct->taken += direct->next;
}

static void add_gathers(struct adaptive_gathers *gather, const struct shade_sample *sample) {
    if (!sample->gathers) return;
    if (gather->next > 1) {
        gather->variance += sample->gather_variance;
        gather->known++;
    }
    gather->samples++;
    gather->taken += gather->next;
}

void render_adaptive_add(struct adaptive_pixel *pixel, const struct shade_sample *sample) {
    static const struct shade_sample black;
    const struct shade_sample *s = shade_sample_finite(sample) ? sample : &black;
    // Lights seen directly have rays of their own (render_rims.c).
    const rgb value = rgb_sub(s->beauty, s->layer[SHADE_EMISSION]);
    pixel->sum = rgb_add(pixel->sum, value);
    pixel->squares += sqrf(rgb_luminance(value));
    add_direct_samples(&pixel->light, s->light_variance);
    add_direct_samples(&pixel->lobe, s->lobe_variance);
    add_gathers(&pixel->gather, s);
    pixel->count++;
}

// The mean variance by one sample of direct light.
static float variance_by_one(const struct adaptive_direct *direct, float count) {
    return direct->variance / fmaxf(count, 1.0f);
}

// That of a whole sample, which has some of them.
static float variance_of_all(const struct adaptive_direct *direct, float count) {
    return variance_by_one(direct, count) * count / fmaxf((float)direct->taken, count);
}

// The mean variance by one gather ray in samples that gather; < 0: unknown.
static float variance_by_ray(const struct adaptive_gathers *gather) {
    return gather->known ? gather->variance / (float)gather->known : -1.0f;
}

// That of any sample, 0 if it is unknown.
static float variance_of_rays(const struct adaptive_gathers *gather, float count) {
    if (!gather->known) return 0.0f;
    const float samples = (float)gather->samples;
    return variance_by_ray(gather) * samples / (float)gather->taken * (samples / count);
}

// The parts of a pixel's variance, image by image in scratch; < 0: unknown.
struct variances {
    float *light, *lobe, *gather;  // by one of them
    float *rest;                   // of a sample, from all else
};

static struct variances variances_of(const struct adaptive_sampling *adapt) {
    const size_t n = pixels(adapt);
    float *from = adapt->scratch;
    return (struct variances){from, from + n, from + 2 * n, from + 3 * n};
}

static void find_variances(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    const struct variances v = variances_of(loop->adapt);
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct adaptive_pixel *p = &loop->adapt->pixel[i];
        const float count = (float)p->count;
        const float mean = rgb_luminance(p->sum) / fmaxf(count, 1.0f);
        const float all = (p->squares - count * sqrf(mean)) / fmaxf(count - 1.0f, 1.0f);
        const float direct = variance_of_all(&p->light, count) + variance_of_all(&p->lobe, count);
        const float gathered = loop->gathers ? variance_of_rays(&p->gather, count) : 0.0f;
        v.light[i] = variance_by_one(&p->light, count);
        v.lobe[i] = variance_by_one(&p->lobe, count);
        v.gather[i] = variance_by_ray(&p->gather);
        v.rest[i] = all - direct - gathered;
        const bool known = p->count > 1 && isfinite(v.light[i]) && isfinite(v.lobe[i]) &&
                           isfinite(v.gather[i]) && isfinite(v.rest[i]);
        v.light[i] = known ? v.light[i] : -1.0f;
        v.lobe[i] = known ? v.lobe[i] : -1.0f;
        v.gather[i] = known ? v.gather[i] : -1.0f;
        v.rest[i] = known ? fmaxf(v.rest[i], 0.0f) : -1.0f;
    }
}

// The number with the least variance for its cost.
static float best_count(float variance, float rest, float cost) {
    return powf(variance * cost / fmaxf(rest, 1e-30f), 1.0f / (1.0f + GAIN));
}

// At least two, or nothing would be known of the variance by one of the next samples.
static uint32_t best_direct(float variance, float rest, float cost) {
    const float m = best_count(DIRECT_MORE * variance, rest, cost);
    return (uint32_t)clampf(m, 2.0f, RENDER_LIGHT_SAMPLES_MOST);
}

static void set_counts(void *ctx, size_t begin, size_t end, int worker) {
    const struct adapting *loop = ctx;
    const struct variances v = variances_of(loop->adapt);
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        struct adaptive_pixel *p = &loop->adapt->pixel[i];
        if (v.light[i] < 0.0f) continue;  // nothing is known
        p->light.next = best_direct(v.light[i], v.rest[i], loop->factor);
        p->lobe.next = best_direct(v.lobe[i], v.rest[i], loop->factor);
        if (!loop->gathers || v.gather[i] < 0.0f) continue;
        const float rays = best_count(v.gather[i], v.rest[i], loop->factor / RENDER_GATHER_COST);
        p->gather.next = (uint32_t)clampf(rays + 0.5f, 1.0f, RENDER_GATHERS_MOST);
    }
}

// With m light samples of variance v each, b BRDF samples of variance u, and w the variance of a
// sample from all other sources, n samples have the variance w n^-GAIN + v (n m)^-GAIN + u (n
// b)^-GAIN and cost n (cost + m + b). The least variance for its cost is at m = (v cost / w)^(1 /
// (1 + GAIN)), and b likewise; v and u are taken DIRECT_MORE times. Gather rays are a further part,
// of another cost.
void render_adaptive_counts(struct adaptive_sampling *adapt, float cost, bool gathers) {
    const struct variances v = variances_of(adapt);
    float *other = adapt->scratch + 4 * pixels(adapt);
    struct adapting loop = {.adapt = adapt, .factor = cost, .gathers = gathers};
    each_chunk(adapt, find_variances, &loop);
    blur_image(adapt, v.light, other);
    blur_image(adapt, v.lobe, other);
    blur_image(adapt, v.gather, other);
    blur_image(adapt, v.rest, other);
    each_chunk(adapt, set_counts, &loop);
}

void render_adaptive_direct(struct adaptive_sampling *adapt, uint32_t count) {
    for (size_t i = 0; i < pixels(adapt); i++)
        adapt->pixel[i].light.next = adapt->pixel[i].lobe.next = count;
}

void render_adaptive_gathers(struct adaptive_sampling *adapt, uint32_t count) {
    for (size_t i = 0; i < pixels(adapt); i++) adapt->pixel[i].gather.next = count;
}

double render_adaptive_light_samples(const struct adaptive_sampling *adapt) {
    double light_samples = 0.0, samples = 0.0;
    for (size_t i = 0; i < pixels(adapt); i++) {
        light_samples += adapt->pixel[i].light.taken;
        samples += adapt->pixel[i].count;
    }
    return samples > 0.0 ? light_samples / samples : 0.0;
}
