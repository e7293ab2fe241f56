// SPDX-License-Identifier: Apache-2.0
// The difference between an image x and a reference r, over pixels and the channels R, G and B.
//
//   relMSE = mean of (x - r)^2 / (r^2 + 0.01)
//   RMSE   = root of the mean of (x - r)^2
// A reference that is itself an estimate adds its own variance to both. If it has the channels
// variance.R, .G and .B (of its pixels' means), they are subtracted from each square, which leaves
// the expected error relative to the true image; if the error is tiny, the result can be negative.
//   PSNR   = of the displayed pictures: sRGB, clamped to [0, 1], peak 1.
// Discernible are pixels whose luminance differs by more than 2 % of the reference's (Weber's law).
#include <math.h>

#include "base/vec.h"
#include "film/film.h"

static const double RELATIVE_FLOOR = 0.01;  // prevents the darkest pixels from dominating relMSE
static const double WEBER = 0.02;

enum layer { IMAGE, REFERENCE, VARIANCE, EMISSION_IMAGE, EMISSION_REFERENCE, LAYERS };

// The planes of a layer, NULL for those that are absent.
struct compared_planes {
    const float *channel[LAYERS][3];
};

struct sums {
    uint64_t compared, masked, nonfinite, discernible;
    double squared, relative, display, luminance, luminance_reference;
};

static void find_layer(const struct satin_film *film, const char *const names[3],
                       const float *out[3]) {
    for (int c = 0; c < 3; c++) out[c] = satin_film_channel(film, names[c]);
    if (!out[0] || !out[1] || !out[2]) out[0] = out[1] = out[2] = NULL;
}

static rgb value_at(const struct compared_planes *p, enum layer layer, size_t i) {
    const float *const *channel = p->channel[layer];
    return channel[0] ? rgb_make(channel[0][i], channel[1][i], channel[2][i]) : rgb_grey(0.0f);
}

static double display_value(double linear) {
    if (!(linear > 0.0)) return 0.0;
    if (linear >= 1.0) return 1.0;
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

// A variance that is negative or not finite is wrong, and counts as 0.
static double sound_variance(double variance) {
    return variance > 0.0 && isfinite(variance) ? variance : 0.0;
}

static void add_channel(struct sums *sums, double x, double r, double variance) {
    double d2 = (x - r) * (x - r) - sound_variance(variance);
    double display = display_value(x) - display_value(r);
    sums->squared += d2;
    sums->relative += d2 / (r * r + RELATIVE_FLOOR);
    sums->display += display * display;
}

static enum film_pixel kind_of(const struct compared_planes *p, size_t i) {
    const rgb emitted = rgb_add(value_at(p, EMISSION_IMAGE, i), value_at(p, EMISSION_REFERENCE, i));
    if (!rgb_finite(value_at(p, IMAGE, i)) || !rgb_finite(value_at(p, REFERENCE, i)))
        return FILM_PIXEL_NONFINITE;
    return rgb_black(emitted) ? FILM_PIXEL_COMPARED : FILM_PIXEL_MASKED;
}

static void add_pixel(struct sums *sums, const struct compared_planes *p, size_t i) {
    rgb x = value_at(p, IMAGE, i), r = value_at(p, REFERENCE, i), v = value_at(p, VARIANCE, i);
    const enum film_pixel kind = kind_of(p, i);
    sums->nonfinite += kind == FILM_PIXEL_NONFINITE;
    sums->masked += kind == FILM_PIXEL_MASKED;
    if (kind != FILM_PIXEL_COMPARED) return;
    add_channel(sums, x.r, r.r, v.r);
    add_channel(sums, x.g, r.g, v.g);
    add_channel(sums, x.b, r.b, v.b);
    double yx = rgb_luminance(x), yr = rgb_luminance(r);
    sums->luminance += yx;
    sums->luminance_reference += yr;
    sums->discernible += fabs(yx - yr) > WEBER * yr;
    sums->compared++;
}

static satin_status find_planes(const struct satin_film *image, const struct satin_film *reference,
                                bool mask_emission, struct log log, struct compared_planes *p) {
    static const char *const beauty[3] = {"R", "G", "B"};
    static const char *const variance[3] = {"variance.R", "variance.G", "variance.B"};
    static const char *const emission[3] = {"emission.R", "emission.G", "emission.B"};
    if (image->width != reference->width || image->height != reference->height)
        return log_fail(log, SATIN_ERROR_INPUT, "the images differ in size: %dx%d and %dx%d",
                        image->width, image->height, reference->width, reference->height);
    find_layer(image, beauty, p->channel[IMAGE]);
    find_layer(reference, beauty, p->channel[REFERENCE]);
    if (film_variance(reference, variance[0]))
        find_layer(reference, variance, p->channel[VARIANCE]);
    if (!p->channel[IMAGE][0] || !p->channel[REFERENCE][0])
        return log_fail(log, SATIN_ERROR_INPUT, "%s has no channels R, G and B",
                        p->channel[IMAGE][0] ? "the reference" : "the image");
    if (!mask_emission) return SATIN_OK;
    find_layer(image, emission, p->channel[EMISSION_IMAGE]);
    find_layer(reference, emission, p->channel[EMISSION_REFERENCE]);
    if (!p->channel[EMISSION_IMAGE][0] && !p->channel[EMISSION_REFERENCE][0])
        return log_fail(log, SATIN_ERROR_INPUT, "neither image has a layer emission to mask");
    return SATIN_OK;
}

satin_status film_compare(const struct satin_film *image, const struct satin_film *reference,
                          bool mask_emission, struct log log, struct film_difference *out) {
    struct compared_planes planes = {0};
    struct sums s = {0};
    satin_status status = find_planes(image, reference, mask_emission, log, &planes);
    if (status != SATIN_OK) return status;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++) add_pixel(&s, &planes, i);
    if (s.compared == 0) return log_fail(log, SATIN_ERROR_INPUT, "no pixel is left to compare");
    double values = 3.0 * (double)s.compared;
    *out = (struct film_difference){
        .rmse = sqrt(fmax(s.squared / values, 0.0)),
        .relmse = s.relative / values,
        .psnr = -10.0 * log10(s.display / values),
        .mean_ratio =
            s.luminance == s.luminance_reference ? 1.0 : s.luminance / s.luminance_reference,
        .discernible = (double)s.discernible / (double)s.compared,
        .compared = s.compared,
        .masked = s.masked,
        .nonfinite = s.nonfinite,
        .variance = planes.channel[VARIANCE][0] != NULL,
    };
    return SATIN_OK;
}

satin_status film_pixel_kinds(const struct satin_film *image, const struct satin_film *reference,
                              bool mask_emission, struct log log, unsigned char *out) {
    struct compared_planes planes = {0};
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    const satin_status status = find_planes(image, reference, mask_emission, log, &planes);
    if (status != SATIN_OK) return status;
    for (size_t i = 0; i < pixels; i++) out[i] = (unsigned char)kind_of(&planes, i);
    return SATIN_OK;
}
