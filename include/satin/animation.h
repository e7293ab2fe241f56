// SPDX-License-Identifier: Apache-2.0
// Animations: many images of one scene, of different views, which are made with the same photons
// and cache records. The records of all views are made first. Then the images are sampled, one
// after the other, and none of them changes what another one reads: the image of a frame depends on
// all views, but not on which frames are rendered, nor on their order.
#ifndef SATIN_ANIMATION_H
#define SATIN_ANIMATION_H

#include <stdbool.h>
#include <stdint.h>

#include "satin/film.h"
#include "satin/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// The view of a frame. Positions are in the scene's unit; `up` is any direction that is not
// along the view. All else is that of the scene's sensor, which must be a perspective one.
typedef struct satin_view {
    double origin[3], target[3], up[3];
    double fov;  // angle of view along the film's width, in [1e-5, 180) degrees; 0: the sensor's
} satin_view;

// Takes the image of frame `number` [the number that the caller gave it]. The film is owned by the
// render and valid during the call; it is the whole image, never one that was cancelled. Called on
// the thread that called satin_render, in the order of the frames. A status other than SATIN_OK
// ends the render, which returns it and logs nothing.
typedef satin_status (*satin_frame_fn)(void *user, int number, const satin_film *film);

// Sets *complete to whether the caller has the image of frame `number` already, made by the very
// render that `job` stands for: by the same version, scene, options and views. A film has the job
// of its render in the attribute `satin:job`. Asked for all frames before anything is rendered, on
// the thread that called satin_render. A status other than SATIN_OK ends the render.
typedef satin_status (*satin_complete_fn)(void *user, int number, const char *job, bool *complete);

// Sets *scene to the scene of frame `number`, in which objects and lights are where they are then;
// all else of it is that of the scene that is rendered. The render frees it. Called on the thread
// that called satin_render, before the frame is rendered. A status other than SATIN_OK, which the
// function has reported, ends the render.
typedef satin_status (*satin_moved_fn)(void *user, int number, satin_scene **scene);

// The frames of a render. All pointers are the caller's and must be valid until satin_render
// returns.
typedef struct satin_animation {
    // The views of all frames, whose records are made. NULL: the sensors of the scene, which must
    // have been loaded with SATIN_SCENE_ALL_SENSORS and must have films of one size.
    const satin_view *views;
    int count;        // number of views; ignored if `views` is NULL
    int number;       // of the first view's frame; the others count up from it
    int first, last;  // numbers of the frames whose images are made, which are all of views
    satin_frame_fn frame;
    satin_complete_fn complete;  // frames that are complete are left out; NULL: none is
    void *user;
    // If objects or lights move. The records of the scene that is rendered, in which nothing has
    // moved, are kept in those frames where they are still right (docs/animation.md).
    satin_moved_fn moved;  // NULL: nothing moves
    uint64_t motion;       // a hash of how they move in all frames, for `job`
} satin_animation;

#ifdef __cplusplus
}
#endif
#endif
