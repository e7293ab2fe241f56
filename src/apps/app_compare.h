// SPDX-License-Identifier: Apache-2.0
// The comparison of images with one reference, between the command and its page.
#ifndef APP_COMPARE_H
#define APP_COMPARE_H

#include <stdbool.h>

#include "film/film.h"

struct app_compared {
    const char *path;
    struct satin_film *image, *reference;  // selected parts (film_select); owned
    struct film_difference difference;
    unsigned char *kind;  // of each pixel (film_pixel_kinds); owned
    float *error;         // of each pixel (film_pixel_errors); owned
    float *flip;          // likewise, or NULL; owned
    double flip_mean;     // of the pixels that are compared
};

// Writes a page that shows the images, with no file beside it (app_compare_page.c).
satin_status app_compare_page(const char *path, const char *reference,
                              const struct app_compared *compared, int count, struct log log);

#endif
