// SPDX-License-Identifier: Apache-2.0
// A new record in which any one number is not finite, or out of its range, is refused.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fill/fill_record.h"

enum { ORDER = 3, N2 = ORDER * ORDER };

static struct gather_surroundings make_around(void) {
    struct gather_surroundings around = {
        .harmonic = INFINITY, .least = 1.0f, .least_upright = 2.0f};
    for (int s = 0; s < CACHE_SECTORS; s++) around.sector[s] = s % 2 ? INFINITY : 0.0f;
    return around;
}

// Sets each of `count` floats from `first` on to a NaN and to an infinite number in turn.
static void irradiance_refuses(struct cache_irradiance_value *value,
                               struct gather_surroundings *around, float *first, int count) {
    static const float wrong[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            const float kept = first[i];
            first[i] = wrong[k];
            assert_false(fill_valid_irradiance(value, around));
            first[i] = kept;
        }
    assert_true(fill_valid_irradiance(value, around));
}

static void irradiance_is_checked(void **state) {
    (void)state;
    struct cache_irradiance_value value = {.E = {0.0f, 1.0f, 2.0f}};
    struct gather_surroundings around = make_around();
    irradiance_refuses(&value, &around, &value.E.r, 3);
    irradiance_refuses(&value, &around, &value.grad_t[0].x, 9);
    irradiance_refuses(&value, &around, &value.grad_r[0].x, 9);
    irradiance_refuses(&value, &around, around.hessian, 3);
    irradiance_refuses(&value, &around, &around.deviation, 1);
    irradiance_refuses(&value, &around, &around.gradient_deviation, 1);
    value.E.g = -1e-6f;
    assert_false(fill_valid_irradiance(&value, &around));
    value.E.g = 0.0f;
    around.harmonic = NAN;
    assert_false(fill_valid_irradiance(&value, &around));
    around.harmonic = 0.0f;
    assert_false(fill_valid_irradiance(&value, &around));
    around.harmonic = 3.0f;
    around.sector[CACHE_SECTORS - 1] = NAN;
    assert_false(fill_valid_irradiance(&value, &around));
}

static void radiance_is_checked(void **state) {
    (void)state;
    float block[10 * N2] = {0};
    const struct gather_radiance value = {
        .lambda = block, .dx = block + 3 * N2, .dy = block + 6 * N2, .noise = block + 9 * N2};
    const struct gather_surroundings around = make_around();
    for (int i = 0; i < 10 * N2; i++) {
        block[i] = i % 2 ? NAN : INFINITY;
        assert_false(fill_valid_radiance(&value, ORDER, &around));
        block[i] = -1.0f;
        assert_true(fill_valid_radiance(&value, ORDER, &around));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_is_checked),
        cmocka_unit_test(radiance_is_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
