// SPDX-License-Identifier: Apache-2.0
// Rotation of spherical harmonics: converts angles and matrices to the rotations about z, y and z
// that the kernels apply [K05 5.3, C, D; Pinchon and Hoggan 2007 for the exchange of y and z].
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "rsh/rsh_kernel.h"

bool rsh_in_range(const float *v, int count) {
    // As integers, magnitudes have the same order and NaN is largest. Any negative difference shows
    // in the sign bit of all differences combined.
    const float most = RSH_MAX_ENTRY;
    int32_t limit, bits, left = 0;
    memcpy(&limit, &most, sizeof limit);
    for (int i = 0; i < count; i++) {
        memcpy(&bits, v + i, sizeof bits);
        left |= limit - (bits & INT32_MAX);
    }
    return left >= 0;
}

void rsh_copy(int order, int channels, const float *in, float *out) {
    if (in != out) memmove(out, in, (size_t)(order * order * channels) * sizeof *in);
}

// 1 / sqrt(x), or 0 for 0. For a rotation x is 1 up to rounding, where one step of Newton's
// iteration is exact and faster than a square root.
static float inverse_length(float x) {
    if (fabsf(x - 1.0f) < 1e-3f) return 1.5f - 0.5f * x;
    return x > 0.0f ? 1.0f / sqrtf(x) : 0.0f;
}

// The rotations whose product is r. Gamma, the first rotation, follows from the third row. The
// upper left 2x2 block gives alpha + gamma, which is accurate even if beta is nearly 0 and gamma
// uncertain, or gamma - alpha if beta is above 90 degrees: the sums and differences of its entries
// are 1 + |cos beta| times cosine and sine.
struct rsh_rotation rsh_rotation_of_matrix(const float r[9]) {
    struct rsh_rotation t = {.method = RSH_METHOD_EXACT, .cos_alpha = 1.0f};
    const float sign = copysignf(1.0f, r[8]);
    const float s2 = r[6] * r[6] + r[7] * r[7], s = sqrtf(s2);
    float cosine = r[4] + sign * r[0], sine = r[3] - sign * r[1];
    const float length = sqrtf(cosine * cosine + sine * sine);
    if (s > RSH_NO_ANGLE) {
        const float unit = inverse_length(s2 + r[8] * r[8]);
        t.cos_gamma = -r[6] / s;
        t.sin_gamma = r[7] / s;
        t.cos_beta = r[8] * unit;
        t.sin_beta = s * unit;
    }
    cosine = length > 0.0f ? cosine / length : 1.0f;
    sine = length > 0.0f ? sine / length : 0.0f;
    if (s > RSH_NO_ANGLE) {
        // The length of (cosine, sine) of alpha is to be the inverse of the rounding error of
        // gamma's.
        const float inverse = 2.0f - (t.cos_gamma * t.cos_gamma + t.sin_gamma * t.sin_gamma);
        t.cos_alpha = inverse * (cosine * t.cos_gamma + sine * t.sin_gamma);
        t.sin_alpha = inverse * sign * (sine * t.cos_gamma - cosine * t.sin_gamma);
    } else {
        t.cos_beta = sign;
        t.cos_gamma = cosine;
        t.sin_gamma = sine;
        if (sign > 0.0f) t.method = RSH_METHOD_Z;
    }
    return t;
}

// cos beta' = 2 cos beta - 1. Both 1 - cos beta' = 2 (1 - cos beta) and 1 + cos beta' = 2 cos beta
// are computed without cancellation, so that beta' is accurate near 0 and near pi. From 90 degrees
// on it stays pi.
void rsh_rotation_stretch(struct rsh_rotation *t) {
    const float above = fmaxf(t->cos_beta, 0.0f);
    float lift = above > 0.0f ? 2.0f * t->sin_beta * t->sin_beta / (1.0f + above) : 2.0f;
    lift = fminf(lift, 2.0f);
    t->cos_beta = 1.0f - lift;
    t->sin_beta = sqrtf(2.0f * above * lift);
}

// Small angles are by the series of the arcsine, whose next term is below the rounding of floats.
float rsh_rotation_angle(const struct rsh_rotation *t) {
    float s = t->sin_beta, u = s * s;
    if (!(u < 0.09f) || t->cos_beta < 0.0f) return atan2f(s, t->cos_beta);
    float sum = 15.0f / 336.0f + u * (105.0f / 3456.0f);
    return s + s * u * (1.0f / 6.0f + u * (3.0f / 40.0f + u * sum));
}

