// SPDX-License-Identifier: Apache-2.0
// Alignment of many records against that of one: every instruction set this machine has, frames in
// which angles are degenerate, every order, and every number of records up to 40.
//
// The definition is rsh_align in plain C. Results are compared relative to the length of the vector
// times the largest factor by which the form enlarges it.
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh/rsh_kernel.h"
#include "rsh_noise.h"

enum { CHANNELS = 3, MOST_FRAMES = 160, MOST_COUNT = 40 };
#define PI 3.14159265358979

static const float limits[] = {0.0f, 0.2f, 0.4f, 4.0f};
enum { LIMITS = sizeof limits / sizeof *limits };

static float rsh_batch_map_single[MOST_FRAMES][2][9];  // from and to
static int rsh_batch_map_frames;
static float rsh_batch_map_in[CHANNELS * MAX * MOST_FRAMES],
    rsh_batch_map_out[CHANNELS * MAX * MOST_FRAMES];
static float some_in[CHANNELS * MAX * MOST_COUNT], some_out[CHANNELS * MAX * MOST_COUNT];
static float rsh_batch_map_expected[MOST_FRAMES][CHANNELS * MAX];

typedef bool align_one(const rsh_alignment *alignment, int order, int channels,
                       const float *rsh_batch_map_in, float *rsh_batch_map_out);
typedef bool align_many(const rsh_alignments *alignments, int order, int channels, size_t count,
                        const float *rsh_batch_map_in, float *rsh_batch_map_out);
static align_one *const ones[] = {rsh_align, rsh_align_transposed};
static align_many *const manys[] = {rsh_align_many, rsh_align_transposed_many};

static void rsh_batch_map_add(const float from[9], const float to[9]) {
    assert_true(rsh_batch_map_frames < MOST_FRAMES);
    memcpy(rsh_batch_map_single[rsh_batch_map_frames][0], from,
           sizeof rsh_batch_map_single[rsh_batch_map_frames][0]);
    memcpy(rsh_batch_map_single[rsh_batch_map_frames][1], to,
           sizeof rsh_batch_map_single[rsh_batch_map_frames][1]);
    rsh_batch_map_frames++;
}

// Adds the frame `from` and the same frame rotated by r.
static void rsh_batch_map_add_rotated(const float from[9], const float r[9]) {
    float to[9];
    rsh_noise_multiply(r, from, to);
    rsh_batch_map_add(from, to);
}

// The angle between the normals of the last frames.
static double last_angle(void) {
    const float *a = rsh_batch_map_single[rsh_batch_map_frames - 1][0] + 6,
                *b = rsh_batch_map_single[rsh_batch_map_frames - 1][1] + 6;
    return acos(fmin(fmax((double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2], -1), 1));
}

// Sets r to the rotation about the horizontal axis at `azimuth`.
static void tilt(double azimuth, double angle, float r[9]) {
    const double x = cos(azimuth), y = sin(azimuth), c = cos(angle), s = sin(angle), d = 1 - c;
    const double m[9] = {c + x * x * d, x * y * d, y * s, x * y * d, c + y * y * d,
                         -x * s,        -y * s,    x * s, c};
    for (int e = 0; e < 9; e++) r[e] = (float)m[e];
}

static float determinant(const float r[9]) {
    return r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
           r[2] * (r[3] * r[7] - r[4] * r[6]);
}

