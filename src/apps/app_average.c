// SPDX-License-Identifier: Apache-2.0
// satin average: the mean of independent renders of one image, of which each was made with a seed
// of its own, and the variance of that mean.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "apps/app_average_check.h"
#include "film/film.h"

enum { AVERAGE_FLAG_OUTPUT, AVERAGE_FLAG_HELP };

const struct app_flag app_average_flags[] = {
    {"--output", "-o", "OUT.exr", "The mean, with the variance of the mean in layer variance."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

static const char SAMPLES[] = "samples.Y", OPTIONS[] = "satin:options";
static const char *const variance_channels[3] = {"variance.R", "variance.G", "variance.B"};

// Sums over the images that were read so far.
struct averaging {
    char **path;
    int count;               // of images
    struct satin_film *out;  // R, G, B, their variance, and the channels that the first image has
    double *sum;             // of each channel of `out` after the first six, then of R, G and B
    double *square;          // of R, G and B
    struct averaged_image *image;  // what was read of each image
};

static bool is_variance(const char *name) { return strncmp(name, "variance.", 9) == 0; }

static size_t mean_pixels(const struct satin_film *film) {
    return (size_t)film->width * (size_t)film->height;
}

// Makes the film of the mean, like the first image.
static satin_status begin_average(struct averaging *a, const struct satin_film *first) {
    static const char *const beauty[3] = {"R", "G", "B"};
    const struct log log = {app_log_file, NULL};
    const char **name = calloc((size_t)first->channel_count + 6, sizeof *name);
    int count = 0;
    if (!name) return SATIN_ERROR_MEMORY;
    for (int c = 0; c < 3; c++) name[count++] = beauty[c];
    for (int c = 0; c < 3; c++) name[count++] = variance_channels[c];
    for (int i = 0; i < first->channel_count; i++) {
        const char *own = first->channel_name[i];
        const bool is_beauty = strlen(own) == 1 && strchr("RGB", own[0]);
        // Ids have no mean.
        if (!is_beauty && !is_variance(own) && !film_is_cryptomatte(own)) name[count++] = own;
    }
    a->out = film_new(first->width, first->height, name, count);
    free(name);
    const size_t pixels = mean_pixels(first);
    if (a->out) a->sum = calloc(pixels * (size_t)(count - 3), sizeof *a->sum);
    if (a->sum) a->square = calloc(pixels * 3, sizeof *a->square);
    if (!a->square) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the mean");
    // A comparison with the mean then sees what is wrong with an image.
    a->out->keep_nonfinite = true;
    a->out->x = first->x;
    a->out->y = first->y;
    a->out->full_width = first->full_width;
    a->out->full_height = first->full_height;
    a->out->camera = first->camera;
    memcpy(a->out->chromaticities, first->chromaticities, sizeof first->chromaticities);
    bool ok = true;
    for (int i = 0; i < first->attribute_count && ok; i++)
        // The variance of the mean is no bound, whatever that of the images is.
        if (strcmp(first->attribute[i].name, FILM_VARIANCE_ATTRIBUTE) != 0 &&
            strncmp(first->attribute[i].name, "cryptomatte/", 12) != 0)
            ok = film_attribute_set(a->out, first->attribute[i].name, first->attribute[i].value);
    return ok ? SATIN_OK : SATIN_ERROR_MEMORY;
}

static bool same_camera(const struct film_camera *a, const struct film_camera *b) {
    return a->known && b->known && memcmp(a->to_camera, b->to_camera, sizeof a->to_camera) == 0 &&
           memcmp(a->to_ndc, b->to_ndc, sizeof a->to_ndc) == 0;
}

// Leaves in the mean's header what this image's says too. Options are compared one by one, because
// seeds differ.
static void keep_common(struct satin_film *mean, const struct satin_film *image) {
    if (!same_camera(&mean->camera, &image->camera)) mean->camera.known = false;
    for (int i = mean->attribute_count - 1; i >= 0; i--) {
        struct film_attribute *own = &mean->attribute[i];
        const char *value = film_attribute_get(image, own->name);
        if (value && strcmp(own->name, OPTIONS) == 0)
            app_average_common_options(own->value, value);
        else if (!value || strcmp(own->value, value) != 0)
            film_attribute_remove(mean, own->name);
    }
}

static char *copy_attribute(const struct satin_film *image, const char *name, bool *ok) {
    const char *value = film_attribute_get(image, name);
    char *copy = value ? strdup(value) : NULL;
    *ok = *ok && (copy || !value);
    return copy;
}

// Refuses an image with other pixels, and warns of one that does not belong to those before it.
static satin_status check_image(struct averaging *a, int i, const struct satin_film *image) {
    const struct log log = {app_log_file, NULL};
    const struct satin_film *mean = a->out;
    bool ok = true;
    if (image->width != mean->width || image->height != mean->height || image->x != mean->x ||
        image->y != mean->y || image->full_width != mean->full_width ||
        image->full_height != mean->full_height)
        return log_fail(log, SATIN_ERROR_INPUT, "%s: it has other pixels than %s", a->path[i],
                        a->path[0]);
    if (!film_same_primaries(a->out->chromaticities, image->chromaticities))
        fprintf(stderr, "satin: warning: %s and %s have different chromaticities\n", a->path[i],
                a->path[0]);
    a->image[i] =
        (struct averaged_image){a->path[i], copy_attribute(image, "satin:scene_hash", &ok),
                                copy_attribute(image, OPTIONS, &ok)};
    if (ok) app_average_check(a->image, i + 1);
    return ok ? SATIN_OK : SATIN_ERROR_MEMORY;
}

// The plane of sums of channel i of the mean: those of R, G and B are the last ones.
static double *sums_of(const struct averaging *a, int i) {
    const int index = i < 3 ? a->out->channel_count - 6 + i : i - 6;
    return a->sum + (size_t)index * mean_pixels(a->out);
}

static satin_status add_image(struct averaging *a, const char *path,
                              const struct satin_film *image) {
    const struct log log = {app_log_file, NULL};
    const size_t pixels = mean_pixels(a->out);
    for (int i = 0; i < a->out->channel_count; i++) {
        if (i >= 3 && i < 6) continue;
        const char *name = a->out->channel_name[i];
        const float *value = satin_film_channel(image, name);
        double *sum = sums_of(a, i);
        if (!value) return log_fail(log, SATIN_ERROR_INPUT, "%s: it has no channel %s", path, name);
        for (size_t k = 0; k < pixels; k++) sum[k] += (double)value[k];
        if (i >= 3) continue;
        double *square = a->square + (size_t)i * pixels;
        for (size_t k = 0; k < pixels; k++) square[k] += (double)value[k] * (double)value[k];
    }
    return SATIN_OK;
}

static void finish_average(const struct averaging *a) {
    const double n = (double)a->count;
    const size_t pixels = mean_pixels(a->out);
    for (int i = 0; i < a->out->channel_count; i++) {
        if (i >= 3 && i < 6) continue;
        const double *sum = sums_of(a, i);
        // The samples of all images together made the mean.
        const double divisor = strcmp(a->out->channel_name[i], SAMPLES) == 0 ? 1.0 : n;
        for (size_t k = 0; k < pixels; k++) {
            const double mean = sum[k] / divisor;
            a->out->channel[i][k] = (float)mean;
            if (i >= 3) continue;
            const double square = a->square[(size_t)i * pixels + k];
            const double variance = (square / n - mean * mean) / (n - 1.0);
            // NaN stays NaN.
            a->out->channel[3 + i][k] = variance < 0.0 ? 0.0f : (float)variance;
        }
    }
}

static satin_status write_mean(struct averaging *a, const char *output) {
    satin_status status = SATIN_OK;
    char count[16];
    for (int i = 0; i < a->count && status == SATIN_OK; i++) {
        struct satin_film *image = NULL;
        status = satin_film_read(a->path[i], app_log_file, NULL, &image);
        if (status == SATIN_OK && i == 0) status = begin_average(a, image);
        if (status == SATIN_OK) status = check_image(a, i, image);
        if (status == SATIN_OK) status = add_image(a, a->path[i], image);
        if (status == SATIN_OK) keep_common(a->out, image);
        satin_film_free(image);
    }
    if (status != SATIN_OK) return status;
    finish_average(a);
    snprintf(count, sizeof count, "%d", a->count);
    if (!film_attribute_set(a->out, "parts", count)) return SATIN_ERROR_MEMORY;
    return satin_film_write_exr(a->out, output, app_log_file, NULL);
}

static int read_average_arguments(int argc, char **argv, struct averaging *a, const char **output,
                                  bool *help) {
    struct app_args args = {.argc = argc, .argv = argv};
    char *value;
    int flag, result = APP_DONE;
    while ((flag = app_args_next(&args, app_average_flags, NULL, &value)) != APP_END) {
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == AVERAGE_FLAG_HELP) *help = true;
        if (flag == AVERAGE_FLAG_OUTPUT) *output = value;
        if (flag == APP_POSITIONAL) a->path[a->count++] = value;
    }
    if (*help) return APP_DONE;
    if (a->count < 2 || !*output)
        return app_wrong("average takes images and a name: satin average A.exr B.exr -o OUT.exr");
    if (!app_ends_in(*output, ".exr")) return app_wrong("%s: a mean is written as .exr", *output);
    const struct app_output wanted = {*output, FILEIO_SEEK, NULL};
    for (int i = 0; i < a->count && result == APP_DONE; i++) {
        const struct app_input input[] = {{a->path[i], "an image of the mean"}, {NULL, NULL}};
        result = app_outputs_check(&wanted, 1, input);
    }
    return result;
}

int app_average(int argc, char **argv) {
    struct averaging a = {0};
    const char *output = NULL;
    bool help = false;
    a.path = calloc((size_t)argc + 1, sizeof *a.path);
    a.image = calloc((size_t)argc + 1, sizeof *a.image);
    if (!a.path || !a.image) {
        free(a.path);
        free(a.image);
        return app_no_memory();
    }
    int result = read_average_arguments(argc, argv, &a, &output, &help);
    if (result == APP_DONE && help) {
        result = app_help(1, (char *[]){"average"});
    } else if (result == APP_DONE) {
        const satin_status status = write_mean(&a, output);
        result = status == SATIN_ERROR_MEMORY ? app_no_memory() : (int)app_exit_of(status);
    }
    satin_film_free(a.out);
    free(a.sum);
    free(a.square);
    for (int i = 0; i < a.count; i++) {
        free(a.image[i].scene);
        free(a.image[i].options);
    }
    free(a.image);
    free(a.path);
    return result;
}
