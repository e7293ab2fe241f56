// SPDX-License-Identifier: Apache-2.0
// How often the records of a kind are read in a pixel, and the mean that its samples get.
#include "shade/shade_pixel_cache.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// Adds light while more is wanted: a mean of 1, with this relative amplitude to both sides, by
// turns. Returns the number of positions.
static int shade_pixel_cache_fill(struct shade_pixel_value *value, enum cache_kind kind,
                                  float amplitude) {
    struct shade_pixel_light *light = &value->light[kind];
    int count = 0;
    while (shade_pixel_light_wanted(value, kind) && count < 100) {
        const float Y = count++ % 2 ? 1.0f - amplitude : 1.0f + amplitude;
        const struct cache_used used = {.count = count};
        shade_pixel_light_add(light, used, rgb_make(2.0f * Y, 0.0f, 0.0f), rgb_grey(Y));
        assert_int_equal(light->used.count, count);
    }
    return count;
}

static void irradiance_is_read_once(void **state) {
    (void)state;
    struct shade_pixel_value value = {0};
    assert_int_equal(shade_pixel_cache_fill(&value, CACHE_IRRADIANCE, 0.5f), 1);
    assert_true(shade_pixel_light_wanted(&value, CACHE_RADIANCE));
}

static void equal_radiance_is_read_twice(void **state) {
    (void)state;
    struct shade_pixel_value value = {0};
    assert_int_equal(shade_pixel_cache_fill(&value, CACHE_RADIANCE, 0.0f), 2);
    assert_float_equal(value.light[CACHE_RADIANCE].glossy.r, 2.0f, 1e-6f);
}

// The standard error of n values 1 +- d is d / sqrt(n - 1), half a percent at 5 for d = .01.
static void radiance_is_read_until_its_mean_is_certain(void **state) {
    (void)state;
    struct shade_pixel_value value = {0};
    const int count = shade_pixel_cache_fill(&value, CACHE_RADIANCE, 0.01f);
    assert_in_range(count, 5, 6);
    assert_float_equal(value.light[CACHE_RADIANCE].E.g, 1.0f, 0.003f);
}

static void noisy_radiance_is_read_sixteen_times(void **state) {
    (void)state;
    struct shade_pixel_value value = {0};
    assert_int_equal(shade_pixel_cache_fill(&value, CACHE_RADIANCE, 0.5f), 16);
    assert_float_equal(value.light[CACHE_RADIANCE].E.b, 1.0f, 1e-5f);
}

static void dark_radiance_is_certain(void **state) {
    (void)state;
    struct shade_pixel_value value = {0};
    struct shade_pixel_light *light = &value.light[CACHE_RADIANCE];
    for (int i = 0; i < 2; i++)
        shade_pixel_light_add(light, (struct cache_used){.count = 1}, rgb_grey(0.0f),
                              rgb_grey(0.0f));
    assert_false(shade_pixel_light_wanted(&value, CACHE_RADIANCE));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_is_read_once),
        cmocka_unit_test(equal_radiance_is_read_twice),
        cmocka_unit_test(radiance_is_read_until_its_mean_is_certain),
        cmocka_unit_test(noisy_radiance_is_read_sixteen_times),
        cmocka_unit_test(dark_radiance_is_certain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
