// SPDX-License-Identifier: Apache-2.0
// satin compare: the difference between an image and a reference, in words or as JSON.
#include <inttypes.h>
#include <math.h>

#include "apps/app.h"
#include "film/film.h"

enum { COMPARE_FLAG_JSON, COMPARE_FLAG_MASK, COMPARE_FLAG_HELP };

const struct app_flag app_compare_flags[] = {
    {"--json", NULL, NULL, "Prints one JSON object."},
    {"--mask-emission", NULL, NULL,
     "Leaves out pixels that see an emitter (layer emission of either image)."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

// JSON has no infinity and no NaN.
static void print_json_number(const char *name, double value) {
    if (isfinite(value))
        printf("  \"%s\": %.9g,\n", name, value);
    else
        printf("  \"%s\": null,\n", name);
}

static void print_json(const struct film_difference *d) {
    printf("{\n");
    print_json_number("rmse", d->rmse);
    print_json_number("relmse", d->relmse);
    print_json_number("psnr_db", d->psnr);
    print_json_number("mean_ratio", d->mean_ratio);
    print_json_number("discernible", d->discernible);
    printf("  \"variance_subtracted\": %s,\n", d->variance ? "true" : "false");
    printf("  \"pixels\": %" PRIu64 ",\n  \"masked\": %" PRIu64 ",\n  \"nonfinite\": %" PRIu64
           "\n}\n",
           d->compared, d->masked, d->nonfinite);
}

static void print_words(const struct film_difference *d) {
    const char *noise = d->variance ? ", the reference's noise subtracted" : "";
    printf("RMSE         %.6g%s\n", d->rmse, noise);
    printf("relMSE       %.6g%s\n", d->relmse, noise);
    printf("PSNR         %.2f dB\n", d->psnr);
    printf("mean         %+.3f %%\n", 100.0 * (d->mean_ratio - 1.0));
    printf("discernible  %.2f %% of pixels\n", 100.0 * d->discernible);
    printf("pixels       %" PRIu64 ", masked %" PRIu64 ", not finite %" PRIu64 "\n", d->compared,
           d->masked, d->nonfinite);
}

static satin_status compare(const char *const path[2], bool mask, bool json) {
    satin_film *film[2] = {NULL, NULL};
    struct film_difference difference;
    satin_status status = satin_film_read(path[0], app_log_file, NULL, &film[0]);
    if (status == SATIN_OK) status = satin_film_read(path[1], app_log_file, NULL, &film[1]);
    if (status == SATIN_OK)
        status = film_compare(film[0], film[1], mask, (struct log){app_log, NULL}, &difference);
    if (status == SATIN_OK && json) print_json(&difference);
    if (status == SATIN_OK && !json) print_words(&difference);
    satin_film_free(film[0]);
    satin_film_free(film[1]);
    return status;
}

int app_compare(int argc, char **argv) {
    struct app_args args = {.argc = argc, .argv = argv};
    const char *path[2] = {NULL, NULL};
    char *value;
    bool json = false, mask = false;
    int count = 0, flag;
    while ((flag = app_args_next(&args, app_compare_flags, NULL, &value)) != APP_END) {
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == COMPARE_FLAG_HELP) return app_help(1, (char *[]){"compare"});
        if (flag == COMPARE_FLAG_JSON) json = true;
        if (flag == COMPARE_FLAG_MASK) mask = true;
        if (flag == APP_POSITIONAL && count < 2) path[count] = value;
        count += flag == APP_POSITIONAL;
    }
    if (count != 2) return app_wrong("compare takes two images: satin compare IMAGE REFERENCE");
    return app_exit_of(compare(path, mask, json));
}
