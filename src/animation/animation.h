// SPDX-License-Identifier: Apache-2.0
// Animations: a small file describes the view of each frame, by keyframes, frame by frame, or by
// the sensors of the scene, and how objects and lights move (docs/animation.md).
#ifndef ANIMATION_ANIMATION_H
#define ANIMATION_ANIMATION_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"
#include "satin/animation.h"
#include "satin/scene.h"

// An object or a light that moves, and its keyframes.
struct animation_object {
    char *id;
    double pivot[3], axis[3];
    size_t count;
    double *at;              // numbers of frames, ascending
    double (*translate)[3];  // from where the scene has it
    double *knot;            // of `translate`
    double *angle, *scale, *intensity;
};

struct animation_path {
    bool sensors;      // the frames are the sensors of the scene; then there are no views
    satin_view *view;  // of each frame, owned
    int count;
    int number;                       // of the first frame; the others count up from it
    struct animation_object *object;  // owned
    size_t object_count;
};

// Reads a camera path. SATIN_ERROR_INPUT, logged with the line, if the file is wrong, also if the
// view of some frame is degenerate; SATIN_ERROR_MEMORY. The caller frees *out with
// animation_path_free.
satin_status animation_read(struct log log, const char *file, struct animation_path *out);
void animation_path_free(struct animation_path *path);
// Sets the poses of all objects in frame `number`: of pose[i] that of object[i]. Before its first
// keyframe and after its last one an object rests.
void animation_poses(const struct animation_path *path, int number, satin_pose *pose);
// A hash of how all objects move; 0: there are none.
uint64_t animation_motion_hash(const struct animation_path *path);
// Sets the poses that the scene file has.
void animation_poses_at_rest(const struct animation_path *path, satin_pose *pose);

// ---- Splines through keyframes (animation_spline.c) ---------------------------------------------

// The value at x of a spline through `count` points (at[i], value[i]), where `at` ascends and x is
// within it. Between two points it stays between their values; its slope is continuous.
double animation_value(size_t count, const double *at, const double *value, double x);
// The knots of the spline of animation_point, of which there are `count` too.
void animation_knots(size_t count, const double (*point)[3], double *knot);
// The point at x of a spline through point[i] at at[i]: a centripetal Catmull-Rom spline. It and
// its velocity are continuous, and it rests between two equal points. The time grows with the
// logarithm of `count`.
void animation_point(size_t count, const double *at, const double (*point)[3], const double *knot,
                     double x, double out[3]);

#endif
