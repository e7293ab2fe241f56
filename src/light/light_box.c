// SPDX-License-Identifier: Apache-2.0
// Directions in bins on the faces of a box around the scene's points: bins of directions would show
// a window in another one from each point. Within a bin, directions are uniform over its area.
#include "base/sampling.h"
#include "light/light_kinds.h"

enum { FACE_SIDE = LIGHT_HISTOGRAM_SIDE, ROWS = LIGHT_HISTOGRAM_ROWS };

// The least distance of points in the box from its faces, in bins, and that of other points and of
// those before an opening: .15, .5 and 1 of them left a variance of direct light of .0120, .0114
// and .0111 in a room with windows, and of .046, .033 and .025 at a window's reveal. From a point
// that is moved by a whole bin, the directions to a window in the wall beside it miss the window: a
// room with a hole of 10 cm had four times the error in 2 s (docs/experiments/direct-light.md).
static const float LEAST_BINS = 0.01f, APART_BINS = 1.0f;

struct light_box light_box_make(vec3 lo, vec3 hi) {
    return (struct light_box){lo, hi};
}

static float move_apart(float x, float lo, float hi) {
    const float margin = APART_BINS / FACE_SIDE * (hi - lo);
    return clampf(x, lo + margin, hi - margin);
}

static float move_inside(float x, float lo, float hi) {
    const float margin = LEAST_BINS / FACE_SIDE * (hi - lo);
    if (x < lo - margin || x > hi + margin) return move_apart(x, lo, hi);
    return clampf(x, lo + margin, hi - margin);
}

vec3 light_box_inside(const struct light_box *box, vec3 p) {
    return v3(move_inside(p.x, box->lo.x, box->hi.x), move_inside(p.y, box->lo.y, box->hi.y),
              move_inside(p.z, box->lo.z, box->hi.z));
}

vec3 light_box_apart(const struct light_box *box, vec3 p) {
    return v3(move_apart(p.x, box->lo.x, box->hi.x), move_apart(p.y, box->lo.y, box->hi.y),
              move_apart(p.z, box->lo.z, box->hi.z));
}

float light_box_bin_width(const struct light_box *box, int axis) {
    return (v3_along(box->hi, axis) - v3_along(box->lo, axis)) / FACE_SIDE;
}

float light_box_bin_area(const struct light_box *box, int axis) {
    return light_box_bin_width(box, (axis + 1) % 3) * light_box_bin_width(box, (axis + 2) % 3);
}

// Faces are numbered by the axis of their normals, the lower one first. Rows are along the next
// axis, and bins of a row lie side by side along it.
vec3 light_box_point(const struct light_box *box, int bin, float u, float v) {
    const int face = bin / (FACE_SIDE * FACE_SIDE), row = bin / FACE_SIDE % FACE_SIDE,
              column = bin % FACE_SIDE;
    const int axis = face / 2, next = (axis + 1) % 3, last = (axis + 2) % 3;
    float q[3];
    q[axis] = v3_along(face % 2 ? box->hi : box->lo, axis);
    q[next] = v3_along(box->lo, next) + ((float)column + v) * light_box_bin_width(box, next);
    q[last] = v3_along(box->lo, last) + ((float)row + u) * light_box_bin_width(box, last);
    return v3(q[0], q[1], q[2]);
}

vec3 light_box_direction(const struct light_box *box, vec3 p, int bin, float u, float v,
                         float *density) {
    const int axis = bin / (FACE_SIDE * FACE_SIDE) / 2;
    const vec3 d = v3_sub(light_box_point(box, bin, u, v), light_box_inside(box, p));
    const float t2 = v3_dot(d, d), t = sqrtf(t2);
    *density = t2 * t / (fabsf(v3_along(d, axis)) * light_box_bin_area(box, axis));
    return v3_mul(d, 1.0f / t);
}

static int clamp_bin(float x) {
    const int i = (int)x;
    return i < 0 ? 0 : i < FACE_SIDE ? i : FACE_SIDE - 1;
}

int light_box_bin(const struct light_box *box, vec3 p, vec3 w, float *density) {
    const vec3 x = light_box_inside(box, p);
    int axis = 0;
    float t = INFINITY;
    for (int i = 0; i < 3; i++) {
        const float d = v3_along(w, i);
        if (d == 0.0f) continue;
        const float at = (v3_along(d > 0.0f ? box->hi : box->lo, i) - v3_along(x, i)) / d;
        if (!(at < t)) continue;
        t = at;
        axis = i;
    }
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    const float side = light_box_bin_width(box, next), height = light_box_bin_width(box, last);
    const vec3 q = v3_sub(v3_mad(x, t, w), box->lo);
    const int face = 2 * axis + (v3_along(w, axis) > 0.0f);
    *density = t * t / (fabsf(v3_along(w, axis)) * side * height);
    return (face * FACE_SIDE + clamp_bin(v3_along(q, last) / height)) * FACE_SIDE +
           clamp_bin(v3_along(q, next) / side);
}

int light_box_around(int bin, int around[9]) {
    const int face = bin / (FACE_SIDE * FACE_SIDE), row = bin / FACE_SIDE % FACE_SIDE,
              column = bin % FACE_SIDE;
    int count = 0;
    for (int y = row - 1; y <= row + 1; y++)
        for (int x = column - 1; x <= column + 1; x++)
            if (y >= 0 && y < FACE_SIDE && x >= 0 && x < FACE_SIDE)
                around[count++] = (face * FACE_SIDE + y) * FACE_SIDE + x;
    return count;
}

void light_bins_build(const float weight[LIGHT_HISTOGRAM_BINS], struct light_bins *out) {
    float sum[ROWS];
    for (size_t row = 0; row < ROWS; row++)
        sum[row] = (float)sample_cdf_build(weight + row * FACE_SIDE, FACE_SIDE, out->column[row]);
    sample_cdf_build(sum, ROWS, out->row);
}

float light_bins_probability(const struct light_bins *bins, int row, int column) {
    return (bins->row[row + 1] - bins->row[row]) *
           (bins->column[row][column + 1] - bins->column[row][column]);
}
