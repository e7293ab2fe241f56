// SPDX-License-Identifier: Apache-2.0
// The page of `satin compare --html`: the text of app_compare_page.html with the pictures and
// numbers of a comparison as JSON in it.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app_compare.h"
#include "base/fileio.h"
#include "base/text.h"

extern const char app_compare_page_text[];

#define DATA_MARK "@DATA@"

static void print_base64(FILE *out, const unsigned char *data, size_t size) {
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const unsigned word = (unsigned)data[i] << 16 |
                              (left > 1 ? (unsigned)data[i + 1] << 8 : 0) |
                              (left > 2 ? data[i + 2] : 0);
        fputc(digit[word >> 18], out);
        fputc(digit[word >> 12 & 63], out);
        fputc(left > 1 ? digit[word >> 6 & 63] : '=', out);
        fputc(left > 2 ? digit[word & 63] : '=', out);
    }
}

// Prints `, "name": "data:..."` with a picture, which is freed. NULL stands for lack of memory.
static satin_status print_picture(FILE *out, const char *name, int width, int height,
                                  unsigned char *pixel, struct log log) {
    void *data = NULL;
    size_t size = 0;
    if (!pixel) return SATIN_ERROR_MEMORY;
    satin_status status =
        film_encode_pixels(name, &(struct film_pixels){width, height, 3, pixel}, log, &data, &size);
    if (status == SATIN_OK) {
        fprintf(out, ", \"%s\": \"data:image/png;base64,", name);
        print_base64(out, data, size);
        fputc('"', out);
    }
    free(data);
    free(pixel);
    return status;
}

static void print_values(FILE *out, const struct app_compared *c) {
    const struct film_difference *d = &c->difference;
    fprintf(out, ", \"values\": {\"RMSE\": \"%.4g\", \"relMSE\": \"%.4g\", \"PSNR\": \"%.2f dB\"",
            d->rmse, d->relmse, d->psnr);
    fprintf(out, ", \"mean\": \"%+.3f %%\", \"discernible\": \"%.2f %%\"",
            100.0 * (d->mean_ratio - 1.0), 100.0 * d->discernible);
    if (c->flip) fprintf(out, ", \"FLIP\": \"%.4f\"", c->flip_mean);
    fputc('}', out);
}

static satin_status print_image(FILE *out, const struct app_compared *c, struct log log) {
    const int width = c->image->width, height = c->image->height;
    float top = 0.0f;
    satin_status status;
    fprintf(out, "{\"name\": ");
    text_print_json(out, c->path);
    print_values(out, c);
    unsigned char *pixel = film_picture(c->image, c->path, NULL, log, &status);
    status = print_picture(out, "picture", width, height, pixel, log);
    if (status != SATIN_OK) return status;
    pixel = film_picture(c->reference, c->path, NULL, log, &status);
    status = print_picture(out, "reference", width, height, pixel, log);
    if (status != SATIN_OK) return status;
    pixel = film_map_pixels(c->error, (size_t)width * (size_t)height, &top);
    status = print_picture(out, "error", width, height, pixel, log);
    fprintf(out, ", \"top\": \"%.3g\"}", (double)top);
    return status;
}

satin_status app_compare_page(const char *path, const char *reference,
                              const struct app_compared *compared, int count, struct log log) {
    char *text = NULL;
    size_t size = 0;
    const char *mark = strstr(app_compare_page_text, DATA_MARK);
    FILE *out = open_memstream(&text, &size);
    satin_status status = out ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (out) {
        fwrite(app_compare_page_text, 1, (size_t)(mark - app_compare_page_text), out);
        fprintf(out, "{\"reference\": ");
        text_print_json(out, reference);
        fprintf(out, ", \"images\": [");
        for (int i = 0; i < count && status == SATIN_OK; i++) {
            if (i) fprintf(out, ", ");
            status = print_image(out, &compared[i], log);
        }
        fprintf(out, "]}%s", mark + strlen(DATA_MARK));
        if (fclose(out) != 0) status = SATIN_ERROR_MEMORY;
    }
    if (status == SATIN_OK)
        status = fileio_write(log, path, text, size);
    else if (status == SATIN_ERROR_MEMORY)
        log_fail(log, status, "%s: not enough memory", path);
    free(text);
    return status;
}
