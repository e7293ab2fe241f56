// SPDX-License-Identifier: Apache-2.0
// What the programs of this folder have in common: messages, and the mean of an image.
#ifndef STAT_CASE_H
#define STAT_CASE_H

#include <math.h>
#include <stdio.h>

#include "satin/render.h"

static inline void stat_say(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    (void)severity;
    fprintf(stderr, "%s\n", message);
}

// The mean of green over the scene's image with `count` settings; NAN if it fails, which is
// reported.
static inline double stat_mean(const satin_scene *scene, const satin_setting *setting,
                               size_t count) {
    satin_options options;
    satin_callbacks callbacks = {.log = stat_say};
    satin_film *film = NULL;
    if (satin_options_resolve(scene, setting, count, stat_say, NULL, &options) ||
        satin_render(scene, &options, &callbacks, &film) != SATIN_OK)
        return NAN;
    int width, height;
    double sum = 0.0;
    satin_film_size(film, &width, &height);
    const float *green = satin_film_channel(film, "G");
    for (int i = 0; i < width * height; i++) sum += (double)green[i];
    satin_film_free(film);
    return sum / (width * height);
}

#endif
