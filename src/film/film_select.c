// SPDX-License-Identifier: Apache-2.0
// What of two images is compared: a box of pixels and a layer, as films that have nothing else.
// Also what the comparison shows of a pixel.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "film/film.h"

static const double ERROR_FLOOR = 0.01;  // as that of relMSE

enum { CHANNEL_NAME = 128 };

static bool same_whole(const struct satin_film *a, const struct satin_film *b) {
    return a->full_width == b->full_width && a->full_height == b->full_height;
}

satin_status film_common_box(const struct satin_film *a, const struct satin_film *b, struct log log,
                             int box[4]) {
    const bool one_size = a->width == b->width && a->height == b->height;
    if (!same_whole(a, b) || (!one_size && (a->x == b->x) && (a->y == b->y) &&
                              a->full_width == a->width && b->full_width == b->width))
        return log_fail(log, SATIN_ERROR_INPUT, "the images differ in size: %dx%d and %dx%d",
                        a->full_width, a->full_height, b->full_width, b->full_height);
    const int x0 = a->x > b->x ? a->x : b->x, y0 = a->y > b->y ? a->y : b->y;
    const int ax = a->x + a->width, bx = b->x + b->width, x1 = ax < bx ? ax : bx;
    const int ay = a->y + a->height, by = b->y + b->height, y1 = ay < by ? ay : by;
    if (x1 <= x0 || y1 <= y0)
        return log_fail(log, SATIN_ERROR_INPUT, "the images are crops without a common pixel");
    box[0] = x0;
    box[1] = y0;
    box[2] = x1 - x0;
    box[3] = y1 - y0;
    return SATIN_OK;
}

static const float *layer_channel(const struct satin_film *film, const char *layer, int c) {
    static const char color[3] = {'R', 'G', 'B'};
    char name[CHANNEL_NAME];
    snprintf(name, sizeof name, "%s%s%c", layer, *layer ? "." : "", color[c]);
    return satin_film_channel(film, name);
}

static void copy_box(const struct satin_film *film, const float *from, const int box[4],
                     float *to) {
    for (int y = 0; y < box[3]; y++) {
        const size_t row = (size_t)(box[1] - film->y + y) * (size_t)film->width;
        memcpy(to + (size_t)y * (size_t)box[2], from + row + (size_t)(box[0] - film->x),
               (size_t)box[2] * sizeof *to);
    }
}

satin_status film_select(const struct satin_film *film, const char *name, const char *layer,
                         const int box[4], struct log log, struct satin_film **out) {
    static const char *const names[] = {"R",          "G",          "B",
                                        "variance.R", "variance.G", "variance.B",
                                        "emission.R", "emission.G", "emission.B"};
    const char *const layers[3] = {layer ? layer : "", "variance", "emission"};
    const float *from[9];
    const char *found[9];
    int count = 0;
    if (box[0] < film->x || box[1] < film->y || box[2] < 1 || box[3] < 1 ||
        (int64_t)box[0] + box[2] > (int64_t)film->x + film->width ||
        (int64_t)box[1] + box[3] > (int64_t)film->y + film->height)
        return log_fail(log, SATIN_ERROR_INPUT, "%s: it does not have the %dx%d pixels at (%d, %d)",
                        name, box[2], box[3], box[0], box[1]);
    const bool bound = !film_variance(film, "variance.R");
    for (int i = 0; i < 9; i++) {
        const float *channel = layer_channel(film, layers[i / 3], i % 3);
        if (!channel && i < 3)
            return log_fail(log, SATIN_ERROR_INPUT, "%s: it has no channels %s%sR, G and B", name,
                            layers[0], layer ? "." : "");
        // The variance in a reference is that of the beauty; a bound of it is not subtracted.
        if (!channel || ((layer || bound) && i / 3 == 1)) continue;
        from[count] = channel;
        found[count++] = names[i];
    }
    struct satin_film *made = film_new(box[2], box[3], found, count);
    if (!made) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", name);
    made->x = box[0];
    made->y = box[1];
    made->full_width = film->full_width;
    made->full_height = film->full_height;
    for (int i = 0; i < count; i++) copy_box(film, from[i], box, made->channel[i]);
    *out = made;
    return SATIN_OK;
}

void film_pixel_errors(const struct satin_film *image, const struct satin_film *reference,
                       const unsigned char *kind, float *out) {
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < count; i++) {
        double sum = 0.0;
        out[i] = kind[i] == FILM_PIXEL_MASKED ? 0.0f : NAN;
        if (kind[i] != FILM_PIXEL_COMPARED) continue;
        for (int c = 0; c < 3; c++) {
            const double r = (double)reference->channel[c][i];
            const double d = (double)image->channel[c][i] - r;
            sum += d * d / (r * r + ERROR_FLOOR);
        }
        out[i] = (float)sqrt(sum / 3.0);
    }
}
