// SPDX-License-Identifier: Apache-2.0
// satin compare: the difference between images and a reference in words, as JSON, as a picture of
// the errors or as a page.
#include "apps/app_compare.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "base/text.h"

enum {
    COMPARE_FLAG_JSON,
    COMPARE_FLAG_MASK,
    COMPARE_FLAG_LAYER,
    COMPARE_FLAG_REGION,
    COMPARE_FLAG_FLIP,
    COMPARE_FLAG_ERROR_IMAGE,
    COMPARE_FLAG_HTML,
    COMPARE_FLAG_FAIL_OVER,
    COMPARE_FLAG_HELP
};

const struct app_flag app_compare_flags[] = {
    {"--json", NULL, NULL, "Prints one JSON object."},
    {"--mask-emission", NULL, NULL,
     "Leaves out pixels that see an emitter (layer emission of either image)."},
    {"--layer", NULL, "NAME", "Compares this layer, for example direct, instead of the beauty."},
    {"--region", NULL, "X,Y,W,H", "Compares these pixels alone."},
    {"--flip", NULL, NULL, "Computes FLIP too, the difference that a viewer sees."},
    {"--error-image", NULL, "FILE",
     "Writes a picture of the relative errors (.png), or the differences and errors (.exr)."},
    {"--html", NULL, "FILE",
     "Writes a page with the pictures, a slider and the errors; - for standard output."},
    {"--fail-over", NULL, "RELMSE",
     "Fails, with exit status 1, if relMSE is over this or a pixel is not finite."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

struct compare_request {
    char **path;  // images, and the reference as the last one
    int count;
    const char *layer, *error_image, *html;
    bool json, mask, flip, has_region, help;
    bool page_alone;  // standard output is the page
    int region[4];
    double limit;  // of relMSE; INFINITY: none
};

// ---- The comparison -----------------------------------------------------------------------------

// Warns if the files say that they are of different scenes, or that their colours are others.
static void compare_headers(const char *path, const struct satin_film *image, const char *other,
                            const struct satin_film *reference) {
    const char *a = film_attribute_get(image, "satin:scene_hash"),
               *b = film_attribute_get(reference, "satin:scene_hash");
    if (a && b && strcmp(a, b) != 0)
        fprintf(stderr, "satin: warning: %s and %s are of different scenes\n", path, other);
    if (!film_same_primaries(image->chromaticities, reference->chromaticities))
        fprintf(stderr, "satin: warning: %s and %s have different chromaticities\n", path, other);
}

// Warns of pixels that the figures leave out.
static void warn_nonfinite(const struct app_compared *c, const char *other) {
    const uint64_t count = c->difference.nonfinite;
    if (count)
        fprintf(stderr, "satin: warning: %s: %" PRIu64 " pixel%s not finite in it or in %s\n",
                c->path, count, count == 1 ? " is" : "s are", other);
}

// Copies the colours of a film, with black where pixels are not compared.
static float *copy_compared(const struct satin_film *film, const unsigned char *kind,
                            float *plane[3]) {
    const size_t count = (size_t)film->width * (size_t)film->height;
    float *copy = malloc(3 * count * sizeof *copy);
    for (size_t c = 0; c < 3 && copy; c++) {
        plane[c] = copy + c * count;
        for (size_t i = 0; i < count; i++)
            plane[c][i] = kind[i] == FILM_PIXEL_COMPARED ? film->channel[c][i] : 0.0f;
    }
    return copy;
}

// Pixels that are not compared are black in both pictures, so that they do not affect those beside
// them, and do not count in the mean.
static satin_status compute_flip(struct app_compared *c, struct log log) {
    const struct satin_film *image = c->image;
    const size_t count = (size_t)image->width * (size_t)image->height;
    float *a[3], *b[3];
    float *image_copy = copy_compared(image, c->kind, a);
    float *reference_copy = copy_compared(c->reference, c->kind, b);
    c->flip = malloc(count * sizeof *c->flip);
    satin_status status = SATIN_ERROR_MEMORY;
    if (image_copy && reference_copy && c->flip)
        status = film_flip((const float *const *)a, (const float *const *)b, image->width,
                           image->height, log, c->flip);
    double sum = 0.0;
    for (size_t i = 0; i < count && status == SATIN_OK; i++) {
        if (c->kind[i] == FILM_PIXEL_COMPARED) sum += (double)c->flip[i];
        if (c->kind[i] != FILM_PIXEL_COMPARED)
            c->flip[i] = c->kind[i] == FILM_PIXEL_MASKED ? 0.0f : NAN;
    }
    c->flip_mean = sum / (double)c->difference.compared;
    free(image_copy);
    free(reference_copy);
    return status;
}

// Compares one image; *c is to be destroyed even after a failure.
static satin_status compare_image(const struct compare_request *r, const char *path,
                                  const struct satin_film *reference, struct app_compared *c) {
    const struct log log = {app_log, NULL}, file_log = {app_log_file, NULL};
    const char *other = r->path[r->count - 1];
    struct satin_film *whole = NULL;
    int box[4];
    c->path = path;
    satin_status status = satin_film_read(path, app_log_file, NULL, &whole);
    if (status != SATIN_OK) return status;
    compare_headers(path, whole, other, reference);
    status = film_common_box(whole, reference, log, box);
    if (status == SATIN_OK && r->has_region) memcpy(box, r->region, sizeof box);
    if (status == SATIN_OK) status = film_select(whole, path, r->layer, box, file_log, &c->image);
    if (status == SATIN_OK)
        status = film_select(reference, other, r->layer, box, file_log, &c->reference);
    satin_film_free(whole);
    if (status == SATIN_OK)
        status = film_compare(c->image, c->reference, r->mask, log, &c->difference);
    if (status != SATIN_OK) return status;
    warn_nonfinite(c, other);
    const size_t count = (size_t)box[2] * (size_t)box[3];
    c->error = malloc(count * sizeof *c->error);
    c->kind = malloc(count);
    if (!c->error || !c->kind) return SATIN_ERROR_MEMORY;
    status = film_pixel_kinds(c->image, c->reference, r->mask, log, c->kind);
    if (status != SATIN_OK) return status;
    film_pixel_errors(c->image, c->reference, c->kind, c->error);
    return r->flip ? compute_flip(c, log) : SATIN_OK;
}

static void compared_destroy(struct app_compared *c) {
    satin_film_free(c->image);
    satin_film_free(c->reference);
    free(c->kind);
    free(c->error);
    free(c->flip);
}

// ---- Numbers ------------------------------------------------------------------------------------

// JSON has no infinity and no NaN.
static void print_json_number(const char *indent, const char *name, double value) {
    if (isfinite(value))
        printf("%s\"%s\": %.9g,\n", indent, name, value);
    else
        printf("%s\"%s\": null,\n", indent, name);
}

static void print_json_values(const char *indent, const struct app_compared *c) {
    const struct film_difference *d = &c->difference;
    print_json_number(indent, "rmse", d->rmse);
    print_json_number(indent, "relmse", d->relmse);
    print_json_number(indent, "psnr_db", d->psnr);
    print_json_number(indent, "mean_ratio", d->mean_ratio);
    print_json_number(indent, "discernible", d->discernible);
    if (c->flip) print_json_number(indent, "flip", c->flip_mean);
    printf("%s\"variance_subtracted\": %s,\n", indent, d->variance ? "true" : "false");
    printf("%s\"pixels\": %" PRIu64 ",\n%s\"masked\": %" PRIu64 ",\n%s\"nonfinite\": %" PRIu64 "\n",
           indent, d->compared, indent, d->masked, indent, d->nonfinite);
}

// One image is one object; several are a list of such objects, with their names.
static void print_json(const struct app_compared *compared, int count) {
    if (count == 1) {
        printf("{\n");
        print_json_values("  ", compared);
        printf("}\n");
        return;
    }
    printf("{\n  \"images\": [\n");
    for (int i = 0; i < count; i++) {
        printf("    {\n      \"image\": ");
        text_print_json(stdout, compared[i].path);
        printf(",\n");
        print_json_values("      ", &compared[i]);
        printf("    }%s\n", i + 1 < count ? "," : "");
    }
    printf("  ]\n}\n");
}

static void print_words(const struct app_compared *c) {
    const struct film_difference *d = &c->difference;
    const char *noise = d->variance ? ", the reference's noise subtracted" : "";
    printf("RMSE         %.6g%s\n", d->rmse, noise);
    printf("relMSE       %.6g%s\n", d->relmse, noise);
    printf("PSNR         %.2f dB\n", d->psnr);
    printf("mean         %+.3f %%\n", 100.0 * (d->mean_ratio - 1.0));
    printf("discernible  %.2f %% of pixels\n", 100.0 * d->discernible);
    if (c->flip) printf("FLIP         %.6f\n", c->flip_mean);
    printf("pixels       %" PRIu64 ", masked %" PRIu64 ", not finite %" PRIu64 "\n", d->compared,
           d->masked, d->nonfinite);
}

static void print_table(const struct app_compared *compared, int count) {
    int width = 5;
    for (int i = 0; i < count; i++) {
        const int length = (int)strlen(compared[i].path);
        if (length > width) width = length;
    }
    printf("%-*s %12s %12s %9s %10s %12s%s\n", width, "image", "RMSE", "relMSE", "PSNR", "mean",
           "discernible", compared[0].flip ? "     FLIP" : "");
    for (int i = 0; i < count; i++) {
        const struct film_difference *d = &compared[i].difference;
        printf("%-*s %12.6g %12.6g %6.2f dB %+8.3f %% %10.2f %%", width, compared[i].path, d->rmse,
               d->relmse, d->psnr, 100.0 * (d->mean_ratio - 1.0), 100.0 * d->discernible);
        if (compared[i].flip) printf(" %8.5f", compared[i].flip_mean);
        printf("\n");
    }
}

// ---- Pictures -----------------------------------------------------------------------------------

// Writes the signed differences in R, G and B, and the errors of the pixels: 0 in masked pixels,
// and NaN in those that are not finite.
static satin_status write_error_exr(const char *path, const struct app_compared *c,
                                    struct log log) {
    const char *const names[] = {"R", "G", "B", "error.Y", "flip.Y"};
    const size_t count = (size_t)c->image->width * (size_t)c->image->height;
    struct satin_film *film = film_new(c->image->width, c->image->height, names, c->flip ? 5 : 4);
    if (!film) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    for (int k = 0; k < 3; k++)
        for (size_t i = 0; i < count; i++)
            film->channel[k][i] = c->kind[i] == FILM_PIXEL_COMPARED
                                      ? c->image->channel[k][i] - c->reference->channel[k][i]
                                      : c->error[i];
    film->keep_nonfinite = true;
    satin_film_window(c->image, &film->x, &film->y, &film->full_width, &film->full_height);
    memcpy(film->channel[3], c->error, count * sizeof *c->error);
    if (c->flip) memcpy(film->channel[4], c->flip, count * sizeof *c->flip);
    // Warnings of what the images hold were printed when these were read.
    const satin_status status =
        film_write_exr(film, path, NULL, (struct log){app_log_file_errors, log.user});
    satin_film_free(film);
    return status;
}

static satin_status write_error_image(const char *path, const struct app_compared *c,
                                      struct log log) {
    float top = 0.0f;
    if (app_ends_in(path, ".exr")) return write_error_exr(path, c, log);
    const satin_status status = film_write_map(c->image, c->error, path, log, &top);
    // Standard output may be JSON.
    if (status == SATIN_OK)
        fprintf(stderr, "%s: the lightest colour is a relative error of %.3g\n", path, (double)top);
    return status;
}

// ---- The command --------------------------------------------------------------------------------

static int compare_flag(struct compare_request *r, int flag, char *value) {
    switch (flag) {
        case COMPARE_FLAG_JSON:
            r->json = true;
            return APP_DONE;
        case COMPARE_FLAG_MASK:
            r->mask = true;
            return APP_DONE;
        case COMPARE_FLAG_FLIP:
            r->flip = true;
            return APP_DONE;
        case COMPARE_FLAG_HELP:
            r->help = true;
            return APP_DONE;
        case COMPARE_FLAG_LAYER:
            if (!*value) return app_wrong("--layer needs the name of a layer");
            r->layer = value;
            return APP_DONE;
        case COMPARE_FLAG_ERROR_IMAGE:
            r->error_image = value;
            return APP_DONE;
        case COMPARE_FLAG_HTML:
            r->html = value;
            return APP_DONE;
        case COMPARE_FLAG_REGION:
            r->has_region = true;
            if (app_take_box(value, r->region)) return APP_DONE;
            return app_wrong("--region needs X,Y,W,H in pixels, such as 10,20,64,48, not '%s'",
                             value);
        case COMPARE_FLAG_FAIL_OVER:
            if (text_double(value, &r->limit) && r->limit >= 0.0) return APP_DONE;
            return app_wrong("--fail-over needs a relMSE such as 0.01, not '%s'", value);
        default:
            r->path[r->count++] = value;
            return APP_DONE;
    }
}

static int read_compare_arguments(int argc, char **argv, struct compare_request *r) {
    struct app_args args = {.argc = argc, .argv = argv};
    char *value;
    int flag, result = APP_DONE;
    while (result == APP_DONE &&
           (flag = app_args_next(&args, app_compare_flags, NULL, &value)) != APP_END)
        result = flag == APP_BAD ? (int)APP_WRONG : compare_flag(r, flag, value);
    if (result != APP_DONE || r->help) return result;
    if (r->count < 2)
        return app_wrong("compare takes images and a reference: satin compare IMAGE... REFERENCE");
    if (r->error_image && r->count > 2)
        return app_wrong("--error-image takes one image and a reference");
    if (r->error_image && !app_ends_in(r->error_image, ".png") &&
        !app_ends_in(r->error_image, ".exr"))
        return app_wrong("%s: an error image is written as .png or .exr", r->error_image);
    r->page_alone = r->html && strcmp(r->html, "-") == 0;
    if (r->page_alone) r->html = APP_STDOUT;
    if (r->page_alone && r->json)
        return app_wrong("--json and --html - both write to standard output");
    const struct app_output output[] = {
        {r->error_image,
         r->error_image && app_ends_in(r->error_image, ".exr") ? FILEIO_SEEK : FILEIO_APPEND, NULL},
        {r->html, FILEIO_APPEND, NULL}};
    for (int i = 0; i < r->count && result == APP_DONE; i++) {
        const struct app_input input[] = {{r->path[i], "an image that is compared"}, {NULL, NULL}};
        result = app_outputs_check(output, 2, input);
    }
    return result;
}

static int check_limit(const struct compare_request *r, const struct app_compared *compared,
                       int count) {
    int result = APP_DONE;
    if (!isfinite(r->limit)) return APP_DONE;
    for (int i = 0; i < count; i++) {
        const struct film_difference *d = &compared[i].difference;
        if (d->relmse <= r->limit && d->nonfinite == 0) continue;
        char text[512];
        if (d->nonfinite)
            snprintf(text, sizeof text, "%.400s: --fail-over needs pixels that are finite",
                     compared[i].path);
        else
            snprintf(text, sizeof text, "%.400s: relMSE %.6g is over %g", compared[i].path,
                     d->relmse, r->limit);
        app_log(NULL, SATIN_LOG_ERROR, text);
        result = APP_FAILED;
    }
    return result;
}

static int compare(const struct compare_request *r) {
    const struct log file_log = {app_log_file, NULL};
    const int count = r->count - 1;
    const char *other = r->path[count];
    struct satin_film *reference = NULL;
    struct app_compared *compared = calloc((size_t)count, sizeof *compared);
    if (!compared) return app_no_memory();
    satin_status status = SATIN_OK;
    for (int i = 0; i < count && status == SATIN_OK; i++) {
        if (i == 0) status = satin_film_read(other, app_log_file, NULL, &reference);
        if (status == SATIN_OK) status = compare_image(r, r->path[i], reference, &compared[i]);
    }
    if (status == SATIN_OK && r->json) print_json(compared, count);
    const bool words = status == SATIN_OK && !r->json && !r->page_alone;
    if (words && count == 1) print_words(compared);
    if (words && count > 1) print_table(compared, count);
    if (status == SATIN_OK && r->error_image)
        status = write_error_image(r->error_image, compared, file_log);
    if (status == SATIN_OK && r->html)
        status = app_compare_page(r->html, other, compared, count, file_log);
    int result = status == SATIN_ERROR_MEMORY ? app_no_memory() : (int)app_exit_of(status);
    if (result == APP_DONE) result = check_limit(r, compared, count);
    for (int i = 0; i < count; i++) compared_destroy(&compared[i]);
    free(compared);
    satin_film_free(reference);
    return result;
}

int app_compare(int argc, char **argv) {
    struct compare_request r = {.limit = INFINITY};
    r.path = calloc((size_t)argc + 1, sizeof *r.path);
    if (!r.path) return app_no_memory();
    int result = read_compare_arguments(argc, argv, &r);
    if (result == APP_DONE) result = r.help ? app_help(1, (char *[]){"compare"}) : compare(&r);
    free(r.path);
    return result;
}
