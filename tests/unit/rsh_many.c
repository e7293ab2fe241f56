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

static float in[CHANNELS * N * MOST], out[CHANNELS * N * MOST + 1];
static float from[9][MOST], to[9][MOST], single[MOST][2][9];
static const float *from_rows[9], *to_rows[9];

// Frames that differ by tilts of 0 to .4, some of which are equal.
static void make_frames(uint32_t *seed, int count) {
    for (int i = 0; i < count; i++) {
        float b = i % 5 ? 0.4f * noise(seed) : 0.0f, c = cosf(b), s = sinf(b);
        const float tilt[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
        noise_rotation(seed, single[i][0]);
        multiply(tilt, single[i][0], single[i][1]);
        for (int e = 0; e < 9; e++) {
            from[e][i] = single[i][0][e];
            to[e][i] = single[i][1][e];
        }
    }
    for (int e = 0; e < 9; e++) from_rows[e] = from[e], to_rows[e] = to[e];
}

static void fill(uint32_t *seed, int count) {
    for (int i = 0; i < CHANNELS * N * count; i++) in[i] = noise(seed);
    out[CHANNELS * N * count] = 7.0f;
}

static void take(const float *a, int count, int i, float *v) {
    for (int k = 0; k < CHANNELS * N; k++) v[k] = a[k * count + i];
}

static const int counts[] = {1, 4, 15, 16, 17, 32, MOST};

static void rotations_equal_single_ones(void **state) {
    (void)state;
    uint32_t seed = 21;
    for (size_t j = 0; j < sizeof counts / sizeof *counts; j++)
        for (int kind = 0; kind < 2; kind++) {
            int count = counts[j];
            make_frames(&seed, count);
            fill(&seed, count);
            if (kind)
                assert_true(rsh_rotate_many(ORDER, CHANNELS, (size_t)count, from_rows, in, out));
            else
                assert_true(rsh_rotate_taylor_many(RSH_TAYLOR_1_5, ORDER, CHANNELS, (size_t)count,
                                                   from_rows, in, out));
            assert_true(out[CHANNELS * N * count] == 7.0f);
            for (int i = 0; i < count; i++) {
                float v[CHANNELS * N], a[CHANNELS * N], b[CHANNELS * N];
                take(in, count, i, v);
                take(out, count, i, b);
                if (kind)
                    rsh_rotate(ORDER, CHANNELS, single[i][0], v, a);
                else
                    rsh_rotate_taylor(RSH_TAYLOR_1_5, ORDER, CHANNELS, single[i][0], v, a);
                // The series at large angles makes vectors forty times as long.
                assert_true(distance(CHANNELS * N, a, b) < (kind ? 3e-5 : 2e-3));
            }
        }
}

static void alignments_equal_single_ones(void **state) {
    (void)state;
    uint32_t seed = 22;
    const float limits[] = {0.0f, 0.2f, 4.0f};
    for (size_t j = 0; j < sizeof counts / sizeof *counts; j++)
        for (int variant = 0; variant < 12; variant++) {
            int count = counts[j];
            rsh_basis basis = variant & 1 ? RSH_HEMISPHERE : RSH_SPHERE;
            float limit = limits[variant / 4], a[CHANNELS * N], b[CHANNELS * N], v[CHANNELS * N];
            bool transposed = variant & 2;
            make_frames(&seed, count);
            fill(&seed, count);
            assert_true((transposed ? rsh_align_transposed_many : rsh_align_many)(
                basis, ORDER, CHANNELS, (size_t)count, from_rows, to_rows, limit, in, out));
            assert_true(out[CHANNELS * N * count] == 7.0f);
            for (int i = 0; i < count; i++) {
                take(in, count, i, v);
                take(out, count, i, b);
                (transposed ? rsh_align_transposed : rsh_align)(
                    basis, ORDER, CHANNELS, single[i][0], single[i][1], limit, v, a);
                assert_true(distance(CHANNELS * N, a, b) < 5e-5);
            }
        }
}

// A record gives equal bits alone, among others, and in place.
static void neighbours_do_not_matter(void **state) {
    (void)state;
    uint32_t seed = 23;
    make_frames(&seed, MOST);
    fill(&seed, MOST);
    assert_true(
        rsh_align_many(RSH_HEMISPHERE, ORDER, CHANNELS, MOST, from_rows, to_rows, 0.2f, in, out));
    for (int i = 0; i < MOST; i++) {
        float v[CHANNELS * N], a[CHANNELS * N];
        const float *f[9], *t[9];
        for (int e = 0; e < 9; e++) f[e] = from[e] + i, t[e] = to[e] + i;
        take(in, MOST, i, v);
        take(out, MOST, i, a);
        assert_true(rsh_align_many(RSH_HEMISPHERE, ORDER, CHANNELS, 1, f, t, 0.2f, v, v));
        assert_memory_equal(v, a, sizeof v);
    }
}

static void bad_input_is_refused(void **state) {
    (void)state;
    uint32_t seed = 24;
    make_frames(&seed, MOST);
    float v[MOST] = {1, 2, 3}, w[MOST] = {7, 7, 7};
    assert_false(rsh_rotate_many(0, 1, MOST, from_rows, v, w));
    assert_false(rsh_rotate_many(RSH_MAX_ORDER + 1, 1, MOST, from_rows, v, w));
    assert_false(rsh_rotate_taylor_many((rsh_taylor)9, 1, 1, MOST, from_rows, v, w));
    assert_false(rsh_align_many((rsh_basis)2, 1, 1, MOST, to_rows, from_rows, 0.0f, v, w));
    assert_true(rsh_rotate_many(1, 1, 0, from_rows, v, w));
    from[3][MOST - 1] = NAN;
    assert_false(rsh_rotate_many(1, 1, MOST, from_rows, v, w));
    assert_false(rsh_align_many(RSH_SPHERE, 1, 1, MOST, to_rows, from_rows, 0.0f, v, w));
    from[3][MOST - 1] = -INFINITY;
    assert_false(rsh_align_transposed_many(RSH_SPHERE, 1, 1, MOST, to_rows, from_rows, 0.0f, v, w));
    for (int i = 0; i < 3; i++) assert_true(w[i] == 7.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rotations_equal_single_ones),
        cmocka_unit_test(alignments_equal_single_ones),
        cmocka_unit_test(neighbours_do_not_matter),
        cmocka_unit_test(bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
