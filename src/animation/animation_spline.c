// SPDX-License-Identifier: Apache-2.0
// Splines through keyframes. Single values follow a monotone cubic [Fritsch and Butland 1984].
// Points follow a centripetal Catmull-Rom spline, which has neither cusps nor loops between two
// keyframes [Yuksel et al. 2011]: its knots are apart by the square roots of the distances of the
// points. How far the camera is along the knots at a frame is a monotone cubic again, so that its
// speed does not jump at a keyframe, whatever the numbers of the frames are.
#include <math.h>

#include "animation/animation.h"

// Cubic Hermite interpolation from y0 to y1 at u in [0, 1]; the slopes m0 and m1 are per u.
static double hermite(double y0, double m0, double y1, double m1, double u) {
    const double v = 1.0 - u;
    return y0 * v * v * (1.0 + 2.0 * u) + y1 * u * u * (3.0 - 2.0 * u) + m0 * u * v * v -
           m1 * u * u * v;
}

// The index i of the segment [at[i], at[i + 1]] that has x.
static size_t find_segment(size_t count, const double *at, double x) {
    size_t i = 0, end = count - 1;
    while (i + 1 < end) {
        const size_t middle = (i + end) / 2;
        if (x >= at[middle])
            i = middle;
        else
            end = middle;
    }
    return i;
}

static double secant(const double *at, const double *value, size_t i) {
    return (value[i + 1] - value[i]) / (at[i + 1] - at[i]);
}

// The slope of a monotone spline at point i: a weighted harmonic mean of the secants beside it.
static double monotone_slope(size_t count, const double *at, const double *value, size_t i) {
    if (i == 0) return secant(at, value, 0);
    if (i + 1 == count) return secant(at, value, i - 1);
    const double before = secant(at, value, i - 1), after = secant(at, value, i);
    if (!(before * after > 0.0)) return 0.0;
    const double h0 = at[i] - at[i - 1], h1 = at[i + 1] - at[i];
    return 3.0 * (h0 + h1) / ((2.0 * h1 + h0) / before + (h1 + 2.0 * h0) / after);
}

double animation_value(size_t count, const double *at, const double *value, double x) {
    if (count == 1) return value[0];
    const size_t i = find_segment(count, at, x);
    const double h = at[i + 1] - at[i];
    return hermite(value[i], h * monotone_slope(count, at, value, i), value[i + 1],
                   h * monotone_slope(count, at, value, i + 1), (x - at[i]) / h);
}

static double point_distance(const double a[3], const double b[3]) {
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

// The derivative by the knot of one coordinate at point i, from the nearest points on both sides
// that differ from it; equal points have equal knots.
static double spline_slope(size_t count, const double *knot, const double (*point)[3], int axis,
                           size_t i) {
    size_t before = i, after = i;
    while (before > 0 && knot[before] == knot[i]) before--;
    while (after + 1 < count && knot[after] == knot[i]) after++;
    const double h0 = knot[i] - knot[before], h1 = knot[after] - knot[i];
    const double d0 = h0 > 0.0 ? (point[i][axis] - point[before][axis]) / h0 : 0.0;
    const double d1 = h1 > 0.0 ? (point[after][axis] - point[i][axis]) / h1 : 0.0;
    if (!(h0 > 0.0) || !(h1 > 0.0)) return d0 + d1;
    return (d0 * h1 + d1 * h0) / (h0 + h1);
}

void animation_knots(size_t count, const double (*point)[3], double *knot) {
    knot[0] = 0.0;
    for (size_t i = 1; i < count; i++)
        knot[i] = knot[i - 1] + sqrt(point_distance(point[i - 1], point[i]));
}

void animation_point(size_t count, const double *at, const double (*point)[3], const double *knot,
                     double x, double out[3]) {
    const size_t i = count > 1 ? find_segment(count, at, x) : 0;
    const double h = count > 1 ? knot[i + 1] - knot[i] : 0.0;
    for (int axis = 0; axis < 3; axis++) {
        out[axis] = point[i][axis];
        if (!(h > 0.0)) continue;
        const double u = (animation_value(count, at, knot, x) - knot[i]) / h;
        out[axis] =
            hermite(point[i][axis], h * spline_slope(count, knot, point, axis, i),
                    point[i + 1][axis], h * spline_slope(count, knot, point, axis, i + 1), u);
    }
}
