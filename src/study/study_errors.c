// SPDX-License-Identifier: Apache-2.0
// Errors of images of several seeds, with bias apart from variance. For seeds s and t, let
//
//   G(s, t) = mean over pixels and channels of ((x_s - r)(x_t - r) - v) / (r^2 + 0.01),
//
// where r is the reference and v the variance of its pixels. G(s, s) is relMSE. For s != t the
// noise of the two images is independent, so the mean of G(s, t) is the square of the error that
// all seeds have in common, the bias; relMSE without it is the variance. The noise of r is in both
// factors, and v removes what it adds. With a reference of two pieces this is the mean of
// (x - b)(x - c), as in bench/unbiased.py.
//
// The standard error of the bias is that of two jackknives: over the seeds, and over the pieces of
// the reference, whose noise all seeds have in common.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "study/study_work.h"

static const double SQUARE_FLOOR = 0.01;  // as in film_compare.c

static const char *const beauty_name[3] = {"R", "G", "B"};
static const char *const emission_name[3] = {"emission.R", "emission.G", "emission.B"};
static const char *const variance_name[3] = {"variance.R", "variance.G", "variance.B"};

static size_t pixels_of(const satin_film *film) {
    return (size_t)film->width * (size_t)film->height;
}

// Marks the pixels that see an emitter or are not finite.
static void mark_pixels(const satin_film *film, bool mask_emission, unsigned char *left_out) {
    for (int c = 0; c < 3; c++) {
        const float *value = satin_film_channel(film, beauty_name[c]);
        const float *emission = mask_emission ? satin_film_channel(film, emission_name[c]) : NULL;
        for (size_t i = 0; i < pixels_of(film); i++)
            if (!value || !isfinite(value[i]) || (emission && emission[i] != 0.0f)) left_out[i] = 1;
    }
}

// Adds one channel to the sums G, of which t >= s are computed, and to the means.
struct gram {
    size_t count;
    double *sum;   // count * count
    double *mean;  // of each image
    double reference, values;
};

static void add_plane(struct gram *gram, const float *const *x, const float *r, const float *v,
                      const unsigned char *left_out, size_t pixels) {
    for (size_t i = 0; i < pixels; i++) {
        if (left_out[i]) continue;
        const double ri = (double)r[i], vi = v ? (double)v[i] : 0.0;
        const double weight = 1.0 / (ri * ri + SQUARE_FLOOR);
        for (size_t s = 0; s < gram->count; s++) {
            const double ds = ((double)x[s][i] - ri) * weight;
            for (size_t t = s; t < gram->count; t++)
                gram->sum[s * gram->count + t] += ds * ((double)x[t][i] - ri) - vi * weight;
            gram->mean[s] += (double)x[s][i];
        }
        gram->reference += ri;
        gram->values += 1.0;
    }
}

static double mean_of(const double *value, size_t stride, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += value[i * stride];
    return sum / (double)count;
}

// The standard error of a mean.
static double standard_error(const double *value, size_t stride, size_t count) {
    const double mean = mean_of(value, stride, count);
    double sum = 0.0;
    if (count < 2) return (double)NAN;
    for (size_t i = 0; i < count; i++)
        sum += (value[i * stride] - mean) * (value[i * stride] - mean);
    return sqrt(sum / (double)(count - 1) / (double)count);
}

// The mean of G(s, t) over s < t without the seed `without`; `count` for none.
static double mean_of_pairs(const double *g, size_t count, size_t without) {
    double sum = 0.0, pairs = 0.0;
    for (size_t s = 0; s < count; s++)
        for (size_t t = s + 1; t < count; t++) {
            if (s == without || t == without) continue;
            sum += g[s * count + t];
            pairs += 1.0;
        }
    return sum / pairs;
}

// The square of the standard error of the bias by the jackknife over the seeds; NAN of fewer than 3
// seeds.
static double seed_noise(const struct gram *gram, double bias2) {
    double sum = 0.0;
    const size_t n = gram->count;
    if (n < 3) return (double)NAN;
    for (size_t s = 0; s < n; s++) {
        const double without = mean_of_pairs(gram->sum, n, s);
        sum += (without - bias2) * (without - bias2);
    }
    return sum * (double)(n - 1) / (double)n;
}

