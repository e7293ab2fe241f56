// SPDX-License-Identifier: Apache-2.0
// Rotation matrices of Ivanic and Ruedenberg and their derivatives.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh_noise.h"

static void rsh_ivanic_equals_the_fastest_form(void **state) {
    (void)state;
    uint32_t seed = 41;
    for (int order = 1; order <= RSH_MAX_ORDER; order++)
        for (int i = 0; i < 10; i++) {
            int n = order * order;
            float v[2 * MAX], a[2 * MAX], b[2 * MAX], r[9];
            for (int c = 0; c < 2; c++) noise_unit(&seed, n, v + c * n);
            noise_rotation(&seed, r);
            if (i == 0) memcpy(r, (float[9]){1, 0, 0, 0, -1, 0, 0, 0, -1}, sizeof r);
            assert_true(rsh_rotate(order, 2, r, v, a));
            assert_true(rsh_rotate_ivanic(order, 2, r, v, b));
            for (int c = 0; c < 2; c++)
                assert_true(rsh_noise_distance(n, a + c * n, b + c * n) < 3e-6);
            assert_true(rsh_rotate_ivanic(order, 2, r, v, v));
            assert_memory_equal(v, b, sizeof(float) * 2 * (size_t)n);
        }
}

// The values are those of figures 5.2 and 5.3 of [K05], three digits each.
static void derivatives_equal_the_printed_ones(void **state) {
    (void)state;
    float blocks[3 * RSH_MAX_BLOCKS];
    const float first[49] = {0, 1.22f,  0, 0, 0, 0, 0, -1.22f, 0, 1.58f,  0, 0, 0, 0, 0, -1.58f,
                             0, 0,      0, 0, 0, 0, 0, 0,      0, -2.45f, 0, 0, 0, 0, 0, 2.45f,
                             0, -1.58f, 0, 0, 0, 0, 0, 1.58f,  0, -1.22f, 0, 0, 0, 0, 0, 1.22f,
                             0};
    const float second[49] = {-1.5f, 0, 1.94f, 0, 0,     0, 0,     0, -4, 0, 0,     0, 0,     0,
                              1.94f, 0, -2.5f, 0, 0,     0, 0,     0, 0,  0, -6,    0, 3.87f, 0,
                              0,     0, 0,     0, -8.5f, 0, 1.94f, 0, 0,  0, 3.87f, 0, -4,    0,
                              0,     0, 0,     0, 1.94f, 0, -1.5f};
    int size = rsh_blocks_size(4);
    assert_int_equal(size, 84);
    assert_true(rsh_rotation_y_derivatives(4, 0.0f, 2, blocks));
    for (int i = 0; i < 49; i++) {
        assert_true(fabsf(blocks[size + 35 + i] - first[i]) < 0.006f);
        assert_true(fabsf(blocks[2 * size + 35 + i] - second[i]) < 0.006f);
    }
}

// Each derivative applied is the difference quotient of the one before, and the zeroth is the
// rotation. Central differences err by h^2 / 6 times the derivative two higher, about l^2.
static void derivatives_equal_differences(void **state) {
    (void)state;
    enum { ORDER = 6, N = ORDER * ORDER, HIGHEST = 3 };
    static float at[3][(HIGHEST + 1) * RSH_MAX_BLOCKS];
    const float beta = 0.7f, h = 0.01f;
    uint32_t seed = 42;
    float v[N], a[N], b[N], c[N];
    int size = rsh_blocks_size(ORDER);
    noise_unit(&seed, N, v);
    for (int i = 0; i < 3; i++)
        assert_true(rsh_rotation_y_derivatives(ORDER, beta + h * (float)(i - 1), HIGHEST, at[i]));
    rsh_rotate_y(ORDER, 1, beta, v, a);
    rsh_apply_blocks(ORDER, 1, at[1], v, b);
    assert_true(rsh_noise_distance(N, a, b) < 3e-6);
    for (int k = 0; k < HIGHEST; k++) {
        rsh_apply_blocks(ORDER, 1, at[0] + k * size, v, a);
        rsh_apply_blocks(ORDER, 1, at[2] + k * size, v, b);
        rsh_apply_blocks(ORDER, 1, at[1] + (k + 1) * size, v, c);
        double length = 0.0;
        for (int i = 0; i < N; i++) {
            a[i] = (b[i] - a[i]) / (2 * h);
            length += (double)c[i] * c[i];
        }
        assert_true(rsh_noise_distance(N, a, c) < 2e-3 * sqrt(length));
    }
}

// Matrices that are no rotation give values without meaning, but do not overflow.
static void any_matrix_gives_finite_values(void **state) {
    (void)state;
    static float blocks[RSH_MAX_BLOCKS];
    const float size[4] = {1.0f, 1.5f, 1e3f, 1e9f};
    for (int i = 0; i < 4 * 512; i++) {
        float r[9];
        for (int e = 0; e < 9; e++) r[e] = i / 4 >> e & 1 ? -size[i % 4] : size[i % 4];
        assert_true(rsh_rotation_blocks(RSH_MAX_ORDER, r, blocks));
        float most = 0.0f;
        for (int k = 0; k < RSH_MAX_BLOCKS; k++) {
            assert_true(isfinite(blocks[k]));
            most = fmaxf(most, fabsf(blocks[k]));
        }
        assert_true(most < 1e20f);
    }
}

static void rsh_ivanic_bad_input_is_refused(void **state) {
    (void)state;
    float v[1] = {1}, out[1] = {7};
    const float r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, bad[9] = {1, 0, 0, 0, INFINITY, 0, 0, 0, 1};
    for (int order = 0; order <= RSH_MAX_ORDER + 1; order += RSH_MAX_ORDER + 1) {
        assert_int_equal(rsh_blocks_size(order), 0);
        assert_false(rsh_rotate_ivanic(order, 1, r, v, out));
        assert_false(rsh_rotation_blocks(order, r, out));
        assert_false(rsh_apply_blocks(order, 1, v, v, out));
        assert_false(rsh_rotation_y_derivatives(order, 0.0f, 1, out));
    }
    assert_false(rsh_rotate_ivanic(1, 1, bad, v, out));
    assert_false(rsh_rotation_y_derivatives(1, NAN, 0, out));
    assert_false(rsh_rotation_y_derivatives(1, 0.0f, -1, out));
    assert_true(out[0] == 7.0f);
    assert_true(rsh_rotation_y_derivatives(1, 0.3f, 0, out) && out[0] == 1.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rsh_ivanic_equals_the_fastest_form),
        cmocka_unit_test(derivatives_equal_the_printed_ones),
        cmocka_unit_test(derivatives_equal_differences),
        cmocka_unit_test(any_matrix_gives_finite_values),
        cmocka_unit_test(rsh_ivanic_bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
