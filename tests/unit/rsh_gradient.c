// SPDX-License-Identifier: Apache-2.0
// Values and derivatives of the harmonics against references in double precision.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh_reference.h"

enum { MAX = RSH_MAX_COEFFICIENTS, REFERENCES = sizeof rsh_reference / sizeof *rsh_reference };

// The unit of an error is the basis' largest value at the degree, sqrt((2 l + 1) / 4 pi), times
// sqrt 2 over the hemisphere, and l + 1 times that for derivatives. Near the pole rounding grows in
// the recurrence as l^2: measured 2.9e-6 at l = 15, under 1e-6 below l = 9.
static void values_equal_the_reference(void **state) {
    (void)state;
    for (int i = 0; i < REFERENCES; i++) {
        float y[MAX], both[MAX], dtheta[MAX], dphi[MAX];
        const float *w = rsh_reference[i].w;
        int l = rsh_reference[i].l, k = l * (l + 1) + rsh_reference[i].m;
        rsh_basis basis = rsh_reference[i].hemisphere ? RSH_HEMISPHERE : RSH_SPHERE;
        double scale = sqrt((2 * l + 1) / 12.566 * (basis == RSH_HEMISPHERE ? 2 : 1));
        assert_true(rsh_eval(basis, l + 1, w, y));
        assert_true(fabs((double)y[k] - rsh_reference[i].value) < 4e-6 * scale);
        assert_true(rsh_eval_derivatives(basis, RSH_MAX_ORDER, w, both, dtheta, dphi));
        assert_true(fabs((double)both[k] - rsh_reference[i].value) < 4e-6 * scale);
        // Towards the horizon the derivative is a small difference times a large rate.
        double rate = basis == RSH_HEMISPHERE ? sqrt((1.0 + (double)w[2]) / (double)w[2]) : 1.0;
        assert_true(fabs((double)dtheta[k] - rsh_reference[i].dtheta) <
                    4e-6 * scale * (l + 1) * rate);
        assert_true(fabs((double)dphi[k] - rsh_reference[i].dphi) < 4e-6 * scale * (l + 1));
    }
}

static void degenerate_directions_do_no_harm(void **state) {
    (void)state;
    const float w[][3] = {{0, 0, 0}, {0, 0, -1}, {1, 0, 0}, {0.6f, 0, -0.8f}, {NAN, 0, 1}};
    for (int basis = 0; basis < 2; basis++)
        for (int i = 0; i < 5; i++) {
            float y[MAX], dtheta[MAX], dphi[MAX];
            assert_true(rsh_eval((rsh_basis)basis, RSH_MAX_ORDER, w[i], y));
            assert_true(
                rsh_eval_derivatives((rsh_basis)basis, RSH_MAX_ORDER, w[i], y, dtheta, dphi));
            for (int k = 0; k < MAX && i < 4; k++)
                assert_true(isfinite(y[k]) && isfinite(dtheta[k]) && isfinite(dphi[k]));
        }
    float y[4];
    assert_false(rsh_eval_derivatives(RSH_SPHERE, 0, w[0], y, y, y));
    assert_false(rsh_eval_derivatives(RSH_SPHERE, RSH_MAX_ORDER + 1, w[0], y, y, y));
    assert_false(rsh_eval_derivatives((rsh_basis)2, 1, w[0], y, y, y));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_equal_the_reference),
        cmocka_unit_test(degenerate_directions_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
