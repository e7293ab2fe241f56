// SPDX-License-Identifier: Apache-2.0
// What caches of indirect light get wrong, one scene of data/scenes/cases for each: the image in
// two passes, with no option changed, against a path-traced reference in the region that matters.
//
//     cases SCENES REFERENCES [NAME]
//
// prints a line per region. References have mean and variance per pixel, see make_references.py.
// Over the region's pixels and channels, x the image, r the reference, v its variance:
//
//     mean   |sum x / sum r - 1|                        bias
//     rms    sqrt(mean((x - r)^2 - v)) / mean(r)        everything
//     block  largest |mean of x - r in 3x3| / mean(r)   visible blotches
//
// The seed is fixed; docs/experiments/cache-errors.md has the errors that were measured with it. On
// failure cases-NAME.exr in the working folder holds the image.
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "film/film.h"
#include "satin/render.h"

enum { CHANNELS = 3, SIZE = 64, SEEDS_MOST = 4 };
static const char *const cases_colour[CHANNELS] = {"R", "G", "B"};

// Pixels x0 <= x < x1, y0 <= y < y1, rows from the top.
struct region {
    const char *name;
    int x0, y0, x1, y1;
};

struct cases_errors {
    double mean, rms, block;
};

struct row {
    const char *scene, *reference;  // names of files
    struct region region;
    struct cases_errors bound;
    int seeds;  // number of renders whose mean is compared
};

// Renders of a scene with different seeds.
struct renders {
    satin_film *film[SEEDS_MOST];
    int count;
};

static const struct row cases_rows[] = {
    {"backlit", "backlit", {"front of the screen", 16, 18, 50, 50}, {0.015, 0.025, 0.07}, 1},
    {"bump", "bump", {"floor", 0, 34, 64, 64}, {0.015, 0.04, 0.15}, 1},
    {"bump-walls", "bump-walls", {"room", 0, 0, 64, 64}, {0.01, 0.02, 0.15}, 1},
    {"caustic-gloss", "caustic-gloss", {"focus", 28, 38, 54, 52}, {0.02, 0.08, 0.2}, 1},
    {"caustic-bump", "caustic-bump", {"floor", 0, 26, 64, 64}, {0.005, 0.02, 0.07}, 1},
    {"contact", "contact", {"foot of the chest", 8, 38, 42, 58}, {0.02, 0.06, 0.25}, 1},
    {"corner", "corner", {"corner", 18, 18, 46, 50}, {0.01, 0.03, 0.11}, 1},
    {"gap", "gap", {"floor", 0, 40, 64, 64}, {0.02, 0.04, 0.1}, 1},
    {"gap", "gap", {"wall", 0, 16, 64, 35}, {0.02, 0.04, 0.1}, 1},
    // Harmonics ring around the lamp's image at the rim of the ball, several times as bright as the
    // mean, of which the worst blocks are 7 and 13 %.
    {"glossy-room", "glossy-room", {"wall and ball", 12, 12, 52, 52}, {0.01, 0.03, 0.13}, 1},
    {"metal-room", "metal-room", {"wall and ball", 12, 12, 52, 52}, {0.01, 0.04, 0.2}, 1},
    {"mirror", "mirror", {"floor in the mirror", 8, 32, 56, 48}, {0.015, 0.04, 0.15}, 1},
    {"panes", "panes", {"room", 0, 0, 64, 64}, {0.02, 0.06, 0.25}, 1},
    {"room-5m", "room-5m", {"below the lamp", 0, 28, 64, 64}, {0.015, 0.04, 0.2}, 1},
    {"spot", "spot-lamp", {"room", 0, 8, 64, 64}, {0.03, 0.1, 0.2}, 1},
    {"stairs", "stairs", {"steps", 4, 14, 64, 46}, {0.01, 0.03, 0.12}, 1},
    {"storeys", "storeys", {"above", 0, 14, 64, 31}, {0.02, 0.05, 0.15}, 1},
    {"storeys", "storeys", {"below", 0, 33, 64, 62}, {0.02, 0.05, 0.15}, 1},
    {"thin-wall", "thin-wall", {"bright side", 14, 14, 31, 62}, {0.02, 0.05, 0.15}, 1},
    // The dark side has one photon in a hundred: means of single renders deviate by .65 %.
    {"thin-wall", "thin-wall", {"dark side", 33, 14, 50, 62}, {0.02, 0.05, 0.15}, 4},
    {"window", "window", {"room", 0, 0, 64, 64}, {0.01, 0.03, 0.2}, 1},
};

// Where scenes and their references are.
struct folders {
    const char *scenes, *references;
};

static void cases_say(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    (void)severity;
    fprintf(stderr, "cases: %s\n", message);
}

