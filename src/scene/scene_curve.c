// SPDX-License-Identifier: Apache-2.0
// Curves: the surface at a hit. v grows from 0 to 1 along all segments of a shape, as in Mitsuba; u
// goes around the tube, from another axis than in Mitsuba.
#include "scene/scene_curve.h"

// Hits are moved outwards by this fraction of the radius: more than the error of Embree's round
// curves (up to some 1e-4 where they are curved), and too little to be visible.
#define OUTSIDE 1e-3f

void scene_curves_bound(const struct curves *curves, vec3 *lo, vec3 *hi) {
    *lo = v3(INFINITY, INFINITY, INFINITY);
    *hi = v3_neg(*lo);
    for (size_t i = 0; i < curves->points; i++) {
        const float *p = curves->point + 4 * i;
        vec3 r = v3(p[3], p[3], p[3]), c = v3(p[0], p[1], p[2]);
        *lo = v3_min(*lo, v3_sub(c, r));
        *hi = v3_max(*hi, v3_add(c, r));
    }
}

// ---- The surface --------------------------------------------------------------------------------

// Sets the weights of a segment's points at u and their derivatives by u. Returns the number of
// points.
static int basis(bool linear, float u, float w[4], float d[4]) {
    float v = 1.0f - u;
    if (linear) {
        w[0] = v, w[1] = u;
        d[0] = -1.0f, d[1] = 1.0f;
        return 2;
    }
    w[0] = v * v * v / 6.0f;
    w[1] = (3.0f * u * u * u - 6.0f * u * u + 4.0f) / 6.0f;
    w[2] = (3.0f * v * v * v - 6.0f * v * v + 4.0f) / 6.0f;
    w[3] = u * u * u / 6.0f;
    d[0] = -0.5f * v * v;
    d[1] = 0.5f * (3.0f * u * u - 4.0f * u);
    d[2] = -0.5f * (3.0f * v * v - 4.0f * v);
    d[3] = 0.5f * u * u;
    return 4;
}

void scene_curve_interaction(const struct curves *curves, const struct curve_hit *hit, bool tangent,
                             struct interaction *out) {
    const float *point = curves->point + (size_t)curves->first[hit->segment] * 4;
    float w[4], d[4], radius = 0.0f;
    int count = basis(curves->linear, hit->u, w, d);
    vec3 along = v3(0, 0, 0);
    for (int i = 0; i < count; i++) {
        const float *p = point + 4 * i;
        along = v3_mad(along, d[i], v3(p[0], p[1], p[2]));
        radius += w[i] * p[3];
    }
    vec3 n = v3_unit(hit->n), axis = v3_unit(along);
    struct frame around = frame_from_normal(axis);
    out->p = v3_mad(hit->p, OUTSIDE * radius, n);
    out->ng = hit->flip ? v3_neg(n) : n;
    out->uv = (vec2){azimuth_fraction(v3_dot(n, around.v), v3_dot(n, around.u)),
                     ((float)hit->segment + hit->u) / (float)curves->segments};
    out->dp_dv = along;
    out->dp_du = v3_mul(v3_cross(along, n), 2.0f * PI_F * radius / fmaxf(v3_len(along), 1e-20f));
    out->frame = tangent ? frame_from_tangent(out->ng, out->dp_du) : frame_from_normal(out->ng);
}
