// SPDX-License-Identifier: Apache-2.0
// Environments with a sun on top of the image; scene_light.c has the rest.
#include <math.h>

#include "test_scene.h"

// A small sun is seen where it is drawn, and brings its radiance times its solid angle.
static void sun_is_a_disc(void **state) {
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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(sun_is_a_disc)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
