// SPDX-License-Identifier: Apache-2.0
// satin info: describes a file of cache records.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "base/array.h"
#include "base/fileio.h"
#include "cache/cache.h"

static void print_quantiles(const char *name, float *value, size_t count, double scale) {
    static const int percent[] = {0, 10, 50, 90, 100};
    qsort(value, count, sizeof *value, array_compare_floats);
    printf("  %-10s", name);
    for (size_t i = 0; i < sizeof percent / sizeof *percent; i++)
        printf(" %12.5g", scale * (double)value[(count - 1) * (size_t)percent[i] / 100]);
    printf("\n");
}

// The number after ` NAME=` in the text of options in the file; NAN if there is none.
static double option_number(const char *options, const char *key) {
    const char *at = strstr(options, key);
    return at ? strtod(at + strlen(key), NULL) : NAN;
}

static satin_status print_kind(const struct cache_file *file, enum cache_kind kind, size_t count,
                               double a) {
    float *R = array_new(count, sizeof *R), *scale = array_new(count, sizeof *scale);
    if (R && scale && count) {
        for (size_t i = 0; i < count; i++) cache_file_record(file, kind, i, &R[i], &scale[i]);
        printf("  %-10s %12s %12s %12s %12s %12s\n", "", "least", "10 %", "median", "90 %", "most");
        print_quantiles("radius R", R, count, 1.0);
        print_quantiles("accuracy a", scale, count, a);
    }
    const bool ok = R && scale;
    free(R);
    free(scale);
    if (ok) return SATIN_OK;
    return log_fail((struct log){app_log, NULL}, SATIN_ERROR_MEMORY, "not enough memory");
}

static satin_status print_file(const struct cache_file *file) {
    const struct cache_summary s = cache_file_summary(file);
    const char *options = s.provenance.options;
    const bool sh = strstr(options, " radiance-basis=sh") != NULL;
    printf("rays       %" PRIu64 "\n", s.rays);
    printf("image      %s\n", s.provenance.image ? "complete" : "made with a time limit");
    printf("irradiance %zu records\n", s.irradiance);
    satin_status status =
        print_kind(file, CACHE_IRRADIANCE, s.irradiance, option_number(options, " irradiance-a="));
    printf("radiance   %zu records", s.radiance);
    if (s.order) printf(", order %d, %s", s.order, sh ? "sh" : "hsh");
    printf("\n");
    if (status == SATIN_OK)
        status =
            print_kind(file, CACHE_RADIANCE, s.radiance, option_number(options, " radiance-a="));
    if (status != SATIN_OK) return status;
    app_print_wrapped(printf("options"), 11, options);
    return SATIN_OK;
}

satin_status app_info_cache(const char *path) {
    const struct log log = {app_log_file, NULL};
    char *data = NULL;
    size_t size = 0;
    struct cache_file *file = NULL;
    satin_status status = fileio_read(log, (struct log_place){0}, path, (size_t)-1, &data, &size);
    if (status == SATIN_OK) status = cache_file_parse(data, size, path, log, &file);
    if (status == SATIN_OK) {
        printf("cache      %s, %zu bytes, scene %016" PRIx64 "\n", path, size,
               cache_file_summary(file).provenance.world);
        status = print_file(file);
    }
    cache_file_free(file);
    free(data);
    return status;
}
