// SPDX-License-Identifier: Apache-2.0
// Averages independent renders of one image: writes the mean of R, G, B and the variance of that
// mean. usage: average OUT.exr EMISSION.exr PART.exr PART.exr ...
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_log.h"
#include "film/film.h"

static const char *const color_channel[] = {"R", "G", "B"};
static const char *const emission[] = {"emission.R", "emission.G", "emission.B"};
static const char *const variance[] = {"variance.R", "variance.G", "variance.B"};

// Adds one part's values and squares to the sums in `out`'s channels.
static bool add_part(const char *path, struct satin_film *out, double *square) {
    satin_film *part = NULL;
    if (satin_film_read(path, bench_print_error, NULL, &part) != SATIN_OK) return false;
    size_t n = (size_t)out->width * (size_t)out->height;
    bool ok = part->width == out->width && part->height == out->height;
    for (int c = 0; ok && c < 3; c++) {
        const float *v = satin_film_channel(part, color_channel[c]);
        float *sum = film_channel(out, color_channel[c]);
        for (size_t i = 0; v && i < n; i++) {
            sum[i] += v[i];
            square[(size_t)c * n + i] += (double)v[i] * (double)v[i];
        }
        ok = v != NULL;
    }
    satin_film_free(part);
    return ok;
}

int main(int argc, char **argv) {
    if (argc < 5) {
        fprintf(stderr, "usage: average OUT.exr EMISSION.exr PART.exr PART.exr ...\n");
        return 2;
    }
    satin_film *first = NULL;
    if (satin_film_read(argv[2], bench_print_error, NULL, &first) != SATIN_OK) return 1;
    const char *names[] = {color_channel[0], color_channel[1], color_channel[2],
                           variance[0],      variance[1],      variance[2],
                           emission[0],      emission[1],      emission[2]};
    struct satin_film *out = film_new(first->width, first->height, names, 9);
    size_t n = (size_t)first->width * (size_t)first->height;
    for (int c = 0; out && c < 3; c++) {
        const float *from = satin_film_channel(first, emission[c]);
        if (from) memcpy(film_channel(out, emission[c]), from, n * sizeof *from);
    }
    satin_film_free(first);
    double *square = calloc(3 * n, sizeof *square);
    if (!out || !square) return 1;
    int parts = argc - 3;
    for (int i = 0; i < parts; i++)
        if (!add_part(argv[3 + i], out, square)) return 1;
    for (int c = 0; c < 3; c++) {
        float *mean = film_channel(out, color_channel[c]), *var = film_channel(out, variance[c]);
        for (size_t i = 0; i < n; i++) {
            double m = (double)mean[i] / parts;
            double v = (square[(size_t)c * n + i] / parts - m * m) / (parts - 1);
            mean[i] = (float)m;
            var[i] = (float)fmax(v, 0.0);
        }
    }
    struct log log = {bench_print_error, NULL};
    satin_status status = film_write_exr(out, argv[1], NULL, log);
    satin_film_free(out);
    free(square);
    return status == SATIN_OK ? 0 : 1;
}
