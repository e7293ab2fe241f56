// SPDX-License-Identifier: Apache-2.0
// The tabulated sky against figures worked out by hand from the paper's formulas, and the sun
// against the measured one.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "light/light.h"

static struct sky sky_of(float turbidity, float elevation) {
    float e = elevation * (PI_F / 180.0f);
    return (struct sky){turbidity, v3(cosf(e), sinf(e), 0.0f)};
}

static rgb light_sky_texel(const struct image *image, int column, int row) {
    const float *t = image->texel + 3 * (row * image->width + column);
    return rgb_make(t[0], t[1], t[2]);
}

// A luminance of 1 is this many kcd/m^2.
static const float light_sky_unit = 72.91f;

static void the_zenith_has_the_luminance_of_the_formula(void **state) {
    (void)state;
    // The columns are turbidity, elevation, luminance (4.0453 T - 4.9710) tan chi - 0.2155 T +
    // 2.4192 [kcd/m^2] with chi = (4/9 - T/120) (pi - 2 theta), and x and y of the zenith.
    static const float known[3][5] = {{3.0f, 60.0f, 10.4131f, 0.25343f, 0.25979f},
                                      {3.0f, 20.0f, 3.9329f, 0.2507f, 0.26129f},
                                      {6.0f, 60.0f, 22.0667f, 0.26313f, 0.27599f}};
    for (int i = 0; i < 3; i++) {
        struct arena arena = {0};
        struct image image;
        struct sky sky = sky_of(known[i][0], known[i][1]);
        assert_true(sky_image(&arena, &sky, &image));
        rgb c = light_sky_texel(&image, 0, 0);
        float X = 0.412453f * c.r + 0.357580f * c.g + 0.180423f * c.b;
        float Y = 0.212671f * c.r + 0.715160f * c.g + 0.072169f * c.b;
        float Z = 0.019334f * c.r + 0.119193f * c.g + 0.950227f * c.b;
        assert_float_equal(Y * light_sky_unit, known[i][2], 2e-3f * known[i][2]);
        assert_float_equal(X / (X + Y + Z), known[i][3], 5e-4f);
        assert_float_equal(Y / (X + Y + Z), known[i][4], 5e-4f);
        arena_free(&arena);
    }
}

static void the_sky_ends_at_the_horizon_and_is_symmetric(void **state) {
    (void)state;
    struct arena arena = {0};
    struct image image;
    struct sky sky = sky_of(2.5f, 30.0f);
    assert_true(sky_image(&arena, &sky, &image));
    int half = image.height / 2, width = image.width;
    for (int column = 0; column < width; column++) {
        assert_false(rgb_black(light_sky_texel(&image, column, half)));
        assert_true(rgb_black(light_sky_texel(&image, column, half + 1)));
        // The plane of the sun, at a quarter of the way around, is one of symmetry.
        rgb a = light_sky_texel(&image, column, half - 20);
        rgb b = light_sky_texel(&image, (width / 2 - 1 - column + width) % width, half - 20);
        assert_float_equal(a.g, b.g, 1e-4f * a.g);
    }
    // The sky is brightest towards the sun.
    float toward = light_sky_texel(&image, width / 4, half * 2 / 3).g, away = 0.0f;
    for (int column = width / 2; column < width; column++)
        away = fmaxf(away, light_sky_texel(&image, column, half * 2 / 3).g);
    assert_true(toward > 3.0f * away);
    arena_free(&arena);
}

// Direct sunlight at noon is some 100 klx with a colour near white; it fades and reddens.
static void low_sunlight_is_faint_and_red(void **state) {
    (void)state;
    const float chord = 0.5338f * 0.5f * (PI_F / 180.0f), solid_angle = PI_F * chord * chord;
    struct sky high = sky_of(2.5f, 80.0f), low = sky_of(2.5f, 5.0f);
    rgb noon = sky_sun(&high), evening = sky_sun(&low);
    float klux = rgb_luminance(noon) * solid_angle * light_sky_unit;
    assert_true(klux > 85.0f && klux < 115.0f);
    assert_true(noon.r / noon.b > 1.0f && noon.r / noon.b < 1.8f);
    assert_true(evening.r / evening.b > 8.0f);
    assert_true(rgb_luminance(evening) < 0.1f * rgb_luminance(noon));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_zenith_has_the_luminance_of_the_formula),
        cmocka_unit_test(the_sky_ends_at_the_horizon_and_is_symmetric),
        cmocka_unit_test(low_sunlight_is_faint_and_red),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
