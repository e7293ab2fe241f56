// SPDX-License-Identifier: Apache-2.0
// The kernels that take many records at once, each against the single-record twin in plain C.
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

enum { CHANNELS = 4, STRIDE = RSH_MAX_WIDTH + 3 };  // three together and one alone

static float rsh_batch_in[CHANNELS * MAX * STRIDE], rsh_batch_out[CHANNELS * MAX * STRIDE];

static struct rsh_rotations random_rotations(uint32_t *seed, enum rsh_method method) {
    struct rsh_rotations t = {.method = method};
    for (int i = 0; i < RSH_MAX_WIDTH; i++) {
        float a = 3 * noise(seed), c = 3 * noise(seed);
        float b = method == RSH_METHOD_EXACT ? 3 * noise(seed) : 0.1f * noise(seed);
        t.beta[i] = b;
        t.cos_alpha[i] = cosf(a), t.sin_alpha[i] = sinf(a);
        t.cos_beta[i] = cosf(b), t.sin_beta[i] = sinf(b);
        t.cos_gamma[i] = cosf(c), t.sin_gamma[i] = sinf(c);
    }
    return t;
}

// Returns record i of a channel, strided, as a vector.
static void rsh_batch_take(const float *from, int n, int channel, int i, float *v) {
    for (int k = 0; k < n; k++) v[k] = from[(channel * n + k) * STRIDE + i];
}

// The bound is that of the single record, 3e-6 of the vector's length.
static void rotations_equal_the_plain_twin(void **state) {
    (void)state;
    uint32_t seed = 11;
    for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++)
        for (int order = 1; order <= RSH_MAX_ORDER; order++)
            for (int method = RSH_METHOD_TAYLOR_1; method <= RSH_METHOD_EXACT; method++) {
                int n = order * order;
                struct rsh_rotations t = random_rotations(&seed, (enum rsh_method)method);
                for (int j = 0; j < CHANNELS * n * STRIDE; j++)
                    rsh_batch_out[j] = rsh_batch_in[j] = noise(&seed);
                (*k)->rotate_many(&t, order, CHANNELS, STRIDE, rsh_batch_out, rsh_batch_out);
                for (int i = 0; i < STRIDE; i++)
                    for (int c = 0; c < CHANNELS; c++) {
                        float v[MAX], a[MAX], b[MAX];
                        rsh_batch_take(rsh_batch_in, n, c, i, v);
                        rsh_batch_take(rsh_batch_out, n, c, i, b);
                        if (i >= (*k)->width) {
                            assert_memory_equal(v, b, (size_t)n * sizeof *v);
                            continue;
                        }
                        const struct rsh_rotation one = {
                            t.method,      t.beta[i],     t.cos_alpha[i], t.sin_alpha[i],
                            t.cos_beta[i], t.sin_beta[i], t.cos_gamma[i], t.sin_gamma[i]};
                        rsh_plain_rotate(&one, order, 1, v, a);
                        double length = sqrt((double)n / 3.0);
                        assert_true(rsh_noise_distance(n, a, b) < 3e-6 * length);
                    }
            }
}

// The angles are those of rotations, of rotations about z, upside down, and of matrices that are no
// rotation.
static void angles_equal_the_plain_twin(void **state) {
    (void)state;
    uint32_t seed = 13;
    const float special[4][9] = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                 {0, -1, 0, 1, 0, 0, 0, 0, 1},
                                 {-1, 0, 0, 0, 1, 0, 0, 0, -1},
                                 {0}};
    for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++)
        for (int round = 0; round < 40; round++) {
            float m[9][RSH_MAX_WIDTH], r[RSH_MAX_WIDTH][9];
            struct rsh_rotations t = {0};
            for (int i = 0; i < RSH_MAX_WIDTH; i++) {
                noise_rotation(&seed, r[i]);
                if (i < 4 && round == 0) memcpy(r[i], special[i], sizeof r[i]);
                for (int e = 0; e < 9; e++) m[e][i] = r[i][e];
            }
            bool stretch = round & 1;
            (*k)->angles((const float(*)[RSH_MAX_WIDTH])m, stretch, &t);
            for (int i = 0; i < (*k)->width; i++) {
                struct rsh_rotation one = rsh_rotation_of_matrix(r[i]);
                if (stretch && one.method == RSH_METHOD_EXACT) rsh_rotation_stretch(&one);
                assert_true(fabsf(t.cos_alpha[i] - one.cos_alpha) < 1e-6f);
                assert_true(fabsf(t.sin_alpha[i] - one.sin_alpha) < 1e-6f);
                assert_true(fabsf(t.cos_gamma[i] - one.cos_gamma) < 1e-6f);
                assert_true(fabsf(t.sin_gamma[i] - one.sin_gamma) < 1e-6f);
                assert_true(fabsf(t.cos_beta[i] - one.cos_beta) < 1e-6f);
                assert_true(fabsf(t.sin_beta[i] - one.sin_beta) < 1e-6f);
                float beta = atan2f(one.sin_beta, one.cos_beta);
                assert_true(fabsf(t.beta[i] - beta) < 2e-6f);
            }
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rotations_equal_the_plain_twin),
        cmocka_unit_test(angles_equal_the_plain_twin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
