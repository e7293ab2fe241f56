// SPDX-License-Identifier: Apache-2.0
// Parallel light from flat shapes.
#include <math.h>

#include "test_scene.h"

// A beam brings the same to all points before its shape, and photons leave along its normal.
static void beams_have_one_direction(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        struct test_scene t;
        test_scene_init(&t);
        struct mat4 to_world = mat4_rotate(v3(1, 2, -1), 40.0f);
        uint32_t black = test_diffuse(&t, 0, 0, 0);
        uint32_t shape = kind ? test_quadric(&t, SHAPE_DISK, to_world, false, black)
                              : test_rectangle(&t, to_world, black);
        test_area_light(&t, shape, rgb_grey(3.0f));
        t.scene.light[0].kind = LIGHT_BEAM;
        test_scene_finish(&t);
        const float area = kind ? PI_F : 4.0f;
        assert_float_equal(t.scene.light[0].power, 3.0f * area, 1e-3f);
        vec3 n = mat4_vector(&to_world, v3(0, 0, 1));
        struct light_sample s;
        for (float h = 0.5f; h < 100.0f; h *= 4.0f) {
            assert_true(
                light_sample_wi(&t.scene, 0, mat4_point(&to_world, v3(.7f, .6f, h)), 0, 0, &s));
            assert_true(s.delta && s.L.g == 3.0f && fabsf(s.dist - h) < 1e-4f * h);
            assert_true(v3_dot(s.wi, n) < -0.9999f);
            assert_true(v3_len(v3_sub(s.p, mat4_point(&to_world, v3(.7f, .6f, 0)))) < 1e-4f * h);
        }
        bool corner =
            light_sample_wi(&t.scene, 0, mat4_point(&to_world, v3(.9f, .9f, 1)), 0, 0, &s);
        assert_true(corner == !kind);
        assert_false(light_sample_wi(&t.scene, 0, mat4_point(&to_world, v3(1.1f, 0, 1)), 0, 0, &s));
        assert_false(light_sample_wi(&t.scene, 0, mat4_point(&to_world, v3(0, 0, -1)), 0, 0, &s));
        const float u[4] = {0.3f, 0.8f, 0.1f, 0.9f};
        struct light_ray photon;
        assert_true(light_emit(&t.scene, 0, NULL, u, &photon));
        assert_true(v3_dot(photon.ray.d, n) > 0.9999f);
        assert_float_equal(photon.power.g, 3.0f * area, 1e-3f);
        test_scene_free(&t);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(beams_have_one_direction)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
