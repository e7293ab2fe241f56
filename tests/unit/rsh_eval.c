// SPDX-License-Identifier: Apache-2.0
// Harmonics: values, orthonormality by Gauss quadrature, projection and products.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh/rsh_kernel.h"
#include "rsh_quadrature.h"

// The Gram matrix of order 12 is the identity. Float evaluation errs by about 1e-6 of the largest
// value (sqrt((2 l + 1) / 2 pi) = 1.9), the sum of 2000 terms by less.
static void basis_is_orthonormal(void **state) {
    (void)state;
    enum { N = 12, K = N * N };
    static double gram[K][K];
    for (int basis = RSH_SPHERE; basis <= RSH_HEMISPHERE; basis++) {
        struct rsh_quadrature_quadrature q = quadrature_make(basis == RSH_HEMISPHERE, 2 * N);
        memset(gram, 0, sizeof gram);
        for (int i = 0; i < q.count; i++) {
            float y[K];
            assert_true(rsh_eval((rsh_basis)basis, N, q.w[i], y));
            for (int a = 0; a < K; a++)
                for (int b = 0; b < K; b++) gram[a][b] += q.weight[i] * (double)y[a] * (double)y[b];
        }
        for (int a = 0; a < K; a++)
            for (int b = 0; b < K; b++) assert_true(fabs(gram[a][b] - (a == b)) < 5e-6);
    }
}

static void band_one_is_geometric(void **state) {
    (void)state;
    const float w[3] = {0.48f, -0.6f, 0.64f}, k = sqrtf(0.75f / 3.14159265f);
    float y[4];
    assert_true(rsh_eval(RSH_SPHERE, 2, w, y));
    assert_true(fabsf(y[0] - 0.28209479f) < 1e-6f && fabsf(y[1] - k * w[1]) < 1e-6f);
    assert_true(fabsf(y[2] - k * w[2]) < 1e-6f && fabsf(y[3] - k * w[0]) < 1e-6f);
}

// Below the horizon the hemisphere's value is that of the horizon.
static void horizon_is_clamped(void **state) {
    (void)state;
    float at[25], below[25];
    assert_true(rsh_eval(RSH_HEMISPHERE, 5, (float[3]){0.6f, 0.8f, 0.0f}, at));
    assert_true(rsh_eval(RSH_HEMISPHERE, 5, (float[3]){0.36f, 0.48f, -0.8f}, below));
    assert_memory_equal(at, below, sizeof at);
}

static void unknown_orders_and_bases_are_refused(void **state) {
    (void)state;
    const float w[3] = {0, 0, 1}, zero = 0;
    const rsh_samples one = {1, &zero, &zero, &zero, &zero, &zero, &zero};
    float y[4] = {7, 7, 7, 7};
    const int orders[] = {-1, 0, RSH_MAX_ORDER + 1, INT32_MAX};
    for (int i = 0; i < 4; i++) {
        assert_false(rsh_eval(RSH_SPHERE, orders[i], w, y));
        assert_false(rsh_eval_many(RSH_SPHERE, orders[i], 1, &zero, &zero, &zero, y));
        assert_false(rsh_project(RSH_SPHERE, orders[i], &one, y));
        assert_false(rsh_dot3(orders[i], 1, y, y, y));
    }
    for (int basis = -1; basis < 3; basis += 3) {
        const rsh_basis bad = (rsh_basis)basis;
        assert_false(rsh_eval(bad, 1, w, y));
        assert_false(rsh_eval_many(bad, 1, 1, &zero, &zero, &zero, y));
        assert_false(rsh_project(bad, 1, &one, y));
    }
    for (int i = 0; i < 4; i++) assert_true(y[i] == 7.0f);
}

