// SPDX-License-Identifier: Apache-2.0
// Rotation and alignment of many records: each record's result is that of the single call, for any
// position, neighbours and number of records.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh_noise.h"

enum { ORDER = 7, N = ORDER * ORDER, CHANNELS = 4, MOST = 37 };

static float rsh_many_in[CHANNELS * N * MOST], rsh_many_out[CHANNELS * N * MOST + 1];
static float rsh_many_from[9][MOST], rsh_many_to[9][MOST], rsh_many_single[MOST][2][9];
static const float *from_rows[9], *to_rows[9];

// The frames differ by tilts of 0 to .4, and some of them are equal.
static void rsh_many_make_frames(uint32_t *seed, int count) {
    for (int i = 0; i < count; i++) {
        float b = i % 5 ? 0.4f * noise(seed) : 0.0f, c = cosf(b), s = sinf(b);
        const float tilt[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
        noise_rotation(seed, rsh_many_single[i][0]);
        rsh_noise_multiply(tilt, rsh_many_single[i][0], rsh_many_single[i][1]);
        for (int e = 0; e < 9; e++) {
            rsh_many_from[e][i] = rsh_many_single[i][0][e];
            rsh_many_to[e][i] = rsh_many_single[i][1][e];
        }
    }
    for (int e = 0; e < 9; e++) from_rows[e] = rsh_many_from[e], to_rows[e] = rsh_many_to[e];
}

static void rsh_many_fill(uint32_t *seed, int count) {
    for (int i = 0; i < CHANNELS * N * count; i++) rsh_many_in[i] = noise(seed);
    rsh_many_out[CHANNELS * N * count] = 7.0f;
}

static void rsh_many_take(const float *a, int count, int i, float *v) {
    for (int k = 0; k < CHANNELS * N; k++) v[k] = a[k * count + i];
}

static const int rsh_many_counts[] = {1, 4, 15, 16, 17, 32, MOST};

static void rotations_equal_single_ones(void **state) {
    (void)state;
    uint32_t seed = 21;
    for (size_t j = 0; j < sizeof rsh_many_counts / sizeof *rsh_many_counts; j++)
        for (int kind = 0; kind < 2; kind++) {
            int count = rsh_many_counts[j];
            rsh_many_make_frames(&seed, count);
            rsh_many_fill(&seed, count);
            if (kind)
                assert_true(rsh_rotate_many(ORDER, CHANNELS, (size_t)count, from_rows, rsh_many_in,
                                            rsh_many_out));
            else
                assert_true(rsh_rotate_taylor_many(RSH_TAYLOR_1_5, ORDER, CHANNELS, (size_t)count,
                                                   from_rows, rsh_many_in, rsh_many_out));
            assert_true(rsh_many_out[CHANNELS * N * count] == 7.0f);
            for (int i = 0; i < count; i++) {
                float v[CHANNELS * N], a[CHANNELS * N], b[CHANNELS * N];
                rsh_many_take(rsh_many_in, count, i, v);
                rsh_many_take(rsh_many_out, count, i, b);
                if (kind)
                    rsh_rotate(ORDER, CHANNELS, rsh_many_single[i][0], v, a);
                else
                    rsh_rotate_taylor(RSH_TAYLOR_1_5, ORDER, CHANNELS, rsh_many_single[i][0], v, a);
                // The series at large angles makes vectors forty times as long.
                assert_true(rsh_noise_distance(CHANNELS * N, a, b) < (kind ? 3e-5 : 2e-3));
            }
        }
}

static void alignments_equal_single_ones(void **state) {
    (void)state;
    uint32_t seed = 22;
    const float limits[] = {0.0f, 0.2f, 4.0f};
    for (size_t j = 0; j < sizeof rsh_many_counts / sizeof *rsh_many_counts; j++)
        for (int variant = 0; variant < 12; variant++) {
            int count = rsh_many_counts[j];
            rsh_basis basis = variant & 1 ? RSH_HEMISPHERE : RSH_SPHERE;
            float limit = limits[variant / 4], a[CHANNELS * N], b[CHANNELS * N], v[CHANNELS * N];
            bool transposed = variant & 2;
            rsh_many_make_frames(&seed, count);
            rsh_many_fill(&seed, count);
            assert_true((transposed ? rsh_align_transposed_many : rsh_align_many)(
                &(rsh_alignments){basis, from_rows, to_rows, limit}, ORDER, CHANNELS, (size_t)count,
                rsh_many_in, rsh_many_out));
            assert_true(rsh_many_out[CHANNELS * N * count] == 7.0f);
            for (int i = 0; i < count; i++) {
                rsh_many_take(rsh_many_in, count, i, v);
                rsh_many_take(rsh_many_out, count, i, b);
                const rsh_alignment one = {basis, rsh_many_single[i][0], rsh_many_single[i][1],
                                           limit};
                (transposed ? rsh_align_transposed : rsh_align)(&one, ORDER, CHANNELS, v, a);
                assert_true(rsh_noise_distance(CHANNELS * N, a, b) < 5e-5);
            }
        }
}

// A record gives equal bits alone, among others, and in place.
static void neighbours_do_not_matter(void **state) {
    (void)state;
    uint32_t seed = 23;
    rsh_many_make_frames(&seed, MOST);
    rsh_many_fill(&seed, MOST);
    const rsh_alignments all = {RSH_HEMISPHERE, from_rows, to_rows, 0.2f};
    assert_true(rsh_align_many(&all, ORDER, CHANNELS, MOST, rsh_many_in, rsh_many_out));
    for (int i = 0; i < MOST; i++) {
        float v[CHANNELS * N], a[CHANNELS * N];
        const float *f[9], *t[9];
        for (int e = 0; e < 9; e++) f[e] = rsh_many_from[e] + i, t[e] = rsh_many_to[e] + i;
        rsh_many_take(rsh_many_in, MOST, i, v);
        rsh_many_take(rsh_many_out, MOST, i, a);
        const rsh_alignments one = {RSH_HEMISPHERE, f, t, 0.2f};
        assert_true(rsh_align_many(&one, ORDER, CHANNELS, 1, v, v));
        assert_memory_equal(v, a, sizeof v);
    }
}

static void rsh_many_bad_input_is_refused(void **state) {
    (void)state;
    uint32_t seed = 24;
    rsh_many_make_frames(&seed, MOST);
    float v[MOST] = {1, 2, 3}, w[MOST] = {7, 7, 7};
    const rsh_alignments sphere = {RSH_SPHERE, to_rows, from_rows, 0.0f};
    rsh_alignments basis = sphere;
    basis.basis = (rsh_basis)2;
    assert_false(rsh_rotate_many(0, 1, MOST, from_rows, v, w));
    assert_false(rsh_rotate_many(RSH_MAX_ORDER + 1, 1, MOST, from_rows, v, w));
    assert_false(rsh_rotate_taylor_many((rsh_taylor)9, 1, 1, MOST, from_rows, v, w));
    assert_false(rsh_align_many(&basis, 1, 1, MOST, v, w));
    assert_true(rsh_rotate_many(1, 1, 0, from_rows, v, w));
    rsh_many_from[3][MOST - 1] = NAN;
    assert_false(rsh_rotate_many(1, 1, MOST, from_rows, v, w));
    assert_false(rsh_align_many(&sphere, 1, 1, MOST, v, w));
    rsh_many_from[3][MOST - 1] = -INFINITY;
    assert_false(rsh_align_transposed_many(&sphere, 1, 1, MOST, v, w));
    for (int i = 0; i < 3; i++) assert_true(w[i] == 7.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rotations_equal_single_ones),
        cmocka_unit_test(alignments_equal_single_ones),
        cmocka_unit_test(neighbours_do_not_matter),
        cmocka_unit_test(rsh_many_bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
