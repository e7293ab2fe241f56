// SPDX-License-Identifier: Apache-2.0
// The form of Kautz et al. against the fastest one, of which it is independent except for the
// angles.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh_noise.h"

static void rsh_zxzxz_equals_the_fastest_form(void **state) {
    (void)state;
    uint32_t seed = 31;
    for (int order = 1; order <= RSH_MAX_ORDER; order++)
        for (int i = 0; i < 10; i++) {
            int n = order * order;
            float v[3 * MAX], a[3 * MAX], b[3 * MAX], r[9];
            for (int c = 0; c < 3; c++) noise_unit(&seed, n, v + c * n);
            noise_rotation(&seed, r);
            if (i == 0) memcpy(r, (float[9]){1, 0, 0, 0, -1, 0, 0, 0, -1}, sizeof r);
            if (i == 1) memcpy(r, (float[9]){0, -1, 0, 1, 0, 0, 0, 0, 1}, sizeof r);
            assert_true(rsh_rotate(order, 3, r, v, a));
            assert_true(rsh_rotate_zxzxz(order, 3, r, v, b));
            for (int c = 0; c < 3; c++)
                assert_true(rsh_noise_distance(n, a + c * n, b + c * n) < 3e-6);
            assert_true(rsh_rotate_zxzxz(order, 3, r, v, v));
            assert_memory_equal(v, b, sizeof(float) * 3 * (size_t)n);
        }
}

static void rsh_zxzxz_bad_input_is_refused(void **state) {
    (void)state;
    float v[1] = {1}, out[1] = {7};
    const float r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, bad[9] = {1, 0, 0, 0, NAN, 0, 0, 0, 1};
    assert_false(rsh_rotate_zxzxz(0, 1, r, v, out));
    assert_false(rsh_rotate_zxzxz(RSH_MAX_ORDER + 1, 1, r, v, out));
    assert_false(rsh_rotate_zxzxz(1, 1, bad, v, out));
    assert_true(out[0] == 7.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rsh_zxzxz_equals_the_fastest_form),
        cmocka_unit_test(rsh_zxzxz_bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
