// SPDX-License-Identifier: Apache-2.0
// Figure 5.6 of [K05]: the image of a strongly curved glossy body with exact and with approximate
// rotation of the radiance records, and their difference in colours. Both bases; the fast rotation
// up to the default angle, up to the thesis' 1.25 a, and always.
//
// usage: fig_5_6 SCENE.xml FOLDER [WIDTH [ORDER]]        (default 256, 10); writes FOLDER/*.png and
// prints a table in Markdown
//
// Differences are those of RGB clamped to [0, 1] in linear radiance, as the thesis has them, and
// relative to the exact image's luminance, over pixels whose luminance is above 1 % of the mean.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_log.h"
#include "film/film.h"
#include "satin/render.h"

static const char *const color[] = {"R", "G", "B"};

static satin_film *render_aligned(const satin_scene *scene, satin_basis basis, float rotation,
                                  int width, int order) {
    satin_options options = satin_options_default;
    options.width = options.height = width;
    options.radiance_basis = basis;
    options.radiance_order = order;
    options.radiance_rotation = rotation;
    // Both follow what the image shows, so a small difference would move records and samples.
    options.adaptive_cache = options.adaptive_sampling = false;
    satin_callbacks callbacks = {.log = bench_print_error};
    satin_film *film = NULL;
    if (satin_render(scene, &options, &callbacks, &film) != SATIN_OK) return NULL;
    return film;
}

struct difference_measure {
    double largest, mean;                    // on [0, 1]
    double largest_relative, mean_relative;  // of luminance
};

static double luminance_at(const satin_film *f, size_t i) {
    return (double)rgb_luminance(rgb_make(satin_film_channel(f, "R")[i],
                                          satin_film_channel(f, "G")[i],
                                          satin_film_channel(f, "B")[i]));
}

// Blue at 0, green at .5 %, red at 1 % and above: the threshold of visibility.
static void paint(satin_film *picture, size_t i, double difference) {
    double t = fmin(difference / 0.01, 1.0);
    film_channel(picture, "R")[i] = (float)fmax(2 * t - 1, 0.0);
    film_channel(picture, "G")[i] = (float)(1 - fabs(2 * t - 1));
    film_channel(picture, "B")[i] = (float)fmax(1 - 2 * t, 0.0);
}

static struct difference_measure measure_difference(const satin_film *exact, const satin_film *fast,
                                                    size_t count, satin_film *picture) {
    struct difference_measure m = {0};
    double mean = 0.0, counted = 0.0;
    for (size_t i = 0; i < count; i++) mean += luminance_at(exact, i) / (double)count;
    for (size_t i = 0; i < count; i++) {
        double difference = 0.0;
        for (int c = 0; c < 3; c++) {
            double a = (double)satin_film_channel(exact, color[c])[i];
            double b = (double)satin_film_channel(fast, color[c])[i];
            difference = fmax(difference, fabs(fmin(fmax(a, 0), 1) - fmin(fmax(b, 0), 1)));
        }
        m.largest = fmax(m.largest, difference);
        m.mean += difference / (double)count;
        paint(picture, i, difference);
        double l = luminance_at(exact, i);
        if (l < 0.01 * mean) continue;
        double relative = fabs(luminance_at(fast, i) - l) / l;
        m.largest_relative = fmax(m.largest_relative, relative);
        m.mean_relative += relative;
        counted++;
    }
    m.mean_relative /= fmax(counted, 1.0);
    return m;
}

static void save(const satin_film *film, const char *folder, const char *basis, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s-%s.png", folder, basis, name);
    satin_film_write_png(film, path, NULL, bench_print_error, NULL);
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "usage: fig_5_6 SCENE.xml FOLDER [WIDTH [ORDER]]\n");
        return 2;
    }
    int width = argc > 3 ? atoi(argv[3]) : 256, order = argc > 4 ? atoi(argv[4]) : 10;
    const float thesis = 1.25f * satin_options_default.radiance_a;
    char angle[32];
    snprintf(angle, sizeof angle, "1.25 a = %.3f rad", (double)thesis);
    const struct {
        const char *name, *what;
        float rotation;
    } cases[] = {{"small", ".05 rad", 0.05f}, {"1.25a", angle, thesis}, {"always", "always", 4.0f}};
    satin_scene *scene = NULL;
    if (satin_scene_load(argv[1], NULL, 0, bench_print_error, NULL, &scene) != SATIN_OK) return 1;
    puts("| basis | fast up to | largest | mean | largest, relative | mean, relative |");
    puts("|---|---|---|---|---|---|");
    for (int b = 0; b < 2; b++) {
        const char *basis = b ? "sh" : "hsh";
        satin_film *exact = render_aligned(scene, b ? SATIN_SH : SATIN_HSH, 0.0f, width, order);
        satin_film *picture = film_new(width, width, color, 3);
        if (!exact || !picture) return 1;
        save(exact, argv[2], basis, "exact");
        for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
            satin_film *fast =
                render_aligned(scene, b ? SATIN_SH : SATIN_HSH, cases[k].rotation, width, order);
            if (!fast) return 1;
            struct difference_measure m =
                measure_difference(exact, fast, (size_t)width * (size_t)width, picture);
            printf("| %s | %s | %.2f %% | %.3f %% | %.1f %% | %.3f %% |\n", b ? "SH" : "HSH",
                   cases[k].what, 100.0 * m.largest, 100.0 * m.mean, 100.0 * m.largest_relative,
                   100.0 * m.mean_relative);
            save(picture, argv[2], basis, cases[k].name);
            satin_film_free(fast);
        }
        satin_film_free(exact);
        satin_film_free(picture);
    }
    satin_scene_free(scene);
    return 0;
}
