// SPDX-License-Identifier: Apache-2.0
// Rays from infinitely far through the openings of a box, such as the windows of a room. Each is in
// bins on the faces of the box, and a ray enters the box through one bin. Along one direction the
// rays are uniform over the projected areas of the bins, times the weights of these.
#include <math.h>

#include "base/sampling.h"
#include "light/light_kinds.h"

enum { BINS_SIDE = LIGHT_HISTOGRAM_SIDE };

void light_openings_build(const struct light_box *box, const float weight[LIGHT_HISTOGRAM_BINS],
                          struct light_openings *out) {
    float power[LIGHT_HISTOGRAM_BINS], most = 0.0f;
    double sum = 0.0;
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) {
        power[i] = weight[i] * light_box_bin_area(box, i / (BINS_SIDE * BINS_SIDE) / 2);
        sum += (double)power[i];
        most = fmaxf(most, weight[i]);
    }
    out->box = *box;
    out->area = most > 0.0f ? (float)sum / most : 0.0f;
    light_bins_build(power, &out->bins);
    for (size_t f = 0; f < 6; f++)
        out->face[f] = out->bins.row[(f + 1) * BINS_SIDE] - out->bins.row[f * BINS_SIDE];
}

// The face across an axis through which light along d enters.
static int entry_face(vec3 d, int axis) { return 2 * axis + !(v3_along(d, axis) > 0.0f); }

// The probability of each face for light along d, by axis, not normalized. Returns their sum.
static float face_weights(const struct light_openings *openings, vec3 d, float weight[3]) {
    float sum = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        weight[axis] = openings->face[entry_face(d, axis)] * fabsf(v3_along(d, axis));
        sum += weight[axis];
    }
    return sum;
}

bool light_openings_face(const struct light_openings *openings, vec3 d) {
    float weight[3];
    return face_weights(openings, d, weight) > 0.0f;
}

// A point in the bins of one of three faces, which is drawn by their weights.
static vec3 draw_point(const struct light_openings *openings, const int face[3],
                       const float weight[3], float u, float v) {
    const struct light_bins *bins = &openings->bins;
    float cdf[4];
    sample_cdf_build(weight, 3, cdf);
    const int at = face[sample_cdf(cdf, 3, u, &u)];
    u = fminf(bins->row[at * BINS_SIDE] + u * openings->face[at], SAMPLE_BELOW_ONE);
    const int row = (int)sample_cdf(bins->row, LIGHT_HISTOGRAM_ROWS, u, &u);
    const int column = (int)sample_cdf(bins->column[row], BINS_SIDE, v, &v);
    return light_box_point(&openings->box, row * BINS_SIDE + column, u, v);
}

vec3 light_openings_point(const struct light_openings *openings, vec3 d, float u, float v) {
    const int face[3] = {entry_face(d, 0), entry_face(d, 1), entry_face(d, 2)};
    float weight[3];
    face_weights(openings, d, weight);
    return draw_point(openings, face, weight, u, v);
}

// The bin of a coordinate on a face; -1 if it is beyond its end.
static int bin_at(const struct light_box *box, vec3 p, int axis) {
    const float lo = v3_along(box->lo, axis), hi = v3_along(box->hi, axis),
                x = BINS_SIDE * (v3_along(p, axis) - lo) / (hi - lo);
    return x >= 0.0f && x < BINS_SIDE ? (int)x : -1;
}

// The probability of the bin through which the ray enters the box, over its area; 0 if it does not
// enter. *axis and *distance are set to those of its face.
static float enter_bin(const struct light_openings *openings, const struct ray *ray, int *axis,
                       float *distance) {
    const struct light_box *box = &openings->box;
    // The ray enters the box where it has crossed the planes of all three faces.
    *axis = 0;
    *distance = 0.0f;
    for (int i = 0; i < 3; i++) {
        const float d = v3_along(ray->d, i);
        if (d == 0.0f) continue;
        const float at = (v3_along(d > 0.0f ? box->lo : box->hi, i) - v3_along(ray->o, i)) / d;
        if (!(at > *distance)) continue;
        *distance = at;
        *axis = i;
    }
    if (!(*distance > 0.0f)) return 0.0f;
    const vec3 p = v3_mad(ray->o, *distance, ray->d);
    const int row = bin_at(box, p, (*axis + 2) % 3), column = bin_at(box, p, (*axis + 1) % 3);
    if (row < 0 || column < 0) return 0.0f;
    const int at = entry_face(ray->d, *axis) * BINS_SIDE + row;
    return light_bins_probability(&openings->bins, at, column) / light_box_bin_area(box, *axis);
}

float light_openings_density(const struct light_openings *openings, const struct ray *ray) {
    float weight[3], distance;
    int axis;
    const float sum = face_weights(openings, ray->d, weight);
    return sum > 0.0f ? enter_bin(openings, ray, &axis, &distance) / sum : 0.0f;
}

float light_openings_most(const struct light_openings *openings, vec3 d) {
    float weight[3];
    const float sum = face_weights(openings, d, weight);
    return sum > 0.0f ? 1.0f / (sum * openings->area) : 0.0f;
}

// ---- From a point -------------------------------------------------------------------------------

// The faces that are visible from p, by axis, and their probabilities, not normalized. Returns the
// sum of these; 0 if p is in the box.
static float faces_from(const struct light_openings *openings, vec3 p, int face[3],
                        float weight[3]) {
    float sum = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        const float at = v3_along(p, axis);
        const bool below = at < v3_along(openings->box.lo, axis);
        const bool above = at > v3_along(openings->box.hi, axis);
        face[axis] = 2 * axis + above;
        weight[axis] = below || above ? openings->face[face[axis]] : 0.0f;
        sum += weight[axis];
    }
    return sum;
}

bool light_openings_faced(const struct light_openings *openings, vec3 p) {
    int face[3];
    float weight[3];
    return faces_from(openings, p, face, weight) > 0.0f;
}

vec3 light_openings_direction(const struct light_openings *openings, vec3 p, float u, float v) {
    int face[3];
    float weight[3];
    faces_from(openings, p, face, weight);
    return v3_unit(v3_sub(draw_point(openings, face, weight, u, v), p));
}

float light_openings_pdf(const struct light_openings *openings, vec3 p, vec3 w) {
    const struct ray ray = {p, 0.0f, w, INFINITY};
    int face[3], axis;
    float weight[3], distance;
    const float sum = faces_from(openings, p, face, weight);
    if (!(sum > 0.0f)) return 0.0f;
    const float density = enter_bin(openings, &ray, &axis, &distance) / sum;
    return density * sqrf(distance) / fabsf(v3_along(w, axis));
}