static void evaluate_gram(struct gram *gram, struct study_errors *out) {
    const size_t n = gram->count;
    const bool black = gram->reference == 0.0;
    for (size_t i = 0; i < n; i++) gram->mean[i] = black ? 1.0 : gram->mean[i] / gram->reference;
    out->relmse = mean_of(gram->sum, n + 1, n);
    out->relmse_error = standard_error(gram->sum, n + 1, n);
    out->mean_ratio = mean_of(gram->mean, 1, n);
    out->mean_ratio_error = standard_error(gram->mean, 1, n);
    if (n < 2) return;
    out->bias2 = mean_of_pairs(gram->sum, n, n);
    out->variance = out->relmse - out->bias2;
    out->bias2_error = sqrt(seed_noise(gram, out->bias2));
}

// What comparing images needs.
struct comparison {
    const float **x;
    unsigned char *left_out;
    struct gram gram;
};

// Fills the sums G against one reference.
static void compare_with(struct comparison *c, satin_film *const *image,
                         const satin_film *reference) {
    struct gram *gram = &c->gram;
    const size_t n = gram->count;
    memset(gram->sum, 0, n * n * sizeof *gram->sum);
    memset(gram->mean, 0, n * sizeof *gram->mean);
    gram->reference = gram->values = 0.0;
    for (int k = 0; k < 3; k++) {
        const float *r = satin_film_channel(reference, beauty_name[k]);
        const float *v = film_variance(reference, variance_name[k]);
        for (size_t s = 0; s < n; s++) c->x[s] = satin_film_channel(image[s], beauty_name[k]);
        if (r) add_plane(gram, c->x, r, v, c->left_out, pixels_of(reference));
    }
    for (size_t i = 0; i < n * n && gram->values > 0.0; i++) gram->sum[i] /= gram->values;
}

// Adds the noise that the reference gives to the bias.
static void add_reference_noise(struct comparison *c, satin_film *const *image,
                                const struct study_reference *reference, struct study_errors *out) {
    const size_t n = c->gram.count, pieces = reference->pieces;
    double sum = 0.0, squares = 0.0;
    if (n < 3 || pieces == 0) return;
    for (size_t k = 0; k < pieces; k++) {
        compare_with(c, image, reference->without[k]);
        const double without = mean_of_pairs(c->gram.sum, n, n) - out->bias2;
        sum += without;
        squares += without * without;
    }
    // (K - 1) / K times the sum of squares around the mean of the estimates without a piece.
    const double count = (double)pieces;
    const double noise = fmax(squares - sum * sum / count, 0.0) * (count - 1.0) / count;
    out->bias2_error = sqrt(out->bias2_error * out->bias2_error + noise);
}

// The relative variance of the reference, in relMSE, over the pixels that are compared; NAN if it
// is not known.
static double reference_noise(const satin_film *reference, const unsigned char *left_out) {
    double sum = 0.0, values = 0.0;
    for (int c = 0; c < 3; c++) {
        const float *r = satin_film_channel(reference, beauty_name[c]);
        const float *v = film_variance(reference, variance_name[c]);
        if (!r || !v) return (double)NAN;
        for (size_t i = 0; i < pixels_of(reference); i++) {
            if (left_out[i]) continue;
            sum += (double)v[i] / ((double)r[i] * (double)r[i] + SQUARE_FLOOR);
            values += 1.0;
        }
    }
    return values > 0.0 ? sum / values : (double)NAN;
}

