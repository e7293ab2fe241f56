// SPDX-License-Identifier: Apache-2.0
// Rotation of harmonics. A rotated function is checked by its values: that is exact and needs no
// second implementation of the rotation.
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
#include "rsh_quadrature.h"
#include "rsh_rotations.h"

static struct rsh_rotation rotation_of_angles(enum rsh_method method, float alpha, float beta,
                                              float gamma) {
    return (struct rsh_rotation){method,     beta,       cosf(alpha), sinf(alpha),
                                 cosf(beta), sinf(beta), cosf(gamma), sinf(gamma)};
}

// A unit vector's function is at most order / sqrt(4 pi) large, so 2e-5 is 5e-6 of that at order
// 16; float evaluation alone errs by a third of it.
static void rotation_moves_the_function(void **state) {
    (void)state;
    uint32_t seed = 1;
    for (int order = 1; order <= RSH_MAX_ORDER; order++)
        for (int i = 0; i < 20; i++) {
            float v[MAX], out[MAX], r[9], back[9];
            noise_unit(&seed, order * order, v);
            noise_rotation(&seed, r);
            if (i == 0) memcpy(r, (float[9]){-1, 0, 0, 0, 1, 0, 0, 0, -1}, sizeof r);
            if (i == 1) memcpy(r, (float[9]){0, -1, 0, 1, 0, 0, 0, 0, 1}, sizeof r);
            transpose(r, back);
            assert_true(rsh_rotate(order, 1, r, v, out));
            for (int k = 0; k < 10; k++) {
                float w[3], u[3];
                noise_unit(&seed, 3, w);
                rsh_noise_apply(back, w, u);
                double error = rsh_noise_value(RSH_SPHERE, order, out, w) -
                               rsh_noise_value(RSH_SPHERE, order, v, u);
                assert_true(fabs(error) < 2e-5);
            }
        }
}

// The values are those of the package spherical in double, for a unit vector of order 16 by all
// exact forms.
static void forms_equal_wigner_matrices(void **state) {
    (void)state;
    bool (*const forms[])(int, int, const float *, const float *, float *) = {
        rsh_rotate, rsh_rotate_pinchon_hoggan, rsh_rotate_zxzxz, rsh_rotate_ivanic};
    float v[MAX], out[MAX], length = 0.0f;
    for (int k = 0; k < MAX; k++) {
        v[k] = sinf((float)(k + 1));
        length += v[k] * v[k];
    }
    for (int k = 0; k < MAX; k++) v[k] /= sqrtf(length);
    for (size_t i = 0; i < sizeof reference_rotations / sizeof *reference_rotations; i++)
        for (size_t f = 0; f < sizeof forms / sizeof *forms; f++) {
            double square = 0.0;
            assert_true(forms[f](RSH_MAX_ORDER, 1, reference_rotations[i].r, v, out));
            for (int k = 0; k < MAX; k++) {
                double d = (double)out[k] - reference_rotations[i].rotated[k];
                square += d * d;
            }
            assert_true(sqrt(square) < 3e-6);
        }
}

// Rotating is projecting the rotated function, by a quadrature that is exact for it.
static void rotation_equals_projection(void **state) {
    (void)state;
    enum { ORDER = 12, N = ORDER * ORDER };
    static struct rsh_quadrature_quadrature q;
    q = quadrature_make(0, 2 * ORDER);
    uint32_t seed = 7;
    for (int round = 0; round < 3; round++) {
        float v[N], out[N], projected[N], r[9], back[9];
        double sum[N] = {0};
        noise_unit(&seed, N, v);
        noise_rotation(&seed, r);
        transpose(r, back);
        for (int i = 0; i < q.count; i++) {
            float y[N], w[3];
            rsh_noise_apply(back, q.w[i], w);
            rsh_eval(RSH_SPHERE, ORDER, q.w[i], y);
            double l = rsh_noise_value(RSH_SPHERE, ORDER, v, w) * q.weight[i];
            for (int k = 0; k < N; k++) sum[k] += l * (double)y[k];
        }
        for (int k = 0; k < N; k++) projected[k] = (float)sum[k];
        assert_true(rsh_rotate(ORDER, 1, r, v, out));
        assert_true(rsh_noise_distance(N, out, projected) < 3e-6);
    }
}