// The 24 rotations that take axes to axes, from the world's frame and from another.
static void add_axes(uint32_t *seed) {
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const float world[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    int found = 0;
    for (int permutation = 0; permutation < 6; permutation++)
        for (int signs = 0; signs < 8; signs++) {
            float r[9] = {0}, other[9];
            for (int i = 0; i < 3; i++)
                r[3 * i + order[permutation][i]] = signs >> i & 1 ? -1.0f : 1.0f;
            if (determinant(r) < 0.0f) continue;
            noise_rotation(seed, other);
            rsh_batch_map_add_rotated(world, r);
            rsh_batch_map_add_rotated(other, r);
            found++;
        }
    assert_int_equal(found, 24);
}

// Adds frames whose normals are exactly opposed: by a sign alone, and rotated about the normal.
static void add_opposed(uint32_t *seed) {
    for (int i = 0; i < 12; i++) {
        float from[9], to[9], a = i < 4 ? 0.0f : 3.0f * noise(seed), c = cosf(a), s = sinf(a);
        noise_rotation(seed, from);
        for (int k = 0; k < 3; k++) {
            to[k] = c * from[k] + s * from[3 + k];
            to[3 + k] = s * from[k] - c * from[3 + k];
            to[6 + k] = -from[6 + k];
        }
        rsh_batch_map_add(from, to);
    }
}

// Adds rotations that are close to none, to 90 and to 180 degrees.
static void add_near(uint32_t *seed) {
    const double centre[] = {0.0, PI / 2.0, PI};
    for (int i = 0; i < 3; i++)
        for (int k = 1; k <= 7; k++)
            for (int side = -1; side <= 1; side += 2) {
                float from[9], r[9];
                if (side == -1 && i == 0) continue;
                noise_rotation(seed, from);
                tilt(3.0 * (double)noise(seed), centre[i] + side * pow(10.0, -k), r);
                rsh_batch_map_add_rotated(from, r);
            }
}

// Adds random rotations, by angles below the limits and by any, but by none so near a limit that
// rounding decides.
static void add_random(uint32_t *seed) {
    for (int i = 0; i < 24; i++) {
        float from[9], r[9];
        noise_rotation(seed, from);
        if (i < 12)
            tilt(3.0 * (double)noise(seed), 0.5 * (double)noise(seed), r);
        else
            noise_rotation(seed, r);
        rsh_batch_map_add_rotated(from, r);
        for (int k = 1; k < LIMITS; k++)
            if (fabs(last_angle() - (double)limits[k]) < 1e-5) rsh_batch_map_frames--;
    }
}

// One frame is both arguments, also one whose rows deviate from orthonormal as much as callers' do;
// or both are mirrored, which makes their quotient a rotation.
static void add_alike(uint32_t *seed) {
    for (int i = 0; i < 6; i++) {
        float from[9], to[9];
        noise_rotation(seed, from);
        for (int e = 0; e < 9 && i > 2; e++) from[e] += 1e-6f * noise(seed);
        rsh_batch_map_add(from, from);
        noise_rotation(seed, to);
        for (int e = 0; e < 3; e++) from[e] = -from[e], to[e] = -to[e];
        rsh_batch_map_add(from, to);
    }
}

static int rsh_batch_map_make_frames(void **state) {
    (void)state;
    uint32_t seed = 31;
    rsh_batch_map_frames = 0;
    add_axes(&seed);
    add_opposed(&seed);
    add_near(&seed);
    add_random(&seed);
    add_alike(&seed);
    return 0;
}

// Entry e of the frames of records first, first + 1 ..., beginning again after the last.
static void rsh_batch_map_columns(int first, int count, float (*a)[MOST_FRAMES], int which,
                                  const float *rows[9]) {
    for (int e = 0; e < 9; e++) {
        for (int i = 0; i < count; i++)
            a[e][i] = rsh_batch_map_single[(first + i) % rsh_batch_map_frames][which][e];
        rows[e] = a[e];
    }
}

struct rsh_batch_map_variant {
    rsh_basis basis;
    int order, channels, transposed;
    float limit;
};

static bool rsh_batch_map_run_many(const struct rsh_batch_map_variant *v, int first, int count,
                                   const float *from_in, float *to_out) {
    float a[9][MOST_FRAMES], b[9][MOST_FRAMES];
    const float *from[9], *to[9];
    rsh_batch_map_columns(first, count, a, 0, from);
    rsh_batch_map_columns(first, count, b, 1, to);
    const rsh_alignments alignments = {v->basis, from, to, v->limit};
    return manys[v->transposed](&alignments, v->order, v->channels, (size_t)count, from_in, to_out);
}

// Fills `in`, and `expected` by single calls.
static void rsh_batch_map_expect(const struct rsh_batch_map_variant *v, uint32_t *seed) {
    const int n = v->channels * v->order * v->order;
    for (int i = 0; i < rsh_batch_map_frames; i++) {
        float one[CHANNELS * MAX];
        noise_unit(seed, n, one);
        for (int k = 0; k < n; k++) rsh_batch_map_in[k * rsh_batch_map_frames + i] = one[k];
        const rsh_alignment alignment = {v->basis, rsh_batch_map_single[i][0],
                                         rsh_batch_map_single[i][1], v->limit};
        assert_true(
            ones[v->transposed](&alignment, v->order, v->channels, one, rsh_batch_map_expected[i]));
    }
}

// How far results may be apart: both have the entries of the same matrix. Each of the three angles
// comes from them by a root, a quotient and sums of two products: 6 roundings of half of
// FLT_EPSILON, twice for the two sides of the comparison; a single record treats an angle below
// RSH_NO_ANGLE as 0, where a vector uses it. Band l has l times the error of the angle, and
// multiples of angles by recurrence add 2 roundings per step.
//
// The series by beta up to pi enlarges vectors by up to 1 + beta l + (beta l)^2 / 2, and errors
// too.
static double tolerance(const struct rsh_batch_map_variant *v, int i) {
    const double l = v->order, angle = 3.0 * 6.0 * FLT_EPSILON + RSH_NO_ANGLE;
    const double rounding = (double)FLT_EPSILON * 2.0 * 3.0;
    const float *a = rsh_batch_map_single[i][0] + 6, *b = rsh_batch_map_single[i][1] + 6;
    double beta = acos(fmin(fmax((double)(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]), -1.0), 1.0));
    bool fast = v->limit > 0.0f && beta <= (double)v->limit + 1e-3;
    if (v->basis == RSH_HEMISPHERE) beta = acos(fmax(2.0 * cos(beta) - 1.0, -1.0));
    const double most = fast ? 1.0 + beta * l + 0.5 * beta * beta * l * l : 1.0;
    return l * (angle + rounding) * most;
}

