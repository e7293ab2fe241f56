// SPDX-License-Identifier: Apache-2.0
// Cryptomatte: ids of names as the specification's own tests have them, and the ids and coverages
// of a pixel by rank. tests/cli/cryptomatte decodes the layers of an image.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include <math.h>

#include "render/render_cryptomatte.h"

static float as_float(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void names_have_the_published_ids(void **state) {
    (void)state;
    assert_float_equal(as_float(render_cryptomatte_id("hello")), 6.07056271e-17f, 1e-25);
    // "plane" in Bulgarian, in UTF-8.
    assert_float_equal(
        as_float(render_cryptomatte_id("\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0")),
        -1.31926312e-25f, 1e-33);
}

static void ids_are_normal_numbers(void **state) {
    (void)state;
    char name[16];
    int odd = 0;
    for (int i = 0; i < 20000; i++) {
        snprintf(name, sizeof name, "shape%d", i);
        const float id = as_float(render_cryptomatte_id(name));
        assert_true(isnormal(id));
        const uint32_t exponent = render_cryptomatte_id(name) >> 23 & 255u;
        odd += exponent == 1 || exponent == 254;
    }
    // Twice as many as by chance, 4 / 256.
    assert_in_range(odd, 200, 430);
}

static void ranks_are_sorted_by_coverage(void **state) {
    (void)state;
    struct cryptomatte_pixel pixel = {.id = {0}};
    float out[CRYPTOMATTE_CHANNELS];
    render_cryptomatte_ranks(&pixel, 1.0f, out);
    for (int i = 0; i < CRYPTOMATTE_CHANNELS; i++) assert_float_equal(out[i], 0.0f, 0.0f);
    const uint32_t a = render_cryptomatte_id("a"), b = render_cryptomatte_id("b"),
                   c = render_cryptomatte_id("c");
    for (int i = 0; i < 3; i++) render_cryptomatte_pixel_add(&pixel, b, 1.0f);
    render_cryptomatte_pixel_add(&pixel, a, 2.0f);
    render_cryptomatte_pixel_add(&pixel, b, 2.0f);
    render_cryptomatte_pixel_add(&pixel, c, -0.5f);
    render_cryptomatte_ranks(&pixel, 0.1f, out);
    assert_float_equal(out[0], as_float(b), 0.0f);
    assert_float_equal(out[1], 0.5f, 1e-7f);
    assert_float_equal(out[2], as_float(a), 0.0f);
    assert_float_equal(out[3], 0.2f, 1e-7f);
    // A negative coverage, by a filter with negative lobes, is none.
    for (int i = 4; i < CRYPTOMATTE_CHANNELS; i++) assert_float_equal(out[i], 0.0f, 0.0f);
}

static void the_largest_stay_when_a_pixel_is_full(void **state) {
    (void)state;
    struct cryptomatte_pixel pixel = {.id = {0}};
    float out[CRYPTOMATTE_CHANNELS];
    for (uint32_t i = 1; i <= CRYPTOMATTE_IDS; i++)
        render_cryptomatte_pixel_add(&pixel, i << 23, (float)i);
    render_cryptomatte_pixel_add(&pixel, 100u << 23, 0.5f);
    render_cryptomatte_pixel_add(&pixel, 101u << 23, 7.5f);
    render_cryptomatte_ranks(&pixel, 1.0f / 64.0f, out);
    const float wanted[] = {8.0f, 7.5f, 7.0f, 6.0f, 5.0f, 4.0f};
    for (int i = 0; i < CRYPTOMATTE_RANKS; i++)
        assert_float_equal(out[2 * i + 1], wanted[i] / 64.0f, 1e-7f);
    assert_float_equal(out[2], as_float(101u << 23), 0.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_have_the_published_ids),
        cmocka_unit_test(ids_are_normal_numbers),
        cmocka_unit_test(ranks_are_sorted_by_coverage),
        cmocka_unit_test(the_largest_stay_when_a_pixel_is_full),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
