// SPDX-License-Identifier: Apache-2.0
// The public functions of a loaded scene.
#include "scene/scene.h"

#include <stdlib.h>

void satin_scene_free(satin_scene *scene) {
    if (!scene) return;
    scene_trace_free(scene->trace);
    arena_free(&scene->arena);
    fileio_files_free(&scene->read);
    free(scene);
}

int satin_scene_sensor_count(const satin_scene *scene) { return (int)scene->sensor_count; }

uint64_t satin_scene_hash(const satin_scene *scene) { return scene->hash; }

void satin_scene_film_size(const satin_scene *scene, int *width, int *height) {
    *width = scene->film.crop_width;
    *height = scene->film.crop_height;
}
