// SPDX-License-Identifier: Apache-2.0
// Loading a scene. A scene does not change once it is loaded: all functions but satin_scene_free
// may be called for one scene from several threads, and several scenes may be loaded at once.
#ifndef SATIN_SCENE_H
#define SATIN_SCENE_H

#include "satin/types.h"

#ifdef __cplusplus
extern "C" {
#endif

// One `-D name=value` of the command line: replaces the value of `<default name="...">`.
typedef struct satin_define {
    const char *name, *value;
} satin_define;

// Loads a Mitsuba 3 XML scene with all its meshes and textures and builds its ray tracing
// structure. `defines` (count `define_count`, may be NULL) override the file's defaults; a define
// that no `$name` of the file uses is an error. Every error is logged once as `file:line:column:
// ...` and gives SATIN_ERROR_INPUT. The caller frees *scene with satin_scene_free.
SATIN_API satin_status satin_scene_load(const char *path, const satin_define *defines,
                                        size_t define_count, satin_log_fn log, void *log_user,
                                        satin_scene **scene);

// How a scene is read: bits.
enum satin_scene_flags {
    SATIN_SCENE_STRICT = 1,  // every warning is an error, of which there may then be several
    // What is missing or unknown gets a warning each: shapes and lights of an unknown type or
    // without their file are left out, textures and BRDFs are grey, an unknown BRDF around one
    // other is that.
    SATIN_SCENE_LENIENT = 2
};

// satin_scene_load with `flags`, bits of satin_scene_flags; 0: none.
SATIN_API satin_status satin_scene_load_with(const char *path, const satin_define *defines,
                                             size_t define_count, unsigned flags, satin_log_fn log,
                                             void *log_user, satin_scene **scene);

SATIN_API void satin_scene_free(satin_scene *scene);  // NULL is allowed

// A hash of everything that was read: the same scene in the same files gives the same value.
SATIN_API uint64_t satin_scene_hash(const satin_scene *scene);

// The film size that the scene asks for, in pixels (of the crop window, if it has one).
SATIN_API void satin_scene_film_size(const satin_scene *scene, int *width, int *height);

#ifdef __cplusplus
}
#endif
#endif
