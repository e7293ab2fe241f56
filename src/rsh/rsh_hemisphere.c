// SPDX-License-Identifier: Apache-2.0
// Alignment of frames for both bases, and conversion between hemisphere and sphere.
//
// Hemispherical harmonics are rotated on the sphere, not by reprojection matrices tabulated over
// the angle. With the mirror image as the continuation below the horizon, the error is that of
// these matrices. It needs no table over the angle, and costs two small constant maps more than a
// rotation.
#include <math.h>
#include <string.h>

#include "rsh/rsh_kernel.h"

// Channels that are converted at once, as many as the rotation kernels process together.
enum { HEMISPHERE_BLOCK = 3 };

int rsh_sphere_order(int order) { return order + 2 < RSH_MAX_ORDER ? order + 2 : RSH_MAX_ORDER; }

// Converts channels of orders bands[1] to orders bands[0].
static bool convert(const struct rsh_rows *rows, bool transposed, const int bands[2], int channels,
                    const float *in, float *out) {
    const struct rsh_kernels *k = rsh_kernels_best();
    for (int c = 0; c < channels; c++)
        k->convert(rows, transposed, bands, in + c * bands[1] * bands[1],
                   out + c * bands[0] * bands[0]);
    return true;
}

bool rsh_hemi_extend(int order, int channels, const float *in, float *out) {
    if (!rsh_order_ok(order)) return false;
    const int bands[2] = {rsh_sphere_order(order), order};
    return convert(&rsh_extension[order - 1], false, bands, channels, in, out);
}

bool rsh_hemi_extend_transposed(int order, int channels, const float *in, float *out) {
    if (!rsh_order_ok(order)) return false;
    const int bands[2] = {order, rsh_sphere_order(order)};
    return convert(&rsh_extension[order - 1], true, bands, channels, in, out);
}

bool rsh_hemi_restrict(int order, int channels, const float *in, float *out) {
    if (!rsh_order_ok(order)) return false;
    const int bands[2] = {order, rsh_sphere_order(order)};
    return convert(&rsh_restriction, false, bands, channels, in, out);
}

bool rsh_hemi_restrict_transposed(int order, int channels, const float *in, float *out) {
    if (!rsh_order_ok(order)) return false;
    const int bands[2] = {rsh_sphere_order(order), order};
    return convert(&rsh_restriction, true, bands, channels, in, out);
}

static void align_through_sphere(const struct rsh_rotation *t, bool transposed, int order,
                                 int channels, const float *in, float *out) {
    // Not in place: the loads of a band would wait for the masked stores of the band before it.
    float sphere[HEMISPHERE_BLOCK * RSH_MAX_COEFFICIENTS],
        rotated[HEMISPHERE_BLOCK * RSH_MAX_COEFFICIENTS];
    int n = order * order, larger = rsh_sphere_order(order);
    for (int c = 0; c < channels; c += HEMISPHERE_BLOCK) {
        int block = channels - c < HEMISPHERE_BLOCK ? channels - c : HEMISPHERE_BLOCK;
        if (transposed)
            rsh_hemi_restrict_transposed(order, block, in + c * n, sphere);
        else
            rsh_hemi_extend(order, block, in + c * n, sphere);
        rsh_kernels_best()->rotate(t, larger, block, sphere, rotated);
        if (transposed)
            rsh_hemi_extend_transposed(order, block, rotated, out + c * n);
        else
            rsh_hemi_restrict(order, block, rotated, out + c * n);
    }
}

bool rsh_rotate_stretched(int order, int channels, const float r[9], const float *in, float *out) {
    if (!rsh_order_ok(order) || !rsh_in_range(r, 9)) return false;
    struct rsh_rotation t = rsh_rotation_of_matrix(r);
    if (t.method == RSH_METHOD_EXACT) rsh_rotation_stretch(&t);
    rsh_kernels_best()->rotate(&t, order, channels, in, out);
    return true;
}

// Computes the rotation of coordinates from frame a to frame b.
static void change_of_frame(const float a[9], const float b[9], float r[9]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            r[3 * i + j] =
                b[3 * i] * a[3 * j] + b[3 * i + 1] * a[3 * j + 1] + b[3 * i + 2] * a[3 * j + 2];
}

// The vectors to align.
struct aligned {
    int order, channels;
    const float *in;
    float *out;
};

// The rotation between two frames, or for the transposed map its inverse. False if they are not in
// range.
static bool rotation_between(bool transposed, const float from[9], const float to[9], float r[9]) {
    if (!rsh_in_range(from, 9) || !rsh_in_range(to, 9)) return false;
    if (transposed)
        change_of_frame(to, from, r);
    else
        change_of_frame(from, to, r);
    return true;
}

// All forms but the one through the sphere are z(alpha) Y(beta) z(gamma), with orthogonal z and
// Y(beta)^T = Y(-beta), which also holds for the series. So the transpose is the same form with the
// inverse rotation.
static void align(const rsh_alignment *a, bool transposed, const float r[9],
                  const struct aligned *v) {
    struct rsh_rotation t = rsh_rotation_of_matrix(r);
    if (rsh_rotation_is_identity(&t)) {
        rsh_copy(v->order, v->channels, v->in, v->out);
        return;
    }
    if (t.method == RSH_METHOD_EXACT) {
        bool fast = a->beta_limit > 0.0f && rsh_rotation_angle(&t) <= a->beta_limit;
        if (a->basis == RSH_HEMISPHERE && !fast) {
            align_through_sphere(&t, transposed, v->order, v->channels, v->in, v->out);
            return;
        }
        if (a->basis == RSH_HEMISPHERE) rsh_rotation_stretch(&t);
        if (fast) {
            t.method = RSH_METHOD_TAYLOR_2;
            t.beta = rsh_rotation_angle(&t);
        }
    }
    rsh_kernels_best()->rotate(&t, v->order, v->channels, v->in, v->out);
}

// Aligns vectors from one frame to another. False if an argument is wrong.
static bool align_frames(const rsh_alignment *a, bool transposed, const struct aligned *v) {
    float r[9];
    if (!rsh_basis_ok(a->basis) || !rsh_order_ok(v->order)) return false;
    if (!rotation_between(transposed, a->from, a->to, r)) return false;
    if (memcmp(a->from, a->to, 9 * sizeof *a->from) == 0)
        rsh_copy(v->order, v->channels, v->in, v->out);
    else
        align(a, transposed, r, v);
    return true;
}

bool rsh_align(const rsh_alignment *a, int order, int channels, const float *in, float *out) {
    return align_frames(a, false, &(struct aligned){order, channels, in, out});
}

bool rsh_align_transposed(const rsh_alignment *a, int order, int channels, const float *in,
                          float *out) {
    return align_frames(a, true, &(struct aligned){order, channels, in, out});
}
