// SPDX-License-Identifier: Apache-2.0
// Gauss-Legendre rules integrate polynomials up to degree 2 n - 1.
#include "brdf/brdf_quadrature.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void quadrature_integrates_powers_exactly(void **state) {
    (void)state;
    for (int n = 1; n <= QUADRATURE_MAX; n++) {
        struct quadrature rule;
        brdf_quadrature_gauss(&rule, n);
        assert_int_equal(rule.count, n);
        for (int degree = 0; degree<2 * n; degree += n> 8 ? 7 : 1) {
            double sum = 0.0;
            for (int i = 0; i < n; i++) sum += rule.weight[i] * pow(rule.x[i], degree);
            assert_true(fabs(sum - 1.0 / (degree + 1)) < 1e-13);
        }
        for (int i = 1; i < n; i++) assert_true(rule.x[i] > rule.x[i - 1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(quadrature_integrates_powers_exactly)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