static void rsh_batch_map_compare(const char *set, const struct rsh_batch_map_variant *v) {
    const int n = v->channels * v->order * v->order;
    for (int i = 0; i < rsh_batch_map_frames; i++) {
        float one[CHANNELS * MAX];
        for (int k = 0; k < n; k++) one[k] = rsh_batch_map_out[k * rsh_batch_map_frames + i];
        double d = rsh_noise_distance(n, one, rsh_batch_map_expected[i]);
        if (!(d < tolerance(v, i)))
            fail_msg(
                "%s, basis %d, order %d, channels %d, transposed %d, limit %g, frame %d: "
                "off by %g, tolerance %g",
                set, (int)v->basis, v->order, v->channels, v->transposed, (double)v->limit, i, d,
                tolerance(v, i));
    }
}

// Any number of records, at any position, have the same bits as among all.
static void compare_counts(const struct rsh_batch_map_variant *v, int *first) {
    const int n = v->channels * v->order * v->order;
    for (int count = 1; count <= MOST_COUNT; count++) {
        *first = (*first + 7) % rsh_batch_map_frames;
        for (int k = 0; k < n; k++)
            for (int i = 0; i < count; i++)
                some_in[k * count + i] = rsh_batch_map_in[k * rsh_batch_map_frames +
                                                          (*first + i) % rsh_batch_map_frames];
        assert_true(rsh_batch_map_run_many(v, *first, count, some_in, some_out));
        for (int k = 0; k < n; k++)
            for (int i = 0; i < count; i++)
                assert_memory_equal(&some_out[k * count + i],
                                    &rsh_batch_map_out[k * rsh_batch_map_frames +
                                                       (*first + i) % rsh_batch_map_frames],
                                    sizeof *rsh_batch_map_out);
    }
}

static void check_order(int order, uint32_t *seed, int *first) {
    for (int form = 0; form < 8 * LIMITS; form++) {
        const struct rsh_batch_map_variant v = {form & 1 ? RSH_HEMISPHERE : RSH_SPHERE, order,
                                                form & 2 ? CHANNELS : 1, form >> 2 & 1,
                                                limits[form >> 3]};
        rsh_kernels_choose(&rsh_kernels_plain);
        rsh_batch_map_expect(&v, seed);
        for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++) {
            rsh_kernels_choose(*k);
            assert_true(rsh_batch_map_run_many(&v, 0, rsh_batch_map_frames, rsh_batch_map_in,
                                               rsh_batch_map_out));
            rsh_batch_map_compare((*k)->name, &v);
            // The position of records does not depend on the order, so a few orders suffice.
            if (order % 3 == 1 && order < 10) compare_counts(&v, first);
        }
        rsh_kernels_choose(rsh_kernels_usable()[0]);
    }
}

static void many_equal_single_ones(void **state) {
    (void)state;
    uint32_t seed = 32;
    int first = 0;
    for (int order = 1; order <= RSH_MAX_ORDER; order++) check_order(order, &seed, &first);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(many_equal_single_ones, rsh_batch_map_make_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
