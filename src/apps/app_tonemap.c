// SPDX-License-Identifier: Apache-2.0
// satin tonemap: a picture of an image or of one of its layers. Also reads the arguments that
// choose exposure and tone mapping, which `satin render` has too.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "base/log.h"
#include "satin/film.h"

enum {
    TONEMAP_FLAG_OUTPUT,
    TONEMAP_FLAG_EXPOSURE,
    TONEMAP_FLAG_TONEMAP,
    TONEMAP_FLAG_LAYER,
    TONEMAP_FLAG_HELP
};

const struct app_flag app_tonemap_flags[] = {
    {"--output", "-o", "OUT.png", "The picture."},
    {"--exposure", NULL, "STOPS|auto", APP_EXPOSURE_DOC},
    {"--tonemap", NULL, "clip|filmic|agx", APP_TONEMAP_DOC},
    {"--layer", NULL, "NAME", "Shows this layer, for example direct, instead of the beauty."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

int app_take_exposure(const char *value, satin_tonemap *tonemap) {
    const bool automatic = strcmp(value, "auto") == 0 || strncmp(value, "auto+", 5) == 0 ||
                           strncmp(value, "auto-", 5) == 0;
    const char *number = value + (automatic ? 4 : 0);
    char *end = NULL;
    const double stops = *number ? strtod(number, &end) : 0.0;
    const bool whole = *number ? end != number && *end == '\0' : automatic;
    // Beyond this many stops no float remains.
    if (!whole || !(fabs(stops) <= 100.0))
        return app_wrong("--exposure needs a number of stops, or auto, not '%s'", value);
    tonemap->auto_exposure = automatic;
    tonemap->exposure = (float)stops;
    return APP_DONE;
}

int app_take_tonemap(const char *value, satin_tonemap *tonemap) {
    static const char *const name[] = {
        [SATIN_TONE_CLIP] = "clip", [SATIN_TONE_FILMIC] = "filmic", [SATIN_TONE_AGX] = "agx"};
    for (size_t i = 0; i < sizeof name / sizeof *name; i++) {
        if (strcmp(value, name[i]) != 0) continue;
        tonemap->tone = (satin_tone)i;
        return APP_DONE;
    }
    return app_wrong("--tonemap needs clip, filmic or agx, not '%s'", value);
}

// Whether the image has the channels of the layer that is to be shown, which else is reported.
static bool has_layer(const satin_film *film, const char *image, const char *layer) {
    const struct log log = {app_log_file, NULL};
    char name[256];
    bool all = true;
    for (int i = 0; layer && i < 3; i++) {
        snprintf(name, sizeof name, "%s.%c", layer, "RGB"[i]);
        all = all && satin_film_channel(film, name);
    }
    if (!all)
        log_fail(log, SATIN_ERROR_INPUT,
                 "%s: it has no channels %s.R, G and B; a layer that is shown has colours", image,
                 layer);
    return all;
}

static int write_picture(const char *image, const char *path, const satin_tonemap *tonemap) {
    const struct app_input input[] = {{image, "the image"}, {NULL, NULL}};
    const struct app_output output = {path, FILEIO_APPEND, NULL};
    satin_film *film = NULL;
    satin_status status = satin_film_read(image, app_log_file, NULL, &film);
    if (status != SATIN_OK) return app_exit_of(status);
    int result = app_outputs_check(&output, 1, input);
    if (result == APP_DONE && !has_layer(film, image, tonemap->layer)) result = APP_WRONG;
    if (result == APP_DONE)
        result = app_exit_of(satin_film_write_png(film, path, tonemap, app_log_file, NULL));
    satin_film_free(film);
    return result;
}

int app_tonemap(int argc, char **argv) {
    struct app_args args = {.argc = argc, .argv = argv};
    satin_tonemap tonemap = {0};
    const char *image = NULL, *path = NULL;
    char *value;
    int flag;
    while ((flag = app_args_next(&args, app_tonemap_flags, NULL, &value)) != APP_END) {
        int result = APP_DONE;
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == TONEMAP_FLAG_HELP) return app_help(1, (char *[]){"tonemap"});
        if (flag == TONEMAP_FLAG_OUTPUT) path = value;
        if (flag == TONEMAP_FLAG_LAYER) tonemap.layer = value;
        if (flag == TONEMAP_FLAG_EXPOSURE) result = app_take_exposure(value, &tonemap);
        if (flag == TONEMAP_FLAG_TONEMAP) result = app_take_tonemap(value, &tonemap);
        if (flag == APP_POSITIONAL && image) return app_wrong("tonemap takes one image");
        if (flag == APP_POSITIONAL) image = value;
        if (result != APP_DONE) return result;
    }
    if (!image || !path || !*path)
        return app_wrong("tonemap takes an image and a name: satin tonemap IMAGE.exr -o OUT.png");
    if (!app_ends_in(path, ".png")) return app_wrong("%s: a picture is written as .png", path);
    return write_picture(image, path, &tonemap);
}