// Largest error over all: 3e-6 of the vector's length (floats of order 16 leave about 1e-6).
static void kernels_agree(void **state) {
    (void)state;
    uint32_t seed = 2;
    for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++)
        for (int order = 1; order <= RSH_MAX_ORDER; order++)
            for (int method = RSH_METHOD_Z; method <= RSH_METHOD_EXACT; method++)
                for (int channels = 1; channels <= 3; channels++) {
                    float v[3 * MAX + 1], a[3 * MAX], b[3 * MAX + 1];
                    int n = order * order;
                    for (int c = 0; c < channels; c++) noise_unit(&seed, n, v + c * n);
                    struct rsh_rotation t = rotation_of_angles(
                        (enum rsh_method)method, 3 * noise(&seed),
                        method == RSH_METHOD_EXACT ? 3 * noise(&seed) : 0.1f, 3 * noise(&seed));
                    rsh_kernels_plain.rotate(&t, order, channels, v, a);
                    v[channels * n] = 77.0f;
                    memcpy(b, v, sizeof b);
                    (*k)->rotate(&t, order, channels, b, b);
                    for (int c = 0; c < channels; c++)
                        assert_true(rsh_noise_distance(n, a + c * n, b + c * n) < 3e-6);
                    assert_true(b[channels * n] == 77.0f);
                }
}

static void inverse_and_product_hold(void **state) {
    (void)state;
    uint32_t seed = 3;
    for (int i = 0; i < 200; i++) {
        int order = 2 + i % 15, n = order * order;
        float v[MAX], a[MAX], b[MAX], r[9], s[9], rs[9], back[9];
        noise_unit(&seed, n, v);
        noise_rotation(&seed, r);
        noise_rotation(&seed, s);
        transpose(r, back);
        rsh_rotate(order, 1, r, v, a);
        rsh_rotate(order, 1, back, a, a);
        assert_true(rsh_noise_distance(n, a, v) < 1e-5);
        rsh_noise_multiply(r, s, rs);
        rsh_rotate(order, 1, s, v, a);
        rsh_rotate(order, 1, r, a, a);
        rsh_rotate(order, 1, rs, v, b);
        assert_true(rsh_noise_distance(n, a, b) < 1e-5);
    }
}

