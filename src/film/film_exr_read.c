// SPDX-License-Identifier: Apache-2.0
// Reads OpenEXR to films (base/exrfile.h), and their string attributes as text.
#include <stdlib.h>
#include <string.h>

#include "base/exrfile.h"
#include "base/fileio.h"
#include "film/film.h"

static const size_t FILE_MAX = (size_t)4 << 30;
enum {
    EXR_ATTRIBUTES_MAX = 256,  // further ones are ignored
    OFFSET_MAX = 1 << 28       // of a window; farther ones are left out
};

static satin_status make_film(struct exrfile *file, struct satin_film **film) {
    const int count = file->channels->num_channels;
    const char **names = malloc((size_t)count * sizeof *names);
    if (names) {
        for (int i = 0; i < count; i++) names[i] = file->channels->entries[i].name.str;
        *film = film_new(file->width, file->height, names, count);
        free(names);
    }
    return *film ? SATIN_OK : exrfile_no_memory(file);
}

// Sets where the film lies in the display window, unless that window is empty or far off.
static void set_film_window(const struct exrfile *file, struct satin_film *film) {
    exr_attr_box2i_t whole;
    if (exr_get_display_window(file->exr, 0, &whole) != EXR_ERR_SUCCESS) return;
    const int64_t x = (int64_t)file->window.min.x - whole.min.x;
    const int64_t y = (int64_t)file->window.min.y - whole.min.y;
    const int64_t width = (int64_t)whole.max.x - whole.min.x + 1;
    const int64_t height = (int64_t)whole.max.y - whole.min.y + 1;
    if (x < -OFFSET_MAX || x > OFFSET_MAX || y < -OFFSET_MAX || y > OFFSET_MAX || width < 1 ||
        width > OFFSET_MAX || height < 1 || height > OFFSET_MAX || file->height > OFFSET_MAX)
        return;
    film->x = (int)x;
    film->y = (int)y;
    film->full_width = (int)width;
    film->full_height = (int)height;
}

// Reads the primaries and the matrices of the camera, if the file has them.
static void read_standard_attributes(const struct exrfile *file, struct satin_film *film) {
    struct film_camera *camera = &film->camera;
    exr_attr_chromaticities_t c;
    exr_attr_m44f_t to_camera, to_ndc;
    if (exr_attr_get_chromaticities(file->exr, 0, "chromaticities", &c) == EXR_ERR_SUCCESS) {
        const float xy[8] = {c.red_x,  c.red_y,  c.green_x, c.green_y,
                             c.blue_x, c.blue_y, c.white_x, c.white_y};
        memcpy(film->chromaticities, xy, sizeof xy);
    }
    if (exr_attr_get_m44f(file->exr, 0, "worldToCamera", &to_camera) != EXR_ERR_SUCCESS ||
        exr_attr_get_m44f(file->exr, 0, "worldToNDC", &to_ndc) != EXR_ERR_SUCCESS)
        return;
    camera->known = true;
    memcpy(camera->to_camera, to_camera.m, sizeof camera->to_camera);
    memcpy(camera->to_ndc, to_ndc.m, sizeof camera->to_ndc);
}

// Whether an attribute describes the structure of the file and not the image.
static bool is_structure(const char *name) {
    return strcmp(name, "type") == 0 || strcmp(name, "name") == 0;
}

static satin_status read_attributes(struct exrfile *file, struct satin_film *film) {
    int32_t count = 0;
    bool memory = true;
    exr_get_attribute_count(file->exr, 0, &count);
    for (int32_t i = 0; memory && i < count && film->attribute_count < EXR_ATTRIBUTES_MAX; i++) {
        const exr_attribute_t *a = NULL;
        if (exr_get_attribute_by_index(file->exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &a) !=
                EXR_ERR_SUCCESS ||
            a->type != EXR_ATTR_STRING || !a->string->str || is_structure(a->name))
            continue;
        if (strcmp(a->name, FILM_STATS_ATTRIBUTE) == 0 && !film->stats)
            memory = (film->stats = strdup(a->string->str)) != NULL;
        else
            memory = film_attribute_set(film, a->name, a->string->str);
    }
    return memory ? SATIN_OK : exrfile_no_memory(file);
}

static satin_status read_planes(struct exrfile *file, struct satin_film *film) {
    const int count = file->channels->num_channels;
    struct exrfile_channel *to = malloc((size_t)count * sizeof *to);
    if (!to) return exrfile_no_memory(file);
    for (int c = 0; c < count; c++)
        to[c] = (struct exrfile_channel){film->channel[c], 1, (size_t)film->width};
    const satin_status status = exrfile_read(file, to);
    free(to);
    return status;
}

satin_status film_parse_exr(const void *data, size_t size, const char *name, struct log log,
                            struct satin_film **film) {
    struct exrfile file;
    struct satin_film *made = NULL;
    satin_status status = exrfile_open(&file, name, data, size);
    if (status == SATIN_OK) status = make_film(&file, &made);
    if (status == SATIN_OK) {
        set_film_window(&file, made);
        read_standard_attributes(&file, made);
        status = read_attributes(&file, made);
    }
    if (status == SATIN_OK) status = read_planes(&file, made);
    if (status == SATIN_OK)
        *film = made;
    else
        log_fail(log, status, "%s: %s", name, file.problem);
    exrfile_close(&file);
    if (status != SATIN_OK) satin_film_free(made);
    return status;
}

satin_status satin_film_read(const char *path, satin_log_fn log_fn, void *log_user,
                             satin_film **film) {
    struct log log = {log_fn, log_user};
    char *data = NULL;
    size_t size = 0;
    satin_status status = fileio_read(log, (struct log_place){0}, path, FILE_MAX, &data, &size);
    if (status != SATIN_OK) return status;
    status = film_parse_exr(data, size, path, log, film);
    free(data);
    return status;
}
