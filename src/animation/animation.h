// SPDX-License-Identifier: Apache-2.0
// Camera paths: a small file describes the view of each frame of an animation, by keyframes,
// frame by frame, or by the sensors of the scene (docs/animation.md).
#ifndef ANIMATION_ANIMATION_H
#define ANIMATION_ANIMATION_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"
#include "satin/animation.h"

struct animation_path {
    bool sensors;      // the frames are the sensors of the scene; then there are no views
    satin_view *view;  // of each frame, owned
    int count;
    int number;  // of the first frame; the others count up from it
};

// Reads a camera path. SATIN_ERROR_INPUT, logged with the line, if the file is wrong, also if the
// view of some frame is degenerate; SATIN_ERROR_MEMORY. The caller frees *out with
// animation_path_free.
satin_status animation_read(struct log log, const char *file, struct animation_path *out);
void animation_path_free(struct animation_path *path);

// ---- Curves through keyframes (animation_curve.c) -----------------------------------------------

// The value at x of a curve through `count` points (at[i], value[i]), where `at` ascends and x is
// within it. Between two points it stays between their values; its slope is continuous.
double animation_value(size_t count, const double *at, const double *value, double x);
// The knots of the curve of animation_point, of which there are `count` too.
void animation_knots(size_t count, const double (*point)[3], double *knot);
// The point at x of a curve through point[i] at at[i]: a centripetal Catmull-Rom spline. It and its
// velocity are continuous, and it rests between two equal points. The time grows with the logarithm
// of `count`.
void animation_point(size_t count, const double *at, const double (*point)[3], const double *knot,
                     double x, double out[3]);

#endif
