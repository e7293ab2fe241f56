// SPDX-License-Identifier: Apache-2.0
// Loading a scene. A scene is immutable: all functions but satin_scene_free may be called for one
// scene from several threads, and several scenes may be loaded at once.
#ifndef SATIN_SCENE_H
#define SATIN_SCENE_H

#include "satin/types.h"

#ifdef __cplusplus
extern "C" {
#endif

// A `-D name=value` of the command line, which replaces the value of `<default name="...">`. Both
// texts are owned by the caller, end with 0, and must be valid until the call that takes them
// returns.
typedef struct satin_define {
    const char *name, *value;
} satin_define;

// Loads a Mitsuba 3 XML scene with all its meshes and textures, and builds its ray tracing
// structure. `defines` (count `define_count`, may be NULL) override the defaults in the file; a
// define that no `$name` of the file uses is an error. `log` (may be NULL) gets every message, with
// `log_user`, on the calling thread. The caller frees *scene with satin_scene_free; on failure
// *scene is unchanged. SATIN_ERROR_INPUT: the scene, a mesh or an image is invalid or cannot be
// read, logged once as `file:line:column: ...`; SATIN_ERROR_ARGUMENT: a pointer is NULL;
// SATIN_ERROR_MEMORY; SATIN_ERROR_INTERNAL: Embree failed. Lengths are in the scene's own unit
// throughout, radiance in W m^-2 sr^-1, angles in the file in degrees. Thread-safe: several threads
// may load at once, even the same file.
SATIN_API satin_status satin_scene_load(const char *path, const satin_define *defines,
                                        size_t define_count, satin_log_fn log, void *log_user,
                                        satin_scene **scene);

// Flags for loading a scene.
enum satin_scene_flags {
    SATIN_SCENE_STRICT = 1,  // warnings are errors, of which there may be several
    // Missing and damaged files, unknown plugins, names and ids give a warning each: their shapes
    // and lights are left out, their textures and BRDFs are grey, and their numbers the default. An
    // unknown BRDF that contains another one is replaced by it.
    SATIN_SCENE_LENIENT = 2,
    // The scene file may be a pipe or a device such as /dev/stdin, which is read to its end. The
    // names in a file of the folder /dev are relative to the current folder.
    SATIN_SCENE_STREAM = 4,
    // All sensors of the scene are read, for the views of an animation.
    SATIN_SCENE_ALL_SENSORS = 8
};

// satin_scene_load with `flags`, bits of satin_scene_flags; 0: none. Other bits are ignored.
// Thread-safe, as satin_scene_load.
SATIN_API satin_status satin_scene_load_with(const char *path, const satin_define *defines,
                                             size_t define_count, unsigned flags, satin_log_fn log,
                                             void *log_user, satin_scene **scene);

// Where an object or a light is in a frame of an animation, relative to where the scene file has
// it. It is scaled about the pivot, rotated by the right-hand rule about an axis through it, and
// translated. Positions are in world space and in the scene's unit.
typedef struct satin_pose {
    const char *id;            // of a <shape> that has a to_world, or of an <emitter>
    double pivot[3], axis[3];  // an axis of zeros: no rotation
    double angle;              // degrees
    double scale;              // 0: the object is left out
    double translate[3];
    double intensity;  // factor of the light that the emitter, or the emitter of the shape, emits
} satin_pose;

// What a scene is loaded with; all zero is what satin_scene_load does without defines. All texts
// are the caller's and must be valid until the call returns.
typedef struct satin_scene_request {
    const satin_define *defines;
    size_t define_count;
    unsigned flags;           // bits of satin_scene_flags
    const char *sensor;       // the id of the sensor, or its index from 0; NULL: the first sensor
    const satin_pose *poses;  // objects that are not where the file has them
    size_t pose_count;
    // The option `memory` of the renders [bytes]: images become coarser, the largest first, until
    // they take at most half of it beside the process, with a warning; 0: no limit.
    int64_t memory;
} satin_scene_request;

// satin_scene_load by a request, which must not be NULL. SATIN_ERROR_INPUT also if the scene has no
// such sensor, or no object of a pose. Thread-safe, as satin_scene_load.
SATIN_API satin_status satin_scene_load_request(const char *path,
                                                const satin_scene_request *request,
                                                satin_log_fn log, void *log_user,
                                                satin_scene **scene);

// Frees the scene; NULL is allowed. No other thread may use the scene during or after the call, and
// no render of it may be running. Films that were rendered from it stay valid.
SATIN_API void satin_scene_free(satin_scene *scene);

// A 64-bit hash of everything that was read: the same scene in the same files has the same hash.
// `scene` must not be NULL. Thread-safe.
SATIN_API uint64_t satin_scene_hash(const satin_scene *scene);

// The film size of the scene [pixels], or that of the crop window if it has one. No pointer may be
// NULL. Thread-safe.
SATIN_API void satin_scene_film_size(const satin_scene *scene, int *width, int *height);

// The number of the scene's sensors, in the order of the file; 0 if it was loaded without
// SATIN_SCENE_ALL_SENSORS. `scene` must not be NULL. Thread-safe.
SATIN_API int satin_scene_sensor_count(const satin_scene *scene);

#ifdef __cplusplus
}
#endif
#endif