// The scene's image in two passes; NULL if it fails, which is reported.
// `settings`: 2, or 3 to gather only where there is no record.
static satin_film *cases_render_by(const struct folders *in, const char *name,
                                   const satin_define *defines, size_t define_count, uint64_t seed,
                                   size_t settings) {
    static const satin_setting setting[] = {
        {"spp", "64"}, {"adaptive-sampling", "off"}, {"gather-radius-ratio", "0"}};
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.xml", in->scenes, name);
    satin_scene *scene = NULL;
    satin_film *film = NULL;
    satin_options options;
    satin_callbacks callbacks = {.log = cases_say};
    if (satin_scene_load(path, defines, define_count, cases_say, NULL, &scene) == SATIN_OK &&
        satin_options_resolve(scene, setting, settings, cases_say, NULL, &options) == SATIN_OK) {
        options.width = options.height = SIZE;
        options.seed = seed;
        (void)satin_render(scene, &options, &callbacks, &film);
    }
    satin_scene_free(scene);
    return film;
}

static satin_film *cases_render(const struct folders *in, const char *name,
                                const satin_define *defines, size_t define_count, uint64_t seed) {
    return cases_render_by(in, name, defines, define_count, seed, 2);
}

// False if a render fails.
static bool render_plain(const struct folders *in, const char *name, int seeds,
                         struct renders *out) {
    const satin_define box = {"filter", "box"};
    *out = (struct renders){.count = seeds};
    bool good = true;
    for (int i = 0; i < out->count; i++) {
        out->film[i] = cases_render(in, name, &box, 1, (uint64_t)i);
        good = good && out->film[i];
    }
    return good;
}

static void renders_free(struct renders *renders) {
    for (int i = 0; i < renders->count; i++) satin_film_free(renders->film[i]);
}

// Whether the reference was made for the scene file as it is now; false is reported.
static bool is_current(const struct folders *in, const satin_film *film, const char *name) {
    char path[4096], hash[17], *data;
    size_t size;
    snprintf(path, sizeof path, "%s/%s.xml", in->scenes, name);
    const struct log log = {cases_say, NULL};
    if (fileio_read(log, (struct log_place){0}, path, 1 << 20, &data, &size) != SATIN_OK)
        return false;
    snprintf(hash, sizeof hash, "%016" PRIx64, fileio_hash(FILEIO_HASH, data, size));
    free(data);
    const char *made_for = film_attribute_get(film, "scene_hash");
    bool good = made_for && strcmp(made_for, hash) == 0 && film->width == SIZE &&
                film->height == SIZE && satin_film_channel(film, "variance.B");
    if (!good) fprintf(stderr, "cases: %s.exr is not of %s\n", name, path);
    return good;
}

static satin_film *read_reference(const struct folders *in, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.exr", in->references, name);
    satin_film *film = NULL;
    if (satin_film_read(path, cases_say, NULL, &film) != SATIN_OK) return NULL;
    if (is_current(in, film, name)) return film;
    satin_film_free(film);
    return NULL;
}

// Sets x to the mean of a channel over the renders.
static void average(const struct renders *renders, const char *channel, double x[SIZE * SIZE]) {
    for (int i = 0; i < SIZE * SIZE; i++) {
        x[i] = 0.0;
        for (int k = 0; k < renders->count; k++)
            x[i] += (double)satin_film_channel(renders->film[k], channel)[i] / renders->count;
    }
}

// Mean of x - r over the 3x3 pixels around i.
static double around(const double *x, const float *r, int i) {
    double sum = 0.0;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++)
            sum += x[i + dy * SIZE + dx] - (double)r[i + dy * SIZE + dx];
    return sum / 9.0;
}

// A reference without channels of variance is taken as exact.
static struct cases_errors cases_measure(const struct renders *renders, const satin_film *reference,
                                         const struct region *at) {
    static double x[SIZE * SIZE];
    double sum_x = 0.0, sum_r = 0.0, squares = 0.0, worst = 0.0;
    int count = 0;
    for (int c = 0; c < CHANNELS; c++) {
        char name[16];
        snprintf(name, sizeof name, "variance.%s", cases_colour[c]);
        average(renders, cases_colour[c], x);
        const float *r = satin_film_channel(reference, cases_colour[c]);
        const float *v = satin_film_channel(reference, name);
        for (int i = at->y0 * SIZE; i < at->y1 * SIZE; i++) {
            int column = i % SIZE, line = i / SIZE;
            if (column < at->x0 || column >= at->x1) continue;
            double d = x[i] - (double)r[i];
            sum_x += x[i];
            sum_r += (double)r[i];
            squares += d * d - (v ? (double)v[i] : 0.0);
            count++;
            if (column > at->x0 && column < at->x1 - 1 && line > at->y0 && line < at->y1 - 1)
                worst = fmax(worst, fabs(around(x, r, i)));
        }
    }
    double mean = sum_r / count;
    return (struct cases_errors){fabs(sum_x / sum_r - 1.0), sqrt(fmax(squares / count, 0.0)) / mean,
                                 worst / mean};
}

