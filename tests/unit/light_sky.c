// SPDX-License-Identifier: Apache-2.0
// The tabulated sky and the sun against the radiances that `sunsky` of Mitsuba 3.9 has, which
// Emitter.eval gives in its variant scalar_rgb.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "light/light.h"

static const float DEGREE = PI_F / 180.0f;

static struct sky sky_of(float turbidity, float elevation, float albedo) {
    const float e = elevation * DEGREE;
    return (struct sky){turbidity, rgb_grey(albedo), v3(cosf(e), sinf(e), 0.0f)};
}

static rgb light_sky_texel(const struct image *image, int column, int row) {
    const float *t = image->texel + 3 * (row * image->width + column);
    return rgb_make(t[0], t[1], t[2]);
}

static rgb light_sky_at(const struct image *image, vec3 w) {
    const float u = atan2f(w.x, -w.z) / (2.0f * PI_F), v = acosf(w.y) / PI_F;
    const float x = (u - floorf(u)) * (float)image->width - 0.5f + (float)image->width,
                y = v * (float)(image->height - 1);
    const int column = (int)x, row = (int)fminf(y, (float)(image->height - 2));
    rgb sum = rgb_grey(0.0f);
    for (int i = 0; i < 4; i++) {
        const float fx = x - (float)column, fy = y - (float)row;
        const float weight = (i % 2 ? fx : 1.0f - fx) * (i / 2 ? fy : 1.0f - fy);
        sum = rgb_mad(sum, light_sky_texel(image, (column + i % 2) % image->width, row + i / 2),
                      weight);
    }
    return sum;
}

static void the_sky_is_that_of_mitsuba(void **state) {
    (void)state;
    // Turbidity, elevation, albedo; angle to the zenith, azimuth from the sun; radiance.
    static const struct {
        float turbidity, elevation, albedo, zenith, azimuth, L[3];
    } known[] = {
        {1.0f, 10.0f, 0.0f, 0.0f, 0.0f, {0.0068997f, 0.014927f, 0.027124f}},
        {1.0f, 10.0f, 0.0f, 40.0f, 90.0f, {0.011914f, 0.022187f, 0.038126f}},
        {1.0f, 10.0f, 0.0f, 70.0f, 10.0f, {0.049143f, 0.075176f, 0.095112f}},
        {1.0f, 10.0f, 0.0f, 85.0f, 180.0f, {0.11489f, 0.14345f, 0.11706f}},
        {2.5f, 30.0f, 0.3f, 0.0f, 0.0f, {0.015459f, 0.030392f, 0.061981f}},
        {2.5f, 30.0f, 0.3f, 40.0f, 90.0f, {0.021796f, 0.041605f, 0.079231f}},
        {2.5f, 30.0f, 0.3f, 70.0f, 10.0f, {0.18008f, 0.22072f, 0.25355f}},
        {2.5f, 30.0f, 0.3f, 85.0f, 180.0f, {0.14143f, 0.20539f, 0.24441f}},
        {3.0f, 60.0f, 0.15f, 0.0f, 0.0f, {0.034021f, 0.051731f, 0.097452f}},
        {3.0f, 60.0f, 0.15f, 40.0f, 90.0f, {0.029662f, 0.052591f, 0.10524f}},
        {3.0f, 60.0f, 0.15f, 70.0f, 10.0f, {0.082194f, 0.12648f, 0.20522f}},
        {3.0f, 60.0f, 0.15f, 85.0f, 180.0f, {0.11164f, 0.16587f, 0.23958f}},
        {6.3f, 5.0f, 1.0f, 0.0f, 0.0f, {0.0092175f, 0.014695f, 0.020643f}},
        {6.3f, 5.0f, 1.0f, 40.0f, 90.0f, {0.017204f, 0.023824f, 0.028867f}},
        {6.3f, 5.0f, 1.0f, 70.0f, 10.0f, {0.23588f, 0.15975f, 0.078242f}},
        {6.3f, 5.0f, 1.0f, 85.0f, 180.0f, {0.073791f, 0.070928f, 0.050521f}},
        {10.0f, 80.0f, 0.5f, 0.0f, 0.0f, {0.9562f, 0.88749f, 0.78359f}},
        {10.0f, 80.0f, 0.5f, 40.0f, 90.0f, {0.19266f, 0.21884f, 0.23722f}},
        {10.0f, 80.0f, 0.5f, 70.0f, 10.0f, {0.19372f, 0.22331f, 0.2467f}},
        {10.0f, 80.0f, 0.5f, 85.0f, 180.0f, {0.20224f, 0.20488f, 0.20927f}},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct arena arena = {0};
        struct image image;
        struct sky sky = sky_of(known[i].turbidity, known[i].elevation, known[i].albedo);
        assert_true(light_sky_image(&arena, &sky, &image));
        const float z = known[i].zenith * DEGREE, a = known[i].azimuth * DEGREE;
        const rgb c = light_sky_at(&image, v3(sinf(z) * cosf(a), cosf(z), sinf(z) * sinf(a)));
        assert_float_equal(c.r, known[i].L[0], 2e-3f * known[i].L[0]);
        assert_float_equal(c.g, known[i].L[1], 2e-3f * known[i].L[1]);
        assert_float_equal(c.b, known[i].L[2], 2e-3f * known[i].L[2]);
        arena_free(&arena);
    }
}

