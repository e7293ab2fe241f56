// SPDX-License-Identifier: Apache-2.0
// satin maps: pictures of the cache records of an image, made from the channels that the option
// record-maps adds to it.
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "apps/app.h"
#include "film/film.h"

enum { MAPS_FLAG_OUTPUT, MAPS_FLAG_HELP };

const struct app_flag app_maps_flags[] = {
    {"--output", "-o", "DIR", "The folder of the pictures; made if it is not there."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

static const char record_position[] = "records.position";

static const struct map {
    const char *channel, *file, *meaning;
} maps[] = {
    {record_position, "records.png", "where records are"},
    {"density.Y", "density.png", "records interpolated per sample"},
    {"records.weight", "weight.png", "sum of their weights"},
    {"records.a", "a.png", "their accuracy a"},
    {"records.rays", "rays.png", "gather rays of a record"},
    {"samples.Y", "samples.png", "samples of a pixel"},
};
enum { MAPS = sizeof maps / sizeof *maps };

static satin_status write_map(const satin_film *film, const struct map *map, const char *path,
                              struct log log) {
    const float *value = satin_film_channel(film, map->channel);
    if (!value) return SATIN_OK;
    float top = 0.0f;
    const bool dots = map->channel == record_position;
    satin_status status = dots ? film_write_dots(film, value, path, log)
                               : film_write_map(film, value, path, log, &top);
    if (status != SATIN_OK) return status;
    printf("%-12s %s", map->file, map->meaning);
    if (!dots) printf(", 0 to %.4g", (double)top);
    printf("\n");
    return SATIN_OK;
}

// The path DIR/FILE of a picture, from malloc.
static char *map_path(const char *folder, const struct map *map) {
    const size_t n = strlen(folder) + strlen(map->file) + 2;
    char *path = malloc(n);
    if (path) snprintf(path, n, "%s/%s", folder, map->file);
    return path;
}

// Writes the pictures, after checking that none of them is the image itself and that all can be
// written.
static int write_paths(const satin_film *film, const char *image, char *const path[MAPS]) {
    const struct app_input input[] = {{image, "the image"}, {NULL, NULL}};
    struct app_output output[MAPS];
    for (int i = 0; i < MAPS; i++) {
        const bool there = satin_film_channel(film, maps[i].channel);
        output[i] = (struct app_output){there ? path[i] : NULL, FILEIO_APPEND, NULL};
    }
    const int result = app_outputs_check(output, MAPS, input);
    if (result != APP_DONE) return result;
    satin_status status = SATIN_OK;
    for (int i = 0; i < MAPS && status == SATIN_OK; i++)
        status = write_map(film, &maps[i], path[i], (struct log){app_log_file, NULL});
    return app_exit_of(status);
}

static int write_maps(const satin_film *film, const char *image, const char *folder) {
    const struct log log = {app_log_file, NULL};
    if (!satin_film_channel(film, record_position))
        return app_exit_of(log_fail(
            log, SATIN_ERROR_INPUT,
            "%s: it has no channels of records; render it with --set record-maps=on", image));
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return app_exit_of(log_fail(log, SATIN_ERROR_INPUT, "%s: cannot make the folder: %s",
                                    folder, strerror(errno)));
    char *path[MAPS];
    bool memory = true;
    for (int i = 0; i < MAPS; i++) {
        path[i] = map_path(folder, &maps[i]);
        memory = memory && path[i];
    }
    const int result = memory ? write_paths(film, image, path) : app_no_memory();
    for (int i = 0; i < MAPS; i++) free(path[i]);
    return result;
}

int app_maps(int argc, char **argv) {
    struct app_args args = {.argc = argc, .argv = argv};
    const char *image = NULL, *folder = NULL;
    char *value;
    int flag;
    while ((flag = app_args_next(&args, app_maps_flags, NULL, &value)) != APP_END) {
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == MAPS_FLAG_HELP) return app_help(1, (char *[]){"maps"});
        if (flag == MAPS_FLAG_OUTPUT) folder = value;
        if (flag == APP_POSITIONAL && image) return app_wrong("maps takes one image");
        if (flag == APP_POSITIONAL) image = value;
    }
    if (!image || !folder || !*folder)
        return app_wrong("maps takes an image and a folder: satin maps IMAGE.exr -o DIR");
    satin_film *film = NULL;
    satin_status status = satin_film_read(image, app_log_file, NULL, &film);
    if (status != SATIN_OK) return app_exit_of(status);
    const int result = write_maps(film, image, folder);
    satin_film_free(film);
    return result;
}
