// SPDX-License-Identifier: Apache-2.0
// Environments with a sun on top of the image; light.c has the rest.
#include <math.h>

#include "base/sampling.h"
#include "test_scene.h"

// A small sun is evaluated where it is sampled, and brings its radiance times its solid angle.
static void the_sun_is_a_disc(void **state) {
    (void)state;
    float texel[4 * 3 * 3] = {0};
    const struct image black = {4, 3, 3, texel};
    struct light light = {.kind = LIGHT_ENVMAP, .value = rgb_grey(1.0f), .image = &black};
    light.to_world = light.to_local = mat4_identity();
    light.sun = v3_unit(v3(0.3f, 0.2f, -0.8f));
    light.sun_value = rgb_grey(1e4f);
    light.sun_chord = 4.6e-3f;
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, light);
    test_scene_finish(&t);
    double sum = 0.0;
    int seen = 0;
    for (int i = 0; i < 100; i++)
        for (int k = 0; k < 100; k++) {
            struct light_sample s;
            float u = ((float)i + 0.5f) * 0.01f, v = ((float)k + 0.5f) * 0.01f;
            if (!light_sample(&t.scene, 0, v3(0, 0, 0), u, v, &s)) continue;
            sum += (double)(s.L.g / s.pdf_w) * 1e-4;
            seen += light_environment(&t.scene, s.wi).g == 1e4f;
        }
    double exact = 1e4 * M_PI * 4.6e-3 * 4.6e-3;
    assert_true(fabs(sum - exact) < 1e-3 * exact);
    assert_true(seen > 6900 && seen <= 7000);  // 7 of 10 samples; the rim is lost to rounding
    assert_true(rgb_black(light_environment(&t.scene, v3_unit(v3(0.3f, 0.21f, -0.8f)))));
    test_scene_free(&t);
}

// Behind a window that leaves most bins dark, the density that is reported is that of the samples,
// and the light of every part of the sky has the right mean.
static void histograms_do_not_change_the_mean(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(2.0f)});
    test_scene_finish(&t);
    float weight[LIGHT_HISTOGRAM_BINS];
    struct light_bins bins;
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) weight[i] = i % 7 ? 0.0f : (float)(i % 5);
    light_bins_build(weight, &bins);
    const struct light_histogram histogram = {0.75f, &bins};
    enum { SAMPLES = 1 << 20, PARTS = 8 };
    double sum[PARTS] = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const vec2 u = sample_sobol2(i, 3);
        struct light_sample s;
        assert_true(light_environment_sample(&t.scene, &histogram, u.x, u.y, &s));
        const float reported = light_environment_pdf(&t.scene, &histogram, s.wi);
        assert_true(fabsf(reported - s.pdf_w) <= 1e-5f * reported);
        // The regions are halves of bins, by both coordinates, below and above.
        const float around = 0.5f + atan2f(s.wi.y, s.wi.x) * (0.5f / PI_F);
        const int x = (int)(2 * LIGHT_HISTOGRAM_SIDE * around);
        const int y = (int)(LIGHT_HISTOGRAM_SIDE * (1.0f - s.wi.z));
        const int part = x % 2 + 2 * (y % 2) + 4 * (s.wi.z > 0.5f);
        sum[part] += (double)(s.L.g / s.pdf_w) / SAMPLES;
    }
    for (int i = 0; i < PARTS; i++) {
        const double exact = 2.0 * (i < 4 ? 0.75 : 0.25) * M_PI;
        assert_true(fabs(sum[i] - exact) < 2e-3 * exact);
    }
    test_scene_free(&t);
}

// A window of 12 x 12 bins, of which a half-plane at an angle is visible. The variance of the
// number of visible samples among 64 is .070 of that of independent samples; it was .087 when u
// alone drew the bin and its row, and v only the position within a column.
static void samples_of_bins_are_stratified(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    test_scene_finish(&t);
    enum { FIRST = 8, SIDE = 12, SAMPLES = 64, SEEDS = 1024 };
    float weight[LIGHT_HISTOGRAM_BINS] = {0.0f};
    struct light_bins bins;
    for (int i = 0; i < SIDE * SIDE; i++)
        weight[(FIRST + i / SIDE) * LIGHT_HISTOGRAM_SIDE + FIRST + i % SIDE] = 1.0f;
    light_bins_build(weight, &bins);
    const struct light_histogram histogram = {0.99f, &bins};
    const float side = LIGHT_HISTOGRAM_SIDE, middle = FIRST + 0.5f * SIDE;
    double squares = 0.0;
    for (uint32_t seed = 0; seed < SEEDS; seed++) {
        int visible = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            const vec2 u = sample_sobol2(i, seed);
            struct light_sample s;
            // Only samples by bins.
            light_environment_sample(&t.scene, &histogram, 0.99f * u.x, u.y, &s);
            const float y = side * (0.5f - 0.5f * s.wi.z) - middle;
            const float x = side * azimuth_fraction(s.wi.y, s.wi.x) - middle;
            visible += 0.4f * x + y > 0.0f;
        }
        squares += (double)((visible - SAMPLES / 2) * (visible - SAMPLES / 2)) / SEEDS;
    }
    print_message("variance over that of independent samples: %.3f\n", squares / (SAMPLES / 4));
    assert_true(squares < 0.078 * SAMPLES / 4);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sun_is_a_disc),
        cmocka_unit_test(histograms_do_not_change_the_mean),
        cmocka_unit_test(samples_of_bins_are_stratified),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