bool study_errors_find(satin_film *const *image, size_t count,
                       const struct study_reference *reference, bool mask_emission,
                       struct study_errors *out) {
    const double unknown = (double)NAN;
    *out = (struct study_errors){count,   unknown, unknown, unknown, unknown,
                                 unknown, unknown, unknown, unknown};
    // An array of no elements would be NULL.
    const size_t most = count ? count : 1;
    struct comparison c = {.x = array_new(most, sizeof *c.x),
                           .left_out = array_new(pixels_of(reference->mean), 1),
                           .gram = {.count = count,
                                    .sum = array_new(most * most, sizeof(double)),
                                    .mean = array_new(most, sizeof(double))}};
    const bool memory = c.gram.sum && c.gram.mean && c.x && c.left_out;
    if (memory) {
        for (size_t s = 0; s < count; s++) mark_pixels(image[s], mask_emission, c.left_out);
        mark_pixels(reference->mean, mask_emission, c.left_out);
        out->reference_noise = reference_noise(reference->mean, c.left_out);
    }
    if (memory && count) {
        compare_with(&c, image, reference->mean);
        if (c.gram.values > 0.0) {
            evaluate_gram(&c.gram, out);
            add_reference_noise(&c, image, reference, out);
        }
    }
    free(c.gram.sum);
    free(c.gram.mean);
    free(c.x);
    free(c.left_out);
    return memory;
}

size_t study_reference_nonfinite(const satin_film *reference) {
    size_t count = 0;
    const float *value[3];
    for (int c = 0; c < 3; c++) value[c] = satin_film_channel(reference, beauty_name[c]);
    for (size_t i = 0; i < pixels_of(reference); i++)
        count += !isfinite(value[0][i]) || !isfinite(value[1][i]) || !isfinite(value[2][i]);
    return count;
}

// ---- References ---------------------------------------------------------------------------------

// The mean of one channel of all pieces but one, and the variance of that mean.
static bool average_plane(satin_film *const *piece, size_t count, size_t without, int channel,
                          satin_film *out) {
    float *mean = film_channel(out, beauty_name[channel]);
    float *variance = film_channel(out, variance_name[channel]);
    const double n = (double)(without < count ? count - 1 : count);
    for (size_t i = 0; i < pixels_of(out); i++) {
        double sum = 0.0, squares = 0.0;
        for (size_t k = 0; k < count; k++) {
            const float *value = satin_film_channel(piece[k], beauty_name[channel]);
            if (!value) return false;
            if (k == without) continue;
            sum += (double)value[i];
            squares += (double)value[i] * (double)value[i];
        }
        const double m = sum / n;
        mean[i] = (float)m;
        variance[i] = (float)fmax((squares / n - m * m) / (n - 1.0), 0.0);
    }
    return true;
}

// The mean of all pieces but one; `count` for all.
static satin_film *average_without(satin_film *const *piece, size_t count, size_t without) {
    const char *names[] = {beauty_name[0],   beauty_name[1],   beauty_name[2],
                           variance_name[0], variance_name[1], variance_name[2],
                           emission_name[0], emission_name[1], emission_name[2]};
    satin_film *out = film_new(piece[0]->width, piece[0]->height, names, 9);
    bool good = out != NULL;
    for (size_t k = 1; k < count && good; k++)
        good = piece[k]->width == out->width && piece[k]->height == out->height;
    for (int c = 0; c < 3 && good; c++) {
        const float *emission = satin_film_channel(piece[0], emission_name[c]);
        if (emission)
            memcpy(film_channel(out, emission_name[c]), emission, pixels_of(out) * sizeof(float));
        good = average_plane(piece, count, without, c, out);
    }
    if (good) return out;
    satin_film_free(out);
    return NULL;
}

void study_reference_free(struct study_reference *reference) {
    satin_film_free(reference->mean);
    for (size_t k = 0; k < reference->pieces; k++) satin_film_free(reference->without[k]);
    free(reference->without);
    *reference = (struct study_reference){0};
}

bool study_reference_average(satin_film *const *piece, size_t count, struct study_reference *out) {
    struct study_reference made = {.mean = average_without(piece, count, count)};
    bool good = made.mean != NULL;
    if (good && count >= 3) {
        made.without = array_new(count, sizeof *made.without);
        good = made.without != NULL;
        for (size_t k = 0; k < count && good; k++) {
            made.without[k] = average_without(piece, count, k);
            good = made.without[k] != NULL;
            made.pieces += good;
        }
    }
    if (good)
        *out = made;
    else
        study_reference_free(&made);
    return good;
}