// Every table against the plain definitions, for all orders, tails and channels. Sums of 77 terms
// up to 1.5 * 2.3 in magnitude: 1e-4 is twenty times their rounding.
static void kernels_equal_the_plain_twin(void **state) {
    (void)state;
    enum { COUNT = 77, MAX = RSH_MAX_COEFFICIENTS };
    static float d[3][COUNT], v[3][COUNT], many[2][MAX * COUNT + 1];
    for (int i = 0; i < COUNT; i++) {
        float z = 1.0f - 2.0f * ((float)i + 0.5f) / COUNT, phi = 2.4f * (float)i;
        d[0][i] = sqrtf(1.0f - z * z) * cosf(phi);
        d[1][i] = sqrtf(1.0f - z * z) * sinf(phi);
        d[2][i] = z;
        for (int c = 0; c < 3; c++) v[c][i] = sinf((float)(i * (c + 1))) + 0.5f;
    }
    const float *const rgb[3] = {v[0], v[1], v[2]}, *const grey[3] = {v[0], NULL, NULL};
    const struct rsh_kernels *plain = &rsh_kernels_plain;
    for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++)
        for (int n = 1; n <= RSH_MAX_ORDER; n++)
            for (int variant = 0; variant < 4; variant++) {
                rsh_basis basis = variant & 1 ? RSH_HEMISPHERE : RSH_SPHERE;
                const float *const *value = variant & 2 ? rgb : grey;
                size_t nn = (size_t)(n * n), count = (size_t)(COUNT - n),
                       size = (variant & 2 ? 3 : 1) * nn;
                float a[3 * MAX + 1], b[3 * MAX + 1];
                many[0][nn * count] = many[1][nn * count] = a[size] = b[size] = 7.0f;
                plain->eval_many(basis, n, count, d[0], d[1], d[2], many[0]);
                (*k)->eval_many(basis, n, count, d[0], d[1], d[2], many[1]);
                for (size_t i = 0; i <= nn * count; i++)
                    assert_true(fabsf(many[0][i] - many[1][i]) < 8e-6f);
                for (size_t i = 0; i < size; i++) a[i] = b[i] = 1.0f;
                plain->project(basis, n, count, (const float *const[3]){d[0], d[1], d[2]}, value,
                               a);
                (*k)->project(basis, n, count, (const float *const[3]){d[0], d[1], d[2]}, value, b);
                for (size_t i = 0; i <= size; i++) assert_true(fabsf(a[i] - b[i]) < 1e-4f);
                plain->accumulate(count, nn, many[0], value, a);
                (*k)->accumulate(count, nn, many[0], value, b);
                for (size_t i = 0; i <= size; i++) assert_true(fabsf(a[i] - b[i]) < 2e-4f);
            }
}

static void products_take_one_or_three_channels(void **state) {
    (void)state;
    const float a[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    const float b[12] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 2, 0};
    float out[3];
    assert_true(rsh_dot3(2, 3, a, b, out));
    assert_true(out[0] == 5.0f && out[1] == 6.0f && out[2] == 22.0f);
    assert_false(rsh_dot3(2, 2, a, b, out) || rsh_dot3(2, 0, a, b, out) ||
                 rsh_dot3(2, 4, a, b, out));
    assert_true(rsh_dot3(2, 1, a, b, out));
    assert_true(out[0] == 5.0f && out[1] == 2.0f && out[2] == 6.0f);
}

static void dot_products_equal_the_plain_twin(void **state) {
    (void)state;
    enum { MAX = RSH_MAX_COEFFICIENTS };
    float a[3 * MAX], b[3 * MAX], x[3], y[3];
    for (int i = 0; i < 3 * MAX; i++) {
        a[i] = sinf((float)i);
        b[i] = cosf(1.7f * (float)i);
    }
    for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++)
        for (int n = 1; n <= MAX; n++)
            for (int step = 0; step <= n; step += n) {
                rsh_kernels_plain.dot3(n, step, a, b, x);
                (*k)->dot3(n, step, a, b, y);
                for (int c = 0; c < 3; c++) assert_true(fabsf(x[c] - y[c]) < 2e-5f);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(basis_is_orthonormal),
        cmocka_unit_test(band_one_is_geometric),
        cmocka_unit_test(horizon_is_clamped),
        cmocka_unit_test(unknown_orders_and_bases_are_refused),
        cmocka_unit_test(kernels_equal_the_plain_twin),
        cmocka_unit_test(products_take_one_or_three_channels),
        cmocka_unit_test(dot_products_equal_the_plain_twin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
