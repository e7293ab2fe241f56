// SPDX-License-Identifier: Apache-2.0
// A record in which any one number is not finite, or out of its range, is refused.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/cache_records.h"

enum { ORDER = 3, N2 = ORDER * ORDER };

static struct gather_around make_around(void) {
    struct gather_around around = {.harmonic = INFINITY, .least = 1.0f, .least_upright = 2.0f};
    for (int s = 0; s < GATHER_SECTORS; s++) around.sector[s] = s % 2 ? INFINITY : 0.0f;
    return around;
}

// Sets each of `count` floats from `first` on to a NaN and to an infinite number in turn.
static void irradiance_refuses(struct gather_irradiance *value, struct gather_around *around,
                               float *first, int count) {
    static const float wrong[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            const float kept = first[i];
            first[i] = wrong[k];
            assert_false(cache_valid_irradiance(value, around));
            first[i] = kept;
        }
    assert_true(cache_valid_irradiance(value, around));
}

static void irradiance_is_checked(void **state) {
    (void)state;
    struct gather_irradiance value = {.E = {0.0f, 1.0f, 2.0f}};
    struct gather_around around = make_around();
    irradiance_refuses(&value, &around, &value.E.r, 3);
    irradiance_refuses(&value, &around, &value.grad_t[0].x, 9);
    irradiance_refuses(&value, &around, &value.grad_r[0].x, 9);
    irradiance_refuses(&value, &around, around.hessian, 3);
    irradiance_refuses(&value, &around, &around.deviation, 1);
    value.E.g = -1e-6f;
    assert_false(cache_valid_irradiance(&value, &around));
    value.E.g = 0.0f;
    around.harmonic = NAN;
    assert_false(cache_valid_irradiance(&value, &around));
    around.harmonic = 0.0f;
    assert_false(cache_valid_irradiance(&value, &around));
    around.harmonic = 3.0f;
    around.sector[GATHER_SECTORS - 1] = NAN;
    assert_false(cache_valid_irradiance(&value, &around));
}

static void radiance_is_checked(void **state) {
    (void)state;
    float block[10 * N2] = {0};
    const struct gather_radiance value = {
        .lambda = block, .dx = block + 3 * N2, .dy = block + 6 * N2, .noise = block + 9 * N2};
    const struct gather_around around = make_around();
    for (int i = 0; i < 10 * N2; i++) {
        block[i] = i % 2 ? NAN : INFINITY;
        assert_false(cache_valid_radiance(&value, ORDER, &around));
        block[i] = -1.0f;
        assert_true(cache_valid_radiance(&value, ORDER, &around));
    }
}

static void heads_are_checked(void **state) {
    (void)state;
    const struct cache_head good = {
        .n = {0, 0, 1}, .u = {1, 0, 0}, .R = 1, .search_radius = 2, .scale = 1};
    assert_true(cache_valid_head(&good));
    struct cache_head head = good;
    float *number[] = {&head.p.x,          &head.p.z,   &head.R,   &head.n.y,  &head.search_radius,
                       &head.anisotropy.x, &head.scale, &head.u.y, &head.clear};
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) {
        *number[i] = NAN;
        assert_false(cache_valid_head(&head));
        head = good;
    }
    head.scale = 1.5f;
    assert_false(cache_valid_head(&head));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_is_checked),
        cmocka_unit_test(radiance_is_checked),
        cmocka_unit_test(heads_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
