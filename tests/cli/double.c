// SPDX-License-Identifier: Apache-2.0
// Stands in for the loader and the renderer in tests of the command: a file that begins
// with `<scene` is a scene, any other is refused; rendering counts up and fills a grey film.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "film/film.h"
#include "satin/render.h"
#include "scene/scene.h"

satin_status satin_scene_load(const char *path, const satin_define *defines, size_t define_count,
                              satin_log_fn log_fn, void *log_user, satin_scene **scene) {
    struct log log = {log_fn, log_user};
    char line[8] = "";
    FILE *file = fopen(path, "r");
    (void)defines;
    (void)define_count;
    if (!file) return log_fail(log, SATIN_ERROR_INPUT, "%s: cannot read", path);
    bool ok = fgets(line, sizeof line, file) && strncmp(line, "<scene", 6) == 0;
    fclose(file);
    if (!ok) {
        log_error_at(log, (struct log_place){path, 1, 1}, "it is not a scene");
        return SATIN_ERROR_INPUT;
    }
    *scene = calloc(1, sizeof **scene);
    return *scene ? SATIN_OK : SATIN_ERROR_MEMORY;
}

void satin_scene_free(satin_scene *scene) { free(scene); }
uint64_t satin_scene_hash(const satin_scene *scene) { return scene->hash; }

satin_status satin_render(const satin_scene *scene, const satin_options *options,
                          const satin_callbacks *callbacks, satin_film **film) {
    static const char *const stages[] = {"photons", "rough solution", "records", "image"};
    static const char *const names[] = {"R", "G", "B"};
    bool cancelled = false;
    (void)scene;
    for (int s = 0; s < 4 && !cancelled; s++)
        for (int i = 0; i <= 10 && !cancelled; i++) {
            satin_progress p = {stages[s], "rays", i / 10.0, 1.5e6, 0.0};
            cancelled = callbacks->progress && callbacks->progress(callbacks->progress_user, &p);
            nanosleep(&(struct timespec){0, (long)(options->time * 1e7)}, NULL);
        }
    *film = film_new(options->width ? options->width : 8, options->height ? options->height : 6,
                     names, 3);
    if (!*film) return SATIN_ERROR_MEMORY;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < (*film)->width * (*film)->height; i++) (*film)->channel[c][i] = 0.5f;
    (*film)->stats = strdup("{\n  \"photons.stored\": 12\n}\n");
    return cancelled ? SATIN_CANCELLED : SATIN_OK;
}
