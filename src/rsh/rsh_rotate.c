// SPDX-License-Identifier: Apache-2.0
// Rotation of spherical harmonics: from angles and matrices to the turns about z, y and z that the
// kernels apply. [K05 5.3, C, D; Pinchon and Hoggan 2007 for the exchange of y and z.]
#include <math.h>
#include <string.h>

#include "rsh/rsh_kernel.h"

bool rsh_all_finite(const float *v, int count) {
    float sum = 0.0f;
    for (int i = 0; i < count; i++) sum += v[i] * 0.0f;
    return sum == 0.0f;
}

void rsh_copy(int order, int channels, const float *in, float *out) {
    if (in != out) memmove(out, in, (size_t)(order * order * channels) * sizeof *in);
}

// The turns whose product is r. Alpha follows from the third column; gamma then from row y of
// R_z(-alpha) r, which does not suffer when beta is nearly 0 and alpha is uncertain.
struct rsh_turn rsh_turn_of_matrix(const float r[9]) {
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

// cos beta' = 2 cos beta - 1, with 1 - cos beta computed without cancellation; from 90 degrees on
// beta' stays at its end, pi.
void rsh_turn_stretch(struct rsh_turn *t) {
    float lift =
        t->cos_beta > 0.0f ? 2.0f * t->sin_beta * t->sin_beta / (1.0f + t->cos_beta) : 2.0f;
    lift = fminf(lift, 2.0f);
    t->cos_beta = 1.0f - lift;
    t->sin_beta = sqrtf(lift * (2.0f - lift));
}

bool rsh_turn_is_nothing(const struct rsh_turn *t) {
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
    enum rsh_method method;
    if (!rsh_order_ok(order) || !isfinite(angle) || !rsh_method_of_taylor(kind, &method))
        return false;
    struct rsh_turn t = turn_about_y(method, angle);
    rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

bool rsh_rotate_pinchon_hoggan(int order, int channels, const float r[9], const float *in,
                               float *out) {
    if (!rsh_order_ok(order) || !rsh_all_finite(r, 9)) return false;
    struct rsh_turn t = rsh_turn_of_matrix(r);
    if (rsh_turn_is_nothing(&t))
        rsh_copy(order, channels, in, out);
    else
        rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

bool rsh_rotate(int order, int channels, const float r[9], const float *in, float *out) {
    return rsh_rotate_pinchon_hoggan(order, channels, r, in, out);
}

bool rsh_rotate_taylor(rsh_taylor kind, int order, int channels, const float r[9], const float *in,
                       float *out) {
    enum rsh_method method;
    if (!rsh_order_ok(order) || !rsh_all_finite(r, 9) || !rsh_method_of_taylor(kind, &method))
        return false;
    struct rsh_turn t = rsh_turn_of_matrix(r);
    if (t.method == RSH_METHOD_EXACT) {
        t.method = method;
        t.beta = atan2f(t.sin_beta, t.cos_beta);
    }
    rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}

rsh_zyz rsh_zyz_of_matrix(const float r[9]) {
    struct rsh_turn t = rsh_turn_of_matrix(r);
    float gamma = atan2f(t.sin_gamma, t.cos_gamma);
    if (t.method == RSH_METHOD_Z) return (rsh_zyz){0.0f, 0.0f, gamma};
    return (rsh_zyz){atan2f(t.sin_alpha, t.cos_alpha), atan2f(t.sin_beta, t.cos_beta), gamma};
}

bool rsh_rotate_zyz(int order, int channels, rsh_zyz a, const float *in, float *out) {
    if (!rsh_order_ok(order) || !rsh_all_finite((float[3]){a.alpha, a.beta, a.gamma}, 3))
        return false;
    const struct rsh_turn t = {RSH_METHOD_EXACT, a.beta,       cosf(a.alpha), sinf(a.alpha),
                               cosf(a.beta),     sinf(a.beta), cosf(a.gamma), sinf(a.gamma)};
    rsh_kernels_best()->turn(&t, order, channels, in, out);
    return true;
}