static void the_sky_ends_at_the_horizon_and_is_symmetric(void **state) {
    (void)state;
    struct arena arena = {0};
    struct image image;
    struct sky sky = sky_of(2.5f, 30.0f, 0.3f);
    assert_true(light_sky_image(&arena, &sky, &image));
    int half = image.height / 2, width = image.width;
    for (int column = 0; column < width; column++) {
        assert_false(rgb_black(light_sky_texel(&image, column, half)));
        assert_true(rgb_black(light_sky_texel(&image, column, half + 1)));
        // The plane of the sun, at a quarter of the way around, is one of symmetry.
        rgb a = light_sky_texel(&image, column, half - 20);
        rgb b = light_sky_texel(&image, (width / 2 - 1 - column + width) % width, half - 20);
        assert_float_equal(a.g, b.g, 1e-4f * a.g);
    }
    arena_free(&arena);
}

// The radiance of the sun differs by less than .3 % where it is high, and less than 3 % of its
// largest channel down to five degrees.
static void the_sun_is_that_of_mitsuba(void **state) {
    (void)state;
    static const struct {
        float turbidity, elevation, L[3], within;
    } known[] = {
        {1.5f, 60.0f, {22388.0f, 18790.0f, 14453.0f}, 3e-3f},
        {3.0f, 30.0f, {20274.0f, 15950.0f, 10618.0f}, 3e-3f},
        {8.0f, 80.0f, {18861.0f, 15682.0f, 12486.0f}, 3e-3f},
        {4.2f, 12.0f, {13594.0f, 8648.0f, 3624.6f}, 0.03f},
        {2.0f, 5.0f, {11132.0f, 5043.8f, 676.26f}, 0.03f},
        {6.0f, 5.0f, {4111.7f, 1702.4f, 239.82f}, 0.03f},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const struct sky sky = sky_of(known[i].turbidity, known[i].elevation, 0.3f);
        const rgb L = light_sky_sun(&sky);
        const float error = known[i].within * known[i].L[0];
        assert_float_equal(L.r, known[i].L[0], error);
        assert_float_equal(L.g, known[i].L[1], error);
        assert_float_equal(L.b, known[i].L[2], error);
        assert_true(L.r >= 0.0f && L.g >= 0.0f && L.b >= 0.0f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sky_is_that_of_mitsuba),
        cmocka_unit_test(the_sky_ends_at_the_horizon_and_is_symmetric),
        cmocka_unit_test(the_sun_is_that_of_mitsuba),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