static bool cases_evaluate(const char *scene, const struct region *region, struct cases_errors e,
                           struct cases_errors bound) {
    bool good = e.mean <= bound.mean && e.rms <= bound.rms && e.block <= bound.block;
    printf("%-14s %-20s mean %6.2f %%  rms %6.2f %%  block %6.2f %%%s\n", scene, region->name,
           100.0 * e.mean, 100.0 * e.rms, 100.0 * e.block, good ? "" : "  FAILED");
    if (!good)
        printf("%-14s %-20s      %6.2f         %6.2f          %6.2f\n", "", "bound",
               100.0 * bound.mean, 100.0 * bound.rms, 100.0 * bound.block);
    fflush(stdout);
    return good;
}

static bool run_row(const struct folders *in, const struct row *row) {
    struct renders renders;
    const bool rendered = render_plain(in, row->scene, row->seeds, &renders);
    satin_film *reference = read_reference(in, row->reference);
    bool good = rendered && reference;
    if (good)
        good = cases_evaluate(row->scene, &row->region,
                              cases_measure(&renders, reference, &row->region), row->bound);
    char path[64];
    snprintf(path, sizeof path, "cases-%s.exr", row->scene);
    if (rendered && !good &&
        satin_film_write_exr(renders.film[0], path, cases_say, NULL) == SATIN_OK)
        printf("%-14s see %s\n", row->scene, path);
    renders_free(&renders);
    satin_film_free(reference);
    return good;
}

// The room in another unit of length gives the same image except for rounding, which sometimes
// moves a record or changes its rays: over twelve renders rms .0 to 1.1 %, largest block .0 to 12
// %, less than two seeds differ by.
static bool run_unit(const struct folders *in, const char *name) {
    static const struct region all = {"as the room of 5 m", 0, 0, SIZE, SIZE};
    static const struct cases_errors bound = {0.002, 0.015, 0.15};
    struct renders renders, other;
    bool good = render_plain(in, name, 1, &renders);
    good = render_plain(in, "room-5m", 1, &other) && good;
    good = good && cases_evaluate(name, &all, cases_measure(&renders, other.film[0], &all), bound);
    renders_free(&renders);
    renders_free(&other);
    return good;
}

static double stat_of(const satin_film *film, const char *name) {
    const char *at = film ? strstr(satin_film_stats(film), name) : NULL;
    return at ? strtod(at + strlen(name) + strlen("\": "), NULL) : NAN;
}

// Waves in the normals of a floor take no more radiance records than the flat floor does, except by
// chance; all radiance records are on the floor. (The walls' records follow the light that the
// waves scatter.)
static bool run_bump(const struct folders *in) {
    static const satin_define flat[] = {{"filter", "box"}, {"waves", "0"}};
    static const satin_define box[] = {{"filter", "box"}};
    satin_film *waves = cases_render(in, "bump", box, 1, 0),
               *plane = cases_render(in, "bump", flat, 2, 0);
    double a = stat_of(waves, "records.radiance"), b = stat_of(plane, "records.radiance");
    bool good = a <= 1.05 * b;
    printf("%-14s %-20s %.0f with waves, %.0f flat%s\n", "bump", "records of the floor", a, b,
           good ? "" : "  FAILED");
    satin_film_free(waves);
    satin_film_free(plane);
    return good;
}

// Where waves are so steep that radiance records do not serve, the floor has irradiance records for
// the diffuse lobe: almost no point is without a record.
static bool run_steep(const struct folders *in) {
    static const satin_define steep[] = {{"filter", "box"}, {"waves", "0.5"}};
    satin_film *film = cases_render_by(in, "bump", steep, 2, 0, 3);
    double fraction = stat_of(film, "image.gathered") / stat_of(film, "image.points");
    bool good = fraction <= 0.001;
    printf("%-14s %-20s %.4f %% of the points%s\n", "bump", "gathered on steep", 100.0 * fraction,
           good ? "" : "  FAILED");
    satin_film_free(film);
    return good;
}

// Whether to run a case; counts those that are.
static bool wanted(const char *name, const char *scene, int *found) {
    bool is = !name || strcmp(name, scene) == 0;
    *found += is;
    return is;
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "usage: cases SCENES REFERENCES [NAME]\n");
        return 2;
    }
    const struct folders in = {argv[1], argv[2]};
    const char *name = argc > 3 ? argv[3] : NULL;
    int found = 0, failed = 0;
    for (size_t i = 0; i < sizeof cases_rows / sizeof *cases_rows; i++)
        if (wanted(name, cases_rows[i].scene, &found)) failed += !run_row(&in, &cases_rows[i]);
    static const char *const units[] = {"room-500km", "room-5mm"};
    for (int i = 0; i < 2; i++)
        if (wanted(name, units[i], &found)) failed += !run_unit(&in, units[i]);
    if (wanted(name, "bump", &found)) failed += !run_bump(&in) + !run_steep(&in);
    if (!found) fprintf(stderr, "cases: there is no case %s\n", name);
    return !found || failed;
}
