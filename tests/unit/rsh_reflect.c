// SPDX-License-Identifier: Apache-2.0
// To rotate the BRDF gives the same reflected light as to rotate the record with its derivatives.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh_noise.h"

enum { ORDER = 9, N = ORDER * ORDER };

static void either_side_may_rotate(void **state) {
    (void)state;
    uint32_t seed = 61;
    for (int i = 0; i < 80; i++) {
        float record[9 * N], rotated[9 * N], brdf[3 * N], from[9], to[9], tilt[9], out[3];
        float b = 0.3f * noise(&seed), c = cosf(b), s = sinf(b);
        for (int k = 0; k < 9; k++) noise_unit(&seed, N, record + k * N);
        for (int k = 0; k < 3; k++) noise_unit(&seed, N, brdf + k * N);
        noise_rotation(&seed, from);
        memcpy(tilt, (float[9]){c, 0, s, 0, 1, 0, -s, 0, c}, sizeof tilt);
        rsh_noise_multiply(tilt, from, to);
        rsh_reflection r = {.alignment = {.basis = i & 1 ? RSH_HEMISPHERE : RSH_SPHERE,
                                          .from = from,
                                          .to = to,
                                          .beta_limit = i & 2 ? 0.2f : 0.0f},
                            .order = ORDER,
                            .value = record,
                            .d_dx = record + 3 * N,
                            .d_dy = i & 4 ? NULL : record + 6 * N,
                            .x = 0.3f,
                            .y = -0.2f,
                            .brdf = brdf,
                            .brdf_channels = i & 8 ? 1 : 3};
        assert_true(rsh_reflect(&r, out));
        rsh_align(&r.alignment, ORDER, 9, record, rotated);
        for (int k = 0; k < 3; k++) {
            const float *f = brdf + (r.brdf_channels == 1 ? 0 : k * N), *v = rotated + k * N;
            double want = 0.0;
            for (int j = 0; j < N; j++)
                want += (double)f[j] * ((double)v[j] + 0.3 * (double)v[3 * N + j] -
                                        (r.d_dy ? 0.2 * (double)v[6 * N + j] : 0.0));
            assert_true(fabs(want - (double)out[k]) < 8e-6);
        }
    }
}

static void rsh_reflect_bad_input_is_refused(void **state) {
    (void)state;
    const float frame[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, bad[9] = {NAN}, v[3] = {1, 2, 3};
    float out[3] = {7, 7, 7};
    rsh_reflection good = {.alignment = {.from = frame, .to = frame},
                           .order = 1,
                           .value = v,
                           .brdf = v,
                           .brdf_channels = 1};
    rsh_reflection order = good, channels = good, matrix = good, basis = good;
    order.order = 0;
    channels.brdf_channels = 2;
    matrix.alignment.to = bad;
    basis.alignment.basis = (rsh_basis)2;
    assert_false(rsh_reflect(&order, out) || rsh_reflect(&channels, out));
    assert_false(rsh_reflect(&matrix, out) || rsh_reflect(&basis, out));
    assert_true(out[0] == 7.0f && out[1] == 7.0f && out[2] == 7.0f);
    assert_true(rsh_reflect(&good, out) && out[0] == 1.0f && out[2] == 3.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(either_side_may_rotate),
        cmocka_unit_test(rsh_reflect_bad_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
