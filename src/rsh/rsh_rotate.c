// SPDX-License-Identifier: Apache-2.0
// Rotation of harmonics and alignment of frames: from matrices to the turns about z, y and z that
// the kernels apply. [K05 5.3, C, D; Pinchon and Hoggan 2007 for the exchange of y and z.]
#include <math.h>
#include <string.h>

#include "rsh/rsh_kernel.h"

// Below this sine of an angle a rotation by it changes no coefficient in float: 1e-7 / 15 bands
// would be exact, but the entries of a float matrix are no better than 3e-7.
#define RSH_NO_ANGLE 3e-7f

static bool all_finite(const float *v, int count) {
    float sum = 0.0f;
    for (int i = 0; i < count; i++) sum += v[i] * 0.0f;
    return sum == 0.0f;
}

static void copy(int order, int channels, const float *in, float *out) {
    if (in != out) memmove(out, in, (size_t)(order * order * channels) * sizeof *in);
}

// The turns whose product is r. Alpha follows from the third column; gamma then from row y of
// R_z(-alpha) r, which does not suffer when beta is nearly 0 and alpha is uncertain.
static struct rsh_turn turn_of_matrix(const float r[9]) {
    struct rsh_turn t = {.method = RSH_METHOD_EXACT, .cos_alpha = 1.0f};
    float s2 = r[2] * r[2] + r[5] * r[5], s = sqrtf(s2), length = sqrtf(s2 + r[8] * r[8]);
    if (s > RSH_NO_ANGLE) {
        t.cos_alpha = r[2] / s;
        t.sin_alpha = r[5] / s;
    } else {
        s = 0.0f;
    }
    t.sin_beta = length > 0.0f ? s / length : 0.0f;
    t.cos_beta = length > 0.0f ? r[8] / length : 1.0f;
    if (s == 0.0f) t.cos_beta = t.cos_beta < 0.0f ? -1.0f : 1.0f;
    float sine = t.cos_alpha * r[3] - t.sin_alpha * r[0];
    float cosine = t.cos_alpha * r[4] - t.sin_alpha * r[1];
    length = sqrtf(sine * sine + cosine * cosine);
    t.sin_gamma = length > 0.0f ? sine / length : 0.0f;
    t.cos_gamma = length > 0.0f ? cosine / length : 1.0f;
    if (s == 0.0f && t.cos_beta > 0.0f) t.method = RSH_METHOD_Z;
    return t;
}

static bool turn_is_nothing(const struct rsh_turn *t) {
    return t->method == RSH_METHOD_Z && t->cos_gamma > 0.0f && fabsf(t->sin_gamma) <= RSH_NO_ANGLE;
}

bool rsh_rotate_z(int order, int channels, float angle, const float *in, float *out) {
    if (!rsh_order_ok(order) || !isfinite(angle)) return false;
    struct rsh_turn t = {
        .method = RSH_METHOD_Z, .cos_gamma = cosf(angle), .sin_gamma = sinf(angle)};
    rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

static struct rsh_turn turn_about_y(enum rsh_method method, float angle) {
    return (struct rsh_turn){.method = method,
                             .beta = angle,
                             .cos_alpha = 1.0f,
                             .cos_beta = cosf(angle),
                             .sin_beta = sinf(angle),
                             .cos_gamma = 1.0f};
}

bool rsh_rotate_y(int order, int channels, float angle, const float *in, float *out) {
    if (!rsh_order_ok(order) || !isfinite(angle)) return false;
    struct rsh_turn t = turn_about_y(RSH_METHOD_EXACT, angle);
    rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

bool rsh_rotate_y_taylor(rsh_taylor kind, int order, int channels, float angle, const float *in,
                         float *out) {
    if (!rsh_order_ok(order) || !isfinite(angle)) return false;
    static const enum rsh_method method[] = {RSH_METHOD_TAYLOR_1, RSH_METHOD_TAYLOR_1_5,
                                             RSH_METHOD_TAYLOR_2};
    if ((unsigned)kind >= sizeof method / sizeof *method) return false;
    struct rsh_turn t = turn_about_y(method[kind], angle);
    rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

bool rsh_rotate(int order, int channels, const float r[9], const float *in, float *out) {
    if (!rsh_order_ok(order) || !all_finite(r, 9)) return false;
    struct rsh_turn t = turn_of_matrix(r);
    if (turn_is_nothing(&t))
        copy(order, channels, in, out);
    else
        rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

// cos beta' = 2 cos beta - 1, with 1 - cos beta computed without cancellation; below the horizon
// of the other frame (beta > 90 degrees) beta' stays at its end, pi.
static void stretch_angle(struct rsh_turn *t) {
    float lift =
        t->cos_beta > 0.0f ? 2.0f * t->sin_beta * t->sin_beta / (1.0f + t->cos_beta) : 2.0f;
    lift = fminf(lift, 2.0f);
    t->cos_beta = 1.0f - lift;
    t->sin_beta = sqrtf(lift * (2.0f - lift));
}

bool rsh_align(rsh_basis basis, int order, int channels, const float from[9], const float to[9],
               float beta_limit, const float *in, float *out) {
    if (!rsh_order_ok(order) || !all_finite(from, 9) || !all_finite(to, 9)) return false;
    if (memcmp(from, to, 9 * sizeof *from) == 0) {
        copy(order, channels, in, out);
        return true;
    }
    float r[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            r[3 * i + j] = to[3 * i] * from[3 * j] + to[3 * i + 1] * from[3 * j + 1] +
                           to[3 * i + 2] * from[3 * j + 2];
    struct rsh_turn t = turn_of_matrix(r);
    if (turn_is_nothing(&t)) {
        copy(order, channels, in, out);
        return true;
    }
    if (t.method != RSH_METHOD_Z) {
        bool series = atan2f(t.sin_beta, t.cos_beta) <= beta_limit;
        if (basis == RSH_HEMISPHERE) stretch_angle(&t);
        if (series) {
            t.method = RSH_METHOD_TAYLOR_2;
            t.beta = atan2f(t.sin_beta, t.cos_beta);
        }
    }
    rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

bool rsh_align_transposed(rsh_basis basis, int order, int channels, const float from[9],
                          const float to[9], float beta_limit, const float *in, float *out) {
    // Each form is z(alpha) Y(beta) z(gamma) with orthogonal z and Y(beta)^T = Y(-beta), the series
    // included, so the transpose is the same form of the inverse rotation.
    return rsh_align(basis, order, channels, to, from, beta_limit, in, out);
}
