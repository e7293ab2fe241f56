// SPDX-License-Identifier: Apache-2.0
// Conversion to other conventions and back: known harmonics of degree 1 and 2.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh_noise.h"

// The function x has coefficient sqrt(4 pi / 3) here; elsewhere 1 over what their harmonic of
// (1, 1) is times x, written out by hand.
static void a_known_function_converts(void **state) {
    (void)state;
    const double pi = acos(-1.0);
    const float in[4] = {0, 0, 0, (float)sqrt(4 * pi / 3)};
    const struct {
        rsh_convention convention;
        int index;
        double value;
    } cases[] = {
        {{RSH_ORTHONORMAL, false, RSH_BY_DEGREE}, 3, sqrt(4 * pi / 3)},
        {{RSH_ORTHONORMAL, true, RSH_BY_DEGREE}, 3, -sqrt(4 * pi / 3)},
        {{RSH_FOUR_PI, false, RSH_BY_DEGREE}, 3, 1 / sqrt(3)},
        {{RSH_SCHMIDT, false, RSH_BY_DEGREE}, 3, 1},
        {{RSH_UNNORMALISED, false, RSH_BY_DEGREE}, 3, 1},
        {{RSH_UNNORMALISED, true, RSH_COSINE_SINE}, 3, -1},
        {{RSH_FOUR_PI, false, RSH_COSINE_SINE}, 3, 1 / sqrt(3)},
        // x = (Y_1^-1 - Y_1^1) sqrt(2 pi / 3) with phase.
        {{RSH_ORTHONORMAL, true, RSH_COMPLEX}, 6, -sqrt(2 * pi / 3)},
        {{RSH_ORTHONORMAL, true, RSH_COMPLEX}, 2, sqrt(2 * pi / 3)},
        {{RSH_ORTHONORMAL, false, RSH_COMPLEX}, 2, sqrt(2 * pi / 3)},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        float out[8];
        assert_true(rsh_export(&cases[i].convention, 2, 1, in, out));
        assert_true(fabs((double)out[cases[i].index] - cases[i].value) < 1e-6);
    }
}

static void converting_there_and_back_changes_nothing(void **state) {
    (void)state;
    uint32_t seed = 51;
    for (int order = 1; order <= RSH_MAX_ORDER; order++)
        for (int kind = 0; kind < 24; kind++) {
            const rsh_convention c = {(rsh_normalisation)(kind % 4), kind / 4 % 2,
                                      (rsh_layout)(kind / 8)};
            int n = order * order, size = 2 * rsh_convention_size(order, c.layout);
            float v[2 * MAX], there[4 * MAX + 1], back[2 * MAX];
            noise_unit(&seed, 2 * n, v);
            there[size] = 7.0f;
            assert_true(rsh_export(&c, order, 2, v, there));
            assert_true(there[size] == 7.0f);
            assert_true(rsh_import(&c, order, 2, there, back));
            assert_true(rsh_noise_distance(2 * n, v, back) < 3e-7);
        }
}

static void the_phase_agrees_with_the_short_call(void **state) {
    (void)state;
    uint32_t seed = 52;
    float v[MAX], a[MAX], b[MAX];
    noise_unit(&seed, MAX, v);
    assert_true(rsh_export(&(rsh_convention){.phase = true}, RSH_MAX_ORDER, 1, v, a));
    assert_true(rsh_flip_phase(RSH_MAX_ORDER, 1, v, b));
    assert_memory_equal(a, b, sizeof a);
}

static void rsh_convention_bad_input_is_refused(void **state) {
    (void)state;
    float v[2] = {1}, out[2] = {7};
    const rsh_convention good = {0}, norm = {.norm = (rsh_normalisation)4},
                         layout = {.layout = (rsh_layout)-1};
    assert_false(rsh_export(&good, 0, 1, v, out) || rsh_import(&good, 17, 1, v, out));
    assert_false(rsh_export(&norm, 1, 1, v, out) || rsh_import(&norm, 1, 1, v, out));
    assert_false(rsh_export(&layout, 1, 1, v, out) || rsh_import(&layout, 1, 1, v, out));
    assert_int_equal(rsh_convention_size(0, RSH_COMPLEX), 0);
    assert_true(out[0] == 7.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_known_function_converts),
        cmocka_unit_test(converting_there_and_back_changes_nothing),
        cmocka_unit_test(the_phase_agrees_with_the_short_call),
        cmocka_unit_test(rsh_convention_bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
