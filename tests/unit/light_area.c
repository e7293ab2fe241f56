// SPDX-License-Identifier: Apache-2.0
// Area lights of any size: products of lengths neither overflow nor vanish.
#include "light/light_kinds.h"

#include "test_scene.h"

// The solid angle is that of the unit square.
static void rectangles_of_any_size(void **state) {
    (void)state;
    static const float size[] = {1.0f, 1e-7f, 1e5f, 1e7f, 1e-11f, 1e12f};
    float first = 0.0f;
    for (int i = 0; i < 6; i++) {
        struct test_scene t;
        test_scene_init(&t);
        struct mat4 scale = test_transform(v3(0, 0, 0), v3(size[i], size[i], size[i]));
        uint32_t shape = test_rectangle(&t, scale, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
        test_area_light(&t, shape, rgb_grey(1.0f));
        test_scene_finish(&t);
        struct light_sample s;
        vec3 p = v3_mul(v3(0.2f, 0.1f, 0.7f), size[i]);
        assert_true(light_sample(&t.scene, 0, p, 0.3f, 0.6f, &s));
        if (i == 0) first = s.pdf_w;
        assert_true(fabsf(s.pdf_w - first) <= 1e-5f * first);
        test_scene_free(&t);
    }
}

// Normals and densities where the square of the area leaves the range of float.
static void triangles_of_any_size(void **state) {
    (void)state;
    static const uint32_t index[3] = {0, 1, 2};
    static const float size[] = {1.0f, 1e-11f, 1e12f}, u[4] = {0.3f, 0.6f, 0.2f, 0.7f};
    for (int i = 0; i < 3; i++) {
        const float position[10] = {0, 0, 0, size[i], 0, 0, 0, size[i], 0, 0};
        struct test_scene t;
        test_scene_init(&t);
        struct shape s = {.kind = SHAPE_MESH, .material = test_diffuse(&t, 0, 0, 0)};
        s.mesh = (struct mesh){3, 1, position, NULL, NULL, index, NULL, 0};
        test_area_light(&t, test_add_shape(&t, s), rgb_grey(1.0f));
        test_scene_finish(&t);
        struct light_ray photon;
        struct light_sample sample;
        vec3 p = v3_mul(v3(0.2f, 0.1f, 0.7f), size[i]);
        assert_true(light_sample(&t.scene, 0, p, 0.3f, 0.6f, &sample));
        assert_true(v3_dist2(sample.n, v3(0, 0, 1)) < 1e-10f);
        // The solid angle is about that of the triangle seen from the front.
        assert_true(sample.pdf_w > 0.5f && sample.pdf_w < 10.0f);
        assert_true(light_emit(&t.scene, 0, NULL, u, &photon));
        float power = 0.5f * PI_F * size[i] * size[i];
        assert_true(fabsf(photon.power.r / power - 1.0f) < 1e-4f && photon.ray.d.z > 0.0f);
        test_scene_free(&t);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(rectangles_of_any_size),
                                       cmocka_unit_test(triangles_of_any_size)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