// Around beta = 0 the first and the last rotation are uncertain one by one.
static void small_angles_are_exact(void **state) {
    (void)state;
    uint32_t seed = 4;
    for (float beta = 1e-8f; beta < 0.1f; beta *= 3.0f) {
        float v[MAX], a[MAX], b[MAX], r[9], z[9], y[9];
        float alpha = 3 * noise(&seed), c = cosf(beta), s = sinf(beta);
        const float about_y[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
        const float about_z[9] = {
            cosf(alpha), -sinf(alpha), 0, sinf(alpha), cosf(alpha), 0, 0, 0, 1};
        memcpy(z, about_z, sizeof z);
        memcpy(y, about_y, sizeof y);
        rsh_noise_multiply(z, y, r);
        noise_unit(&seed, MAX, v);
        rsh_rotate(RSH_MAX_ORDER, 1, r, v, a);
        rsh_rotate_y(RSH_MAX_ORDER, 1, beta, v, b);
        rsh_rotate_z(RSH_MAX_ORDER, 1, alpha, b, b);
        assert_true(rsh_noise_distance(MAX, a, b) < 8e-6);
    }
    float v[4] = {1, 2, 3, 4}, out[4];
    const float identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    assert_true(rsh_rotate(2, 1, identity, v, out));
    assert_memory_equal(v, out, sizeof v);
}

// Half the angle divides the error by 4, 4 and 8, and the 1.5th order has .55 of the first's
// error (errata 4).
static void taylor_errors_fall_as_stated(void **state) {
    (void)state;
    uint32_t seed = 5;
    enum { ORDER = 6, N = ORDER * ORDER };
    double error[3][2] = {{0}};
    for (int i = 0; i < 50; i++) {
        float v[N], exact[N], series[N];
        noise_unit(&seed, N, v);
        for (int half = 0; half < 2; half++) {
            float beta = half ? 0.05f : 0.1f;
            rsh_rotate_y(ORDER, 1, beta, v, exact);
            for (int kind = RSH_TAYLOR_1; kind <= RSH_TAYLOR_2; kind++) {
                assert_true(rsh_rotate_y_taylor((rsh_taylor)kind, ORDER, 1, beta, v, series));
                error[kind][half] += rsh_noise_distance(N, series, exact);
            }
        }
    }
    assert_true(fabs(error[0][0] / error[0][1] - 4.0) < 0.2);
    assert_true(fabs(error[1][0] / error[1][1] - 4.0) < 0.2);
    assert_true(fabs(error[2][0] / error[2][1] - 8.0) < 0.4);
    assert_true(fabs(error[1][1] / error[0][1] - 0.55) < 0.1);
}

// Rotates by angles and by the matrix of the same angles, exactly and by the series.
static void angles_and_matrices_agree(void **state) {
    (void)state;
    uint32_t seed = 6;
    for (int i = 0; i < 100; i++) {
        enum { ORDER = 8, N = ORDER * ORDER };
        float v[N], a[N], b[N], r[9];
        noise_unit(&seed, N, v);
        noise_rotation(&seed, r);
        rsh_zyz angles = rsh_zyz_of_matrix(r);
        assert_true(rsh_rotate_zyz(ORDER, 1, angles, v, a));
        assert_true(rsh_rotate_pinchon_hoggan(ORDER, 1, r, v, b));
        assert_true(rsh_noise_distance(N, a, b) < 1e-5);
        assert_true(rsh_rotate_taylor(RSH_TAYLOR_2, ORDER, 1, r, v, a));
        rsh_rotate_z(ORDER, 1, angles.gamma, v, b);
        rsh_rotate_y_taylor(RSH_TAYLOR_2, ORDER, 1, angles.beta, b, b);
        rsh_rotate_z(ORDER, 1, angles.alpha, b, b);
        assert_true(rsh_noise_distance(N, a, b) < 1e-3);
    }
    const float quarter[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    rsh_zyz z = rsh_zyz_of_matrix(quarter);
    assert_true(z.alpha == 0.0f && z.beta == 0.0f && fabsf(z.gamma - 1.5707963f) < 1e-6f);
}

static void rsh_rotate_bad_input_is_refused(void **state) {
    (void)state;
    float v[4] = {1, 2, 3, 4}, out[4] = {7, 7, 7, 7};
    const float identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, zero[9] = {0};
    float bad[9] = {1, 0, 0, 0, NAN, 0, 0, 0, 1};
    const rsh_alignment none = {RSH_SPHERE, identity, identity, 0.0f};
    const rsh_alignment from_bad = {RSH_SPHERE, bad, identity, 0.0f};
    const rsh_alignment to_bad = {RSH_SPHERE, identity, bad, 0.0f};
    const rsh_alignment no_basis = {(rsh_basis)2, identity, identity, 0.0f};
    const int orders[] = {-3, 0, RSH_MAX_ORDER + 1};
    for (int i = 0; i < 3; i++) {
        assert_false(rsh_rotate(orders[i], 1, identity, v, out));
        assert_false(rsh_rotate_z(orders[i], 1, 1.0f, v, out));
        assert_false(rsh_rotate_y(orders[i], 1, 1.0f, v, out));
        assert_false(rsh_rotate_y_taylor(RSH_TAYLOR_1, orders[i], 1, 1.0f, v, out));
        assert_false(rsh_rotate_taylor(RSH_TAYLOR_1, orders[i], 1, identity, v, out));
        assert_false(rsh_rotate_zyz(orders[i], 1, (rsh_zyz){0}, v, out));
        assert_false(rsh_align(&none, orders[i], 1, v, out));
    }
    assert_false(rsh_rotate(2, 1, bad, v, out));
    assert_false(rsh_align(&from_bad, 2, 1, v, out));
    assert_false(rsh_align(&no_basis, 2, 1, v, out));
    bad[4] = INFINITY;
    assert_false(rsh_align_transposed(&to_bad, 2, 1, v, out));
    assert_false(rsh_rotate_zyz(2, 1, (rsh_zyz){0, NAN, 0}, v, out));
    assert_false(rsh_rotate_taylor((rsh_taylor)3, 2, 1, identity, v, out));
    assert_false(rsh_rotate_z(2, 1, NAN, v, out));
    assert_false(rsh_rotate_y(2, 1, INFINITY, v, out));
    for (int i = 0; i < 4; i++) assert_true(out[i] == 7.0f);
    // Matrices that are no rotation give something finite.
    assert_true(rsh_rotate(2, 1, zero, v, out));
    for (int i = 0; i < 4; i++) assert_true(isfinite(out[i]));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forms_equal_wigner_matrices),
        cmocka_unit_test(rotation_equals_projection),
        cmocka_unit_test(rotation_moves_the_function),
        cmocka_unit_test(kernels_agree),
        cmocka_unit_test(inverse_and_product_hold),
        cmocka_unit_test(small_angles_are_exact),
        cmocka_unit_test(taylor_errors_fall_as_stated),
        cmocka_unit_test(angles_and_matrices_agree),
        cmocka_unit_test(rsh_rotate_bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