bool rsh_rotation_is_identity(const struct rsh_rotation *t) {
    return t->method == RSH_METHOD_Z && t->cos_gamma > 0.0f && fabsf(t->sin_gamma) <= RSH_NO_ANGLE;
}

bool rsh_method_of_taylor(rsh_taylor kind, enum rsh_method *method) {
    static const enum rsh_method methods[] = {RSH_METHOD_TAYLOR_1, RSH_METHOD_TAYLOR_1_5,
                                              RSH_METHOD_TAYLOR_2};
    if ((unsigned)kind >= sizeof methods / sizeof *methods) return false;
    *method = methods[kind];
    return true;
}

bool rsh_rotate_z(int order, int channels, float angle, const float *in, float *out) {
    if (!rsh_order_ok(order) || !rsh_in_range(&angle, 1)) return false;
    struct rsh_rotation t = {
        .method = RSH_METHOD_Z, .cos_gamma = cosf(angle), .sin_gamma = sinf(angle)};
    rsh_kernels_best()->rotate(&t, order, channels, in, out);
    return true;
}

static struct rsh_rotation rotate_about_y(enum rsh_method method, float angle) {
    return (struct rsh_rotation){.method = method,
                                 .beta = angle,
                                 .cos_alpha = 1.0f,
                                 .cos_beta = cosf(angle),
                                 .sin_beta = sinf(angle),
                                 .cos_gamma = 1.0f};
}

bool rsh_rotate_y(int order, int channels, float angle, const float *in, float *out) {
    if (!rsh_order_ok(order) || !rsh_in_range(&angle, 1)) return false;
    struct rsh_rotation t = rotate_about_y(RSH_METHOD_EXACT, angle);
    rsh_kernels_best()->rotate(&t, order, channels, in, out);
    return true;
}

bool rsh_rotate_y_taylor(rsh_taylor kind, int order, int channels, float angle, const float *in,
                         float *out) {
    enum rsh_method method;
    if (!rsh_order_ok(order) || !rsh_in_range(&angle, 1) || !rsh_method_of_taylor(kind, &method))
        return false;
    struct rsh_rotation t = rotate_about_y(method, angle);
    rsh_kernels_best()->rotate(&t, order, channels, in, out);
    return true;
}

bool rsh_rotate_pinchon_hoggan(int order, int channels, const float r[9], const float *in,
                               float *out) {
    if (!rsh_order_ok(order) || !rsh_in_range(r, 9)) return false;
    struct rsh_rotation t = rsh_rotation_of_matrix(r);
    if (rsh_rotation_is_identity(&t))
        rsh_copy(order, channels, in, out);
    else
        rsh_kernels_best()->rotate(&t, order, channels, in, out);
    return true;
}

bool rsh_rotate(int order, int channels, const float r[9], const float *in, float *out) {
    return rsh_rotate_pinchon_hoggan(order, channels, r, in, out);
}

bool rsh_rotate_taylor(rsh_taylor kind, int order, int channels, const float r[9], const float *in,
                       float *out) {
    enum rsh_method method;
    if (!rsh_order_ok(order) || !rsh_in_range(r, 9) || !rsh_method_of_taylor(kind, &method))
        return false;
    struct rsh_rotation t = rsh_rotation_of_matrix(r);
    if (t.method == RSH_METHOD_EXACT) {
        t.method = method;
        t.beta = rsh_rotation_angle(&t);
    }
    rsh_kernels_best()->rotate(&t, order, channels, in, out);
    return true;
}

rsh_zyz rsh_zyz_of_matrix(const float r[9]) {
    struct rsh_rotation t = rsh_rotation_of_matrix(r);
    float gamma = atan2f(t.sin_gamma, t.cos_gamma);
    if (t.method == RSH_METHOD_Z) return (rsh_zyz){0.0f, 0.0f, gamma};
    return (rsh_zyz){atan2f(t.sin_alpha, t.cos_alpha), atan2f(t.sin_beta, t.cos_beta), gamma};
}

bool rsh_rotate_zyz(int order, int channels, rsh_zyz a, const float *in, float *out) {
    if (!rsh_order_ok(order) || !rsh_in_range((float[3]){a.alpha, a.beta, a.gamma}, 3))
        return false;
    const struct rsh_rotation t = {RSH_METHOD_EXACT, a.beta,       cosf(a.alpha), sinf(a.alpha),
                                   cosf(a.beta),     sinf(a.beta), cosf(a.gamma), sinf(a.gamma)};
    rsh_kernels_best()->rotate(&t, order, channels, in, out);
    return true;
}
