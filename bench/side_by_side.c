// SPDX-License-Identifier: Apache-2.0
// Puts one layer of several renders beside a reference: an image with the reference and each render
// in the upper row and below each image its difference, ten times enlarged, red where it is too
// bright and blue where it is too dark. Prints for each image the rms difference relative to the
// reference's mean, over all pixels where the reference's layer is not black, and the same over a
// part of the image.
//
//   side_by_side OUT.png LAYER EXPOSURE X0,Y0,X1,Y1 REFERENCE.exr IMAGE.exr ...
//
// LAYER is indirect_glossy or another layer; the part is given in fractions of width and height.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench_log.h"
#include "film/film.h"

enum { IMAGES_MOST = 12 };

static const float ENLARGED = 10.0f;

// A layer's three channels.
struct layer_of_film {
    satin_film *film;
    const float *channel[3];
};

static bool read_layer(const char *path, const char *name, struct layer_of_film *out) {
    if (satin_film_read(path, bench_print_error, NULL, &out->film) != SATIN_OK) return false;
    for (int c = 0; c < 3; c++) {
        char channel[64];
        snprintf(channel, sizeof channel, "%.50s.%c", name, "RGB"[c]);
        out->channel[c] = satin_film_channel(out->film, channel);
        if (!out->channel[c]) {
            fprintf(stderr, "%s: no channel %s\n", path, channel);
            return false;
        }
    }
    return true;
}

static float luminance_of_layer(const struct layer_of_film *l, size_t i) {
    return rgb_luminance(rgb_make(l->channel[0][i], l->channel[1][i], l->channel[2][i]));
}

// Pixels x0 <= x < x1, y0 <= y < y1.
struct picture_part {
    int x0, y0, x1, y1;
};

static double relative_rms(const struct layer_of_film *image, const struct layer_of_film *reference,
                           struct picture_part part) {
    double square = 0.0, sum = 0.0;
    size_t n = 0;
    for (int y = part.y0; y < part.y1; y++)
        for (int x = part.x0; x < part.x1; x++) {
            size_t i = (size_t)y * (size_t)reference->film->width + (size_t)x;
            if (!(luminance_of_layer(reference, i) > 0.0f)) continue;
            for (int c = 0; c < 3; c++) {
                double d = (double)image->channel[c][i] - (double)reference->channel[c][i];
                square += d * d / 3.0;
                sum += (double)reference->channel[c][i] / 3.0;
            }
            n++;
        }
    return n ? sqrt(square / (double)n) / (sum / (double)n) : NAN;
}

static void put_picture_pixel(struct satin_film *out, int x, int y, const float value[3]) {
    static const char *const name[] = {"R", "G", "B"};
    for (int c = 0; c < 3; c++)
        film_channel(out, name[c])[(size_t)y * (size_t)out->width + (size_t)x] = value[c];
}

// Column `at` of the output: a render, and below it its difference.
static void draw_difference(struct satin_film *out, int at, float exposure,
                            const struct layer_of_film *image,
                            const struct layer_of_film *reference) {
    const int width = reference->film->width, height = reference->film->height;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            size_t i = (size_t)y * (size_t)width + (size_t)x;
            float value[3];
            for (int c = 0; c < 3; c++) value[c] = exposure * image->channel[c][i];
            put_picture_pixel(out, at * width + x, y, value);
            float d = ENLARGED * exposure *
                      (luminance_of_layer(image, i) - luminance_of_layer(reference, i));
            put_picture_pixel(out, at * width + x, height + y,
                              (float[]){fmaxf(d, 0.0f), 0.1f * fabsf(d), fmaxf(-d, 0.0f)});
        }
}

int main(int argc, char **argv) {
    const int images = argc - 5;
    double box[4];
    if (images < 1 || images > IMAGES_MOST ||
        sscanf(argv[4], "%lf,%lf,%lf,%lf", &box[0], &box[1], &box[2], &box[3]) != 4) {
        fprintf(stderr,
                "usage: side_by_side OUT.png LAYER EXPOSURE X0,Y0,X1,Y1 REFERENCE.exr "
                "IMAGE.exr ...\n");
        return 2;
    }
    struct layer_of_film layer[IMAGES_MOST] = {{0}};
    for (int i = 0; i < images; i++) {
        if (!read_layer(argv[5 + i], argv[2], &layer[i])) return 1;
        if (layer[i].film->width != layer[0].film->width ||
            layer[i].film->height != layer[0].film->height) {
            fprintf(stderr, "%s has another size than %s\n", argv[5 + i], argv[5]);
            return 1;
        }
    }
    const int width = layer[0].film->width, height = layer[0].film->height;
    const struct picture_part all = {0, 0, width, height};
    const struct picture_part part = {(int)(box[0] * width), (int)(box[1] * height),
                                      (int)(box[2] * width), (int)(box[3] * height)};
    struct satin_film *out =
        film_new(images * width, 2 * height, (const char *const[]){"R", "G", "B"}, 3);
    if (!out) return 1;
    for (int i = 0; i < images; i++) {
        draw_difference(out, i, (float)atof(argv[3]), &layer[i], &layer[0]);
        if (i > 0)
            printf("%.5f %.5f\n", relative_rms(&layer[i], &layer[0], all),
                   relative_rms(&layer[i], &layer[0], part));
    }
    satin_status status = satin_film_write_png(out, argv[1], NULL, bench_print_error, NULL);
    satin_film_free(out);
    for (int i = 0; i < images; i++) satin_film_free(layer[i].film);
    return status == SATIN_OK ? 0 : 1;
}
