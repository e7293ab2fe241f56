// SPDX-License-Identifier: Apache-2.0
// satin tonemap: a picture of an image or of one of its layers. Also reads the arguments that
// choose exposure and tone mapping, which `satin render` has too.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "base/log.h"
#include "film/film.h"

enum {
    TONEMAP_FLAG_OUTPUT,
    TONEMAP_FLAG_EXPOSURE,
    TONEMAP_FLAG_TONEMAP,
    TONEMAP_FLAG_LAYER,
    TONEMAP_FLAG_HELP
};

static const struct log TONEMAP_LOG = {app_log_file, NULL};

const struct app_flag app_tonemap_flags[] = {
    {"--output", "-o", "OUT.png", "The picture."},
    {"--exposure", NULL, "STOPS|auto", APP_EXPOSURE_DOC},
    {"--tonemap", NULL, "clip|filmic|agx", APP_TONEMAP_DOC},
    {"--layer", NULL, "NAME", "Shows this layer, for example direct, instead of the beauty."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

// Beyond this many stops no float remains.
static const double STOPS_MOST = 100.0;

int app_take_exposure(const char *value, satin_tonemap *tonemap) {
    const bool automatic = strcmp(value, "auto") == 0 || strncmp(value, "auto+", 5) == 0 ||
                           strncmp(value, "auto-", 5) == 0;
    const char *number = value + (automatic ? 4 : 0);
    char *end = NULL;
    const double stops = *number ? strtod(number, &end) : 0.0;
    const bool whole = *number ? end != number && *end == '\0' : automatic;
    if (!whole || !(fabs(stops) <= STOPS_MOST))
        return app_wrong(
            "--exposure needs a number of stops from %.0f to %.0f, auto, or auto+STOPS, not '%s'",
            -STOPS_MOST, STOPS_MOST, value);
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

// Finds the channels that are to be shown: those of the layer, or of the beauty. Reports that they
// are not there.
static bool find_shown(const satin_film *film, const char *image, const char *layer,
                       const float *shown[3]) {
    const char *dot = layer ? "." : "", *of = layer ? layer : "";
    bool all = true;
    for (int i = 0; i < 3; i++) {
        char name[256];
        snprintf(name, sizeof name, "%s%s%c", of, dot, "RGB"[i]);
        shown[i] = satin_film_channel(film, name);
        all = all && shown[i];
    }
    if (!all)
        log_fail(TONEMAP_LOG, SATIN_ERROR_INPUT, "%s: it has no channels %s%sR, G and B%s", image,
                 of, dot, layer ? "; a layer that is shown has colours" : "");
    return all;
}

// Warns of values that have no tone.
static void warn_of_nonfinite(const satin_film *film, const char *image,
                              const float *const shown[3]) {
    size_t count = 0;
    for (size_t i = 0; i < (size_t)film->width * (size_t)film->height; i++)
        count += !isfinite(shown[0][i]) || !isfinite(shown[1][i]) || !isfinite(shown[2][i]);
    if (count)
        log_message(TONEMAP_LOG, SATIN_LOG_WARNING,
                    "%s: %zu pixel%s not finite; what is no number is shown black", image, count,
                    count == 1 ? " is" : "s are");
}

// Prepares the light of an image for a picture, which is in the primaries of sRGB.
static bool prepare_light(satin_film *film, const char *image, const char *layer) {
    const float *shown[3];
    if (!find_shown(film, image, layer, shown)) return false;
    warn_of_nonfinite(film, image, shown);
    if (!film_convert_primaries(film, layer))
        log_message(TONEMAP_LOG, SATIN_LOG_WARNING,
                    "%s: its chromaticities are not those of colours; those of sRGB are taken",
                    image);
    return true;
}

static int write_picture(const char *image, const char *path, const satin_tonemap *tonemap) {
    const struct app_input input[] = {{image, "the image"}, {NULL, NULL}};
    const struct app_output output = {path, FILEIO_APPEND, NULL};
    satin_film *film = NULL;
    satin_status status = satin_film_read(image, app_log_file, NULL, &film);
    if (status != SATIN_OK) return app_exit_of(status);
    int result = app_outputs_check(&output, 1, input);
    if (result == APP_DONE && !prepare_light(film, image, tonemap->layer)) result = APP_WRONG;
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
