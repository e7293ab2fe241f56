// SPDX-License-Identifier: Apache-2.0
// Values, convolution and change of phase of functions given by harmonics.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "rsh_noise.h"
#include "rsh_quadrature.h"

enum { ORDER = 8, N = ORDER * ORDER };

static void values_are_sums(void **state) {
    (void)state;
    uint32_t seed = 1;
    float v[2 * N], w[3], out[2];
    noise_unit(&seed, N, v);
    noise_unit(&seed, N, v + N);
    noise_unit(&seed, 3, w);
    assert_true(rsh_value(RSH_SPHERE, ORDER, 2, v, w, out));
    for (int c = 0; c < 2; c++)
        assert_true(fabs((double)out[c] - rsh_noise_value(RSH_SPHERE, ORDER, v + c * N, w)) < 1e-6);
    assert_false(rsh_value(RSH_SPHERE, 0, 1, v, w, out));
    assert_false(rsh_value((rsh_basis)2, 1, 1, v, w, out));
}

// (f * k)(w) is the integral of f(u) k(u . w), with k = cos^3 over the sphere of degree 3.
static void convolution_is_an_integral(void **state) {
    (void)state;
    uint32_t seed = 2;
    static struct rsh_quadrature_quadrature up;
    up = quadrature_make(1, 24);
    float v[N], zonal[ORDER], out[N];
    double sums[ORDER] = {0};
    noise_unit(&seed, N, v);
    for (int i = 0; i < up.count; i++)
        for (int side = 0; side < 2; side++) {
            float y[MAX], w[3] = {up.w[i][0], up.w[i][1], side ? -up.w[i][2] : up.w[i][2]};
            rsh_eval(RSH_SPHERE, ORDER, w, y);
            for (int l = 0; l < ORDER; l++)
                sums[l] += up.weight[i] * pow((double)w[2], 3) * (double)y[l * (l + 1)];
        }
    for (int l = 0; l < ORDER; l++) zonal[l] = (float)sums[l];
    assert_true(rsh_convolve(ORDER, 1, zonal, v, out));
    for (int trial = 0; trial < 5; trial++) {
        float at[3];
        double integral = 0.0;
        noise_unit(&seed, 3, at);
        for (int i = 0; i < up.count; i++)
            for (int side = 0; side < 2; side++) {
                float w[3] = {up.w[i][0], up.w[i][1], side ? -up.w[i][2] : up.w[i][2]};
                double cosine = (double)w[0] * (double)at[0] + (double)w[1] * (double)at[1] +
                                (double)w[2] * (double)at[2];
                integral +=
                    up.weight[i] * pow(cosine, 3) * rsh_noise_value(RSH_SPHERE, ORDER, v, w);
            }
        assert_true(fabs(integral - rsh_noise_value(RSH_SPHERE, ORDER, out, at)) < 1e-5);
    }
    assert_false(rsh_convolve(0, 1, zonal, v, out));
}

static void the_phase_changes_the_sign_of_odd_m(void **state) {
    (void)state;
    const float v[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9}, want[9] = {1, -2, 3, -4, 5, -6, 7, -8, 9};
    float out[9];
    assert_true(rsh_flip_phase(3, 1, v, out));
    assert_memory_equal(out, want, sizeof out);
    assert_true(rsh_flip_phase(3, 1, out, out));
    assert_memory_equal(out, v, sizeof out);
    assert_false(rsh_flip_phase(RSH_MAX_ORDER + 1, 1, v, out));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_sums),
        cmocka_unit_test(convolution_is_an_integral),
        cmocka_unit_test(the_phase_changes_the_sign_of_odd_m),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
