// SPDX-License-Identifier: Apache-2.0
// Loading a scene. A scene does not change once it is loaded: all functions but satin_scene_free
// may be called for one scene from several threads, and several scenes may be loaded at once.
#ifndef SATIN_SCENE_H
#define SATIN_SCENE_H

#include "satin/types.h"

#ifdef __cplusplus
extern "C" {
#endif

// One `-D name=value` of the command line: replaces the value of `<default name="...">`. Both texts
// are the caller's, ended by 0, and needed until the call that takes them returns.
typedef struct satin_define {
    const char *name, *value;
} satin_define;

// Loads a Mitsuba 3 XML scene with all its meshes and textures and builds its ray tracing
// structure. `defines` (count `define_count`, may be NULL) override the file's defaults; a define
// that no `$name` of the file uses is an error. `log` (may be NULL) gets every message with
// `log_user` on the calling thread. The caller frees *scene with satin_scene_free; on failure
// *scene is untouched. SATIN_ERROR_INPUT: the scene, a mesh or an image is wrong or cannot be read,
// logged once as `file:line:column: ...`; SATIN_ERROR_ARGUMENT: a pointer is NULL;
// SATIN_ERROR_MEMORY; SATIN_ERROR_INTERNAL: Embree failed. Lengths are in the scene's own unit
// throughout, radiance in W m^-2 sr^-1, angles of the file in degrees. Thread-safe: several threads
// may load at once, also the same file.
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

// satin_scene_load with `flags`, bits of satin_scene_flags; 0: none. Other bits are ignored.
// Thread-safe, as satin_scene_load is.
SATIN_API satin_status satin_scene_load_with(const char *path, const satin_define *defines,
                                             size_t define_count, unsigned flags, satin_log_fn log,
                                             void *log_user, satin_scene **scene);

// Frees the scene; NULL is allowed. No other thread may use the scene then, nor a render of it run.
// Films that were rendered from it stay valid.
SATIN_API void satin_scene_free(satin_scene *scene);

// A 64-bit hash of everything that was read: the same scene in the same files gives the same value.
// `scene` must not be NULL. Thread-safe.
SATIN_API uint64_t satin_scene_hash(const satin_scene *scene);

// The film size that the scene asks for [pixels], of the crop window if it has one.
// No pointer may be NULL. Thread-safe.
SATIN_API void satin_scene_film_size(const satin_scene *scene, int *width, int *height);

#ifdef __cplusplus
}
#endif
#endif
