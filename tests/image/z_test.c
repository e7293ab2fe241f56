// SPDX-License-Identifier: Apache-2.0
// Tests whether satin's path-traced image differs from the reference by more than noise. Usage:
//
//     z_test SATIN SCENE.xml REFERENCE.exr PARTS SPP [ARGUMENT ...]
//
// Renders the scene PARTS times with different seeds at SPP samples per pixel, through the command
// with more ARGUMENTs, and compares with the reference (mean and variance per pixel, see
// make_references.py). The scene needs a box filter: then pixels are independent.
//
// Per pixel and channel t = (a - b) / sqrt(v / N_a + v / N_b), where v is the variance of one
// sample: the larger of the parts' and the reference's estimate. Pixels of a path tracer have heavy
// tails: an image that has none of the rare bright paths has too small a variance at a dark value,
// and the estimate from the other image corrects that; this lowers the power of the test a little.
// Then t has Student's distribution with the reference's degrees of freedom, and the two-sided
// p-values are corrected for their number after Sidak: with a correct renderer one test in a
// hundred or less fails. Measured on Mitsuba's own images instead of satin's, 200 tests for each
// scene: see docs/experiments/agreement.md.
//
// The mean over the image may differ by 0.3 % and 3.3 of its standard deviations (p = 0.001).
// On failure z_test-NAME.exr in the working folder holds the image and its z.
#include <errno.h>
#include <inttypes.h>
#include <libgen.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/fileio.h"
#include "film/film.h"

extern char **environ;

enum { CHANNELS = 3 };
static const double significance = 0.01;
static const double mean_tolerance = 0.003, mean_z = 3.3;
// The relative difference of two renderers in single precision where there is no noise at all.
static const double rounding = 1e-5;
// Mitsuba treats a density of microfacets below 1e-20 as 0: values darker than this are black.
static const double black = 1e-15;
static const char *const z_test_colour[CHANNELS] = {"R", "G", "B"};

// Sums over parts, per channel and pixel.
struct parts {
    int count, width, height;
    double *sum[CHANNELS], *squares[CHANNELS];
};

static void z_test_say(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    (void)severity;
    fprintf(stderr, "z_test: %s\n", message);
}

// What to render, as the command line has it.
struct z_test_job {
    char *satin, *scene, *spp;
    char **arguments;  // more for satin
    int argument_count, parts;
};

