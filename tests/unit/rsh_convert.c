// SPDX-License-Identifier: Apache-2.0
// Extension and restriction between hemisphere and sphere, and their transposes: every kernel's
// converters, of one record and of many, against plain C.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "rsh/rsh_kernel.h"
#include "rsh_noise.h"

enum { STRIDE = RSH_MAX_WIDTH + 3 };

struct rsh_convert_conversion {
    const struct rsh_rows *rows;
    bool transposed;
    int bands[2];  // out and in
};

static struct rsh_convert_conversion conversion_make(int n, int variant) {
    bool up = (variant & 1) == (variant >> 1);
    int larger = rsh_sphere_order(n);
    return (struct rsh_convert_conversion){variant & 1 ? &rsh_restriction : &rsh_extension[n - 1],
                                           variant & 2,
                                           {up ? larger : n, up ? n : larger}};
}

// Records of unit length. Neither converter writes past its output.
static void rsh_convert_compare(const struct rsh_kernels *k, const struct rsh_convert_conversion *c,
                                uint32_t *seed) {
    static float many[MAX * STRIDE], out[MAX * RSH_MAX_WIDTH + 1];
    static float in[STRIDE][MAX], want[MAX + 1], got[MAX + 1];
    int out_size = c->bands[0] * c->bands[0], in_size = c->bands[1] * c->bands[1];
    const size_t strides[2] = {RSH_MAX_WIDTH, STRIDE}, end = (size_t)out_size * RSH_MAX_WIDTH;
    for (int i = 0; i < STRIDE; i++) {
        noise_unit(seed, in_size, in[i]);
        for (int j = 0; j < in_size; j++) many[j * STRIDE + i] = in[i][j];
    }
    got[out_size] = out[end] = 7.0f;
    k->convert_many(c->rows, c->transposed, c->bands, strides, many, out);
    for (int i = 0; i < k->width; i++) {
        rsh_plain_convert(c->rows, c->transposed, c->bands, in[i], want);
        for (int j = 0; j < out_size; j++) got[j] = out[j * RSH_MAX_WIDTH + i];
        assert_true(rsh_noise_distance(out_size, want, got) < 2e-6);
        k->convert(c->rows, c->transposed, c->bands, in[i], got);
        assert_true(rsh_noise_distance(out_size, want, got) < 2e-6);
    }
    assert_true(got[out_size] == 7.0f && out[end] == 7.0f);
}

static void converters_equal_the_plain_twin(void **state) {
    (void)state;
    uint32_t seed = 12;
    for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++)
        for (int n = 1; n <= RSH_MAX_ORDER; n++)
            for (int variant = 0; variant < 4; variant++) {
                const struct rsh_convert_conversion c = conversion_make(n, variant);
                rsh_convert_compare(*k, &c, &seed);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(converters_equal_the_plain_twin)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
