// SPDX-License-Identifier: Apache-2.0
// Any bytes given as a scene file: a scene, or one logged error; no crash, no hang, bounded memory.
#include "fuzz_case.h"
#include "scene/scene.h"

// Uses of a loaded scene that its numbers must not break.
static void fuzz_scene_use(const satin_scene *scene) {
    const struct scene_film *film = &scene->film;
    float spread, right = (float)(film->crop_x + film->crop_width);
    struct scene_film_filter filter;
    scene_film_filter_make(film, &filter);
    float x = right - 0.5f +
              scene_film_filter_offset(&filter, right - 0.5f, (float)film->crop_x, right, 0).x;
    struct ray ray =
        scene_camera_ray(scene, &scene->camera, (vec2){x, 0.5f}, (vec2){0.3f, 0.7f}, &spread);
    struct interaction s;
    struct brdf brdf;
    struct frame frame;
    if (!(x >= (float)film->crop_x && x < right)) abort();
    if (scene_intersect(scene, &ray, &s)) scene_brdf(scene, &s, v3_neg(ray.d), &brdf, &frame);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char path[FUZZ_PATH];
    int file = fuzz_file(data, size, path), lines = 0;
    satin_scene *scene = NULL;
    satin_status status = satin_scene_load(path, NULL, 0, fuzz_count, &lines, &scene);
    if ((status == SATIN_OK) != (scene != NULL) || lines != (status != SATIN_OK)) abort();
    if (scene) fuzz_scene_use(scene);
    satin_scene_free(scene);
    close(file);
    return 0;
}
