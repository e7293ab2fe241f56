// SPDX-License-Identifier: Apache-2.0
// Small vectors and colours, by value. Directions are unit unless said otherwise; angles are
// radians.
#ifndef BASE_VEC_H
#define BASE_VEC_H

#include <math.h>
#include <stdbool.h>

typedef struct vec2 {
    float x, y;
} vec2;

typedef struct vec3 {
    float x, y, z;
} vec3;

typedef struct rgb {
    float r, g, b;  // linear sRGB
} rgb;

#define PI_F 3.14159265358979323846f
// The second row of the matrix from linear sRGB to CIE XYZ.
#define LUMINANCE_R 0.212671f
#define LUMINANCE_G 0.715160f
#define LUMINANCE_B 0.072169f

// One instruction each, while fminf and fmaxf are calls. If either is NaN, the result is b.
static inline float minf(float a, float b) { return a < b ? a : b; }
static inline float maxf(float a, float b) { return a > b ? a : b; }

static inline vec3 v3(float x, float y, float z) { return (vec3){x, y, z}; }
static inline vec3 v3_of_doubles(const double v[3]) {
    return v3((float)v[0], (float)v[1], (float)v[2]);
}
static inline vec3 v3_add(vec3 a, vec3 b) { return v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline vec3 v3_sub(vec3 a, vec3 b) { return v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline vec3 v3_mul(vec3 a, float s) { return v3(a.x * s, a.y * s, a.z * s); }
// The coordinate along axis 0, 1 or 2.
static inline float v3_along(vec3 a, int axis) { return axis == 0 ? a.x : axis == 1 ? a.y : a.z; }
static inline vec3 v3_neg(vec3 a) { return v3(-a.x, -a.y, -a.z); }
// a + s * b
static inline vec3 v3_mad(vec3 a, float s, vec3 b) {
    return v3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}
static inline float v3_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec3 v3_cross(vec3 a, vec3 b) {
    return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float v3_len2(vec3 a) { return v3_dot(a, a); }
static inline float v3_len(vec3 a) { return sqrtf(v3_len2(a)); }
// The length of a vector whose squared length may overflow or underflow.
static inline float v3_len_wide(vec3 a) {
    double x = a.x, y = a.y, z = a.z;
    return (float)sqrt(x * x + y * y + z * z);
}
static inline float v3_dist2(vec3 a, vec3 b) { return v3_len2(v3_sub(a, b)); }
// a / |a|. A zero vector stays zero.
static inline vec3 v3_unit(vec3 a) {
    float l = v3_len(a);
    return l > 0.0f ? v3_mul(a, 1.0f / l) : a;
}
// v3_unit for a vector whose squared length may overflow or underflow, such as the cross product of
// long or short edges.
static inline vec3 v3_unit_wide(vec3 a) {
    float l = v3_len_wide(a);
    return l > 0.0f ? v3_mul(a, 1.0f / l) : a;
}
// The angle between unit vectors, accurate near 0 and pi.
static inline float v3_angle(vec3 a, vec3 b) {
    return 2.0f * atan2f(v3_len(v3_sub(a, b)), v3_len(v3_add(a, b)));
}
static inline bool v3_finite(vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
static inline float v3_max_abs(vec3 a) { return maxf(fabsf(a.x), maxf(fabsf(a.y), fabsf(a.z))); }
// The minimum by coordinate. If b has a NaN, the coordinate of a.
static inline vec3 v3_min(vec3 a, vec3 b) {
    return v3(minf(b.x, a.x), minf(b.y, a.y), minf(b.z, a.z));
}
static inline vec3 v3_max(vec3 a, vec3 b) {
    return v3(maxf(b.x, a.x), maxf(b.y, a.y), maxf(b.z, a.z));
}
// Whether p is in the box from lo to hi, or on its boundary.
static inline bool v3_within(vec3 p, vec3 lo, vec3 hi) {
    return p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x <= hi.x && p.y <= hi.y && p.z <= hi.z;
}

static inline rgb rgb_make(float r, float g, float b) { return (rgb){r, g, b}; }
static inline rgb rgb_grey(float v) { return (rgb){v, v, v}; }
static inline rgb rgb_add(rgb a, rgb b) { return rgb_make(a.r + b.r, a.g + b.g, a.b + b.b); }
static inline rgb rgb_sub(rgb a, rgb b) { return rgb_make(a.r - b.r, a.g - b.g, a.b - b.b); }
static inline rgb rgb_mul(rgb a, rgb b) { return rgb_make(a.r * b.r, a.g * b.g, a.b * b.b); }
static inline rgb rgb_scale(rgb a, float s) { return rgb_make(a.r * s, a.g * s, a.b * s); }
// a + b * s
static inline rgb rgb_mad(rgb a, rgb b, float s) {
    return rgb_make(a.r + b.r * s, a.g + b.g * s, a.b + b.b * s);
}
// a + b * c
static inline rgb rgb_fma(rgb a, rgb b, rgb c) {
    return rgb_make(a.r + b.r * c.r, a.g + b.g * c.g, a.b + b.b * c.b);
}
static inline float rgb_max(rgb a) { return maxf(a.r, maxf(a.g, a.b)); }
static inline float rgb_mean(rgb a) { return (a.r + a.g + a.b) * (1.0f / 3.0f); }
static inline float rgb_luminance(rgb a) {
    return LUMINANCE_R * a.r + LUMINANCE_G * a.g + LUMINANCE_B * a.b;
}
static inline bool rgb_black(rgb a) { return a.r == 0.0f && a.g == 0.0f && a.b == 0.0f; }
static inline bool rgb_finite(rgb a) { return isfinite(a.r) && isfinite(a.g) && isfinite(a.b); }

// x clamped to [lo, hi]. A NaN becomes lo.
static inline float clampf(float x, float lo, float hi) { return minf(maxf(x, lo), hi); }
static inline float lerpf(float a, float b, float t) { return a + (b - a) * t; }
static inline float sqrf(float x) { return x * x; }
// The larger of x and lo. A NaN stays a NaN, so that a later check finds it.
static inline float at_least(float x, float lo) { return maxf(lo, x); }
static inline rgb rgb_at_least(rgb a, float lo) {
    return rgb_make(at_least(a.r, lo), at_least(a.g, lo), at_least(a.b, lo));
}
static inline rgb rgb_at_most(rgb a, float hi) {
    return rgb_make(minf(hi, a.r), minf(hi, a.g), minf(hi, a.b));
}
// The azimuth of (x, y) as a fraction of the full circle, in [0, 1]; 1 is by rounding. The wide
// form is in double until its result.
static inline float azimuth_fraction(float y, float x) {
    float t = atan2f(y, x) * (0.5f / PI_F);
    return t < 0.0f ? t + 1.0f : t;
}
static inline float azimuth_fraction_wide(double y, double x) {
    double t = atan2(y, x) * (0.5 / M_PI);
    return (float)(t < 0.0 ? t + 1.0 : t);
}
// The square root, where values below zero, from rounding, count as zero. A NaN stays a NaN.
static inline float safe_sqrtf(float x) { return sqrtf(at_least(x, 0.0f)); }

#endif