// Runs the command for one part; its image goes to `path`.
static bool render_part(const struct z_test_job *job, const struct parts *parts, char *path) {
    char seed[16], width[16], height[16];
    snprintf(seed, sizeof(seed), "%d", parts->count + 1);
    snprintf(width, sizeof(width), "%d", parts->width);
    snprintf(height, sizeof(height), "%d", parts->height);
    char *const fixed[] = {job->satin,     "render", job->scene, "-o",     path,      "--quiet",
                           "--integrator", "path",   "--spp",    job->spp, "--width", width,
                           "--height",     height,   "--seed",   seed};
    enum { FIXED = sizeof(fixed) / sizeof(*fixed) };
    char **command = calloc(FIXED + (size_t)job->argument_count + 1, sizeof(*command));
    if (!command) return false;
    memcpy(command, fixed, sizeof(fixed));
    memcpy(command + FIXED, job->arguments, (size_t)job->argument_count * sizeof(*command));
    pid_t child;
    int status;
    bool started = posix_spawn(&child, job->satin, NULL, NULL, command, environ) == 0;
    free(command);
    if (!started) return false;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return false;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static bool z_test_add_part(struct parts *parts, const char *path) {
    satin_film *film;
    if (satin_film_read(path, z_test_say, NULL, &film) != SATIN_OK) return false;
    bool good = film->width == parts->width && film->height == parts->height;
    for (int c = 0; good && c < CHANNELS; c++) {
        const float *x = satin_film_channel(film, z_test_colour[c]);
        for (int i = 0; i < parts->width * parts->height; i++) {
            parts->sum[c][i] += x[i];
            parts->squares[c][i] += (double)x[i] * x[i];
        }
    }
    parts->count++;
    satin_film_free(film);
    return good;
}

static bool render_parts(const struct z_test_job *job, struct parts *parts) {
    char folder[] = "/tmp/satin-z-XXXXXX", path[sizeof(folder) + 16];
    bool good = mkdtemp(folder) != NULL;
    snprintf(path, sizeof(path), "%s/part.exr", folder);
    while (good && parts->count < job->parts)
        good = render_part(job, parts, path) && z_test_add_part(parts, path);
    if (!good) fprintf(stderr, "z_test: %s cannot be rendered\n", job->scene);
    unlink(path);
    rmdir(folder);
    return good;
}

// The standard normal deviate that is as improbable as t is for Student's distribution with n
// degrees of freedom. [Wallace 1959: within 0.01 for n > 10 over the range that matters]
static double normal_of_student(double t, double n) {
    return copysign(sqrt(n * log1p(t * t / n)) * (8 * n + 1) / (8 * n + 3), t);
}

struct verdict {
    double least_p, worst_z, ratio, ratio_deviation;
    int worst_pixel, worst_channel;
};

// Compares channel c; z[i] gets each pixel's deviate.
static void z_test_evaluate(const struct parts *parts, double spp, const satin_film *reference,
                            int c, float *z, struct verdict *v) {
    const char *text = film_attribute_get(reference, "spp");
    double n_b = atof(text), n_a = spp * parts->count;
    double freedom = atof(film_attribute_get(reference, "parts")) - 1;
    char name[16];
    snprintf(name, sizeof(name), "variance.%s", z_test_colour[c]);
    const float *b = satin_film_channel(reference, z_test_colour[c]);
    const float *variance_b = satin_film_channel(reference, name);
    double sum_a = 0, sum_b = 0, sum_variance = 0;
    for (int i = 0; i < parts->width * parts->height; i++) {
        double a = parts->sum[c][i] / parts->count;
        double variance_a =
            fmax(0, parts->squares[c][i] / parts->count - a * a) / (parts->count - 1);
        double one = fmax(variance_a * n_a, variance_b[i] * n_b);
        double deviation = sqrt(one / n_a + one / n_b + pow(rounding * b[i] + black, 2));
        z[i] = a == b[i] ? 0.0f : (float)normal_of_student((a - b[i]) / deviation, freedom);
        double p = erfc(fabs(z[i]) / sqrt(2));
        if (!(p >= v->least_p)) {
            v->least_p = p;
            v->worst_z = z[i];
            v->worst_pixel = i;
            v->worst_channel = c;
        }
        sum_a += a;
        sum_b += b[i];
        sum_variance += variance_a + variance_b[i];
    }
    double ratio = sum_a / sum_b, ratio_deviation = sqrt(sum_variance) / sum_b;
    if (c == 0 || fabs(ratio - 1) > fabs(v->ratio - 1)) {
        v->ratio = ratio;
        v->ratio_deviation = ratio_deviation;
    }
}

// Evaluates all channels and prints the outcome; true if the image passes.
static bool z_test_compare(const struct parts *parts, double spp, const satin_film *reference,
                           const char *name) {
    const char *const names[] = {"R", "G", "B", "z.R", "z.G", "z.B"};
    struct satin_film *map = film_new(parts->width, parts->height, names, 2 * CHANNELS);
    if (!map) return false;
    struct verdict v = {.least_p = 2};
    int pixels = parts->width * parts->height;
    for (int c = 0; c < CHANNELS; c++) {
        for (int i = 0; i < pixels; i++)
            map->channel[c][i] = (float)(parts->sum[c][i] / parts->count);
        z_test_evaluate(parts, spp, reference, c, map->channel[CHANNELS + c], &v);
    }
    double limit = -expm1(log1p(-significance) / (pixels * CHANNELS));
    bool pixels_good = v.least_p >= limit;
    bool mean_good = fabs(v.ratio - 1) <= mean_tolerance + mean_z * v.ratio_deviation;
    printf(
        "%s: least p %.2g of %d (limit %.2g), z %.2f at pixel (%d, %d) channel %s; "
        "mean ratio %.4f +- %.4f\n",
        name, v.least_p, pixels * CHANNELS, limit, v.worst_z, v.worst_pixel % parts->width,
        v.worst_pixel / parts->width, z_test_colour[v.worst_channel], v.ratio, v.ratio_deviation);
    if (!pixels_good) printf("%s: the worst pixel differs by more than noise\n", name);
    if (!mean_good) printf("%s: the image's mean differs by more than 0.3 %% and noise\n", name);
    char path[256];
    snprintf(path, sizeof(path), "z_test-%s.exr", name);
    if (!(pixels_good && mean_good) &&
        satin_film_write_exr(map, path, z_test_say, NULL) == SATIN_OK)
        printf("%s: see %s\n", name, path);
    satin_film_free(map);
    return pixels_good && mean_good;
}

// Whether the reference was made for the scene file as it is now; false is reported.
static bool is_of_scene(const satin_film *reference, const char *scene, const char *name) {
    struct log log = {z_test_say, NULL};
    const size_t most = 1 << 24;
    char *data, hash[17];
    size_t size;
    if (fileio_read(log, (struct log_place){0}, scene, most, &data, &size) != SATIN_OK)
        return false;
    snprintf(hash, sizeof(hash), "%016" PRIx64, fileio_hash(FILEIO_HASH, data, size));
    free(data);
    const char *made_for = film_attribute_get(reference, "scene_hash");
    bool good = made_for && strcmp(made_for, hash) == 0;
    if (!good)
        fprintf(stderr, "z_test: %s.exr was made for another scene; run make_references.py\n",
                name);
    return good;
}

static bool is_reference(const satin_film *film, const char *name) {
    bool good = film_attribute_get(film, "spp") && film_attribute_get(film, "parts");
    const char *const names[] = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
    for (int i = 0; i < 2 * CHANNELS; i++) good = good && satin_film_channel(film, names[i]);
    if (!good) fprintf(stderr, "z_test: %s.exr is no reference image\n", name);
    return good;
}

static bool allocate(struct parts *parts) {
    bool good = true;
    for (int c = 0; c < CHANNELS; c++) {
        parts->sum[c] = calloc((size_t)parts->width * parts->height, sizeof(double));
        parts->squares[c] = calloc((size_t)parts->width * parts->height, sizeof(double));
        good = good && parts->sum[c] && parts->squares[c];
    }
    if (!good) fprintf(stderr, "z_test: not enough memory\n");
    return good;
}

int main(int argc, char **argv) {
    if (argc < 6 || atoi(argv[4]) < 2 || atoi(argv[5]) < 1) {
        fprintf(stderr, "usage: z_test SATIN SCENE.xml REFERENCE.exr PARTS SPP [ARGUMENT ...]\n");
        return 2;
    }
    struct z_test_job job = {argv[1], argv[2], argv[5], argv + 6, argc - 6, atoi(argv[4])};
    satin_film *reference;
    if (satin_film_read(argv[3], z_test_say, NULL, &reference) != SATIN_OK) return 2;
    struct parts parts = {.width = reference->width, .height = reference->height};
    char *name = basename(argv[3]);
    name[strcspn(name, ".")] = '\0';
    int status = 2;
    if (is_reference(reference, name) && is_of_scene(reference, job.scene, name) &&
        allocate(&parts) && render_parts(&job, &parts))
        status = z_test_compare(&parts, atof(job.spp), reference, name) ? 0 : 1;
    for (int c = 0; c < CHANNELS; c++) {
        free(parts.sum[c]);
        free(parts.squares[c]);
    }
    satin_film_free(reference);
    return status;
}
