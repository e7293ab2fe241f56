// SPDX-License-Identifier: Apache-2.0
// Mesh lights of many triangles, from near: samples follow the density that is reported, and those
// of a long one have little noise, at any scale.
#include "test_light.h"

enum { SIDES = 12, SLAB_POINTS = 2 * SIDES, SLAB_TRIANGLES = 2 * SIDES };

struct mesh_tube {
    float position[3 * SLAB_POINTS + 1];
    uint32_t index[3 * SLAB_TRIANGLES];
    struct test_scene scene;
};

// The sides of a prism along z, of this radius and length.
static void mesh_tube_start(struct mesh_tube *tube, float radius, float length) {
    for (uint32_t i = 0; i < SIDES; i++) {
        const float phi = 2.0f * PI_F * (float)i / SIDES;
        for (uint32_t end = 0; end < 2; end++) {
            float *p = tube->position + 3 * (size_t)(i + SIDES * end);
            p[0] = radius * cosf(phi);
            p[1] = radius * sinf(phi);
            p[2] = ((float)end - 0.5f) * length;
        }
        const uint32_t next = (i + 1) % SIDES;
        const uint32_t corner[6] = {i, next, next + SIDES, i, next + SIDES, i + SIDES};
        memcpy(tube->index + 6 * (size_t)i, corner, sizeof corner);
    }
    test_scene_init(&tube->scene);
    struct shape s = {.kind = SHAPE_MESH, .material = test_diffuse(&tube->scene, 0, 0, 0)};
    s.mesh = (struct mesh){SLAB_POINTS, SLAB_TRIANGLES, tube->position, NULL,
                           NULL,        tube->index,    NULL,           0};
    // Without one of its triangles, so that they are not faces in pairs.
    s.mesh.triangle_count--;
    test_area_light(&tube->scene, test_add_shape(&tube->scene, s), rgb_grey(1.0f));
    test_scene_finish(&tube->scene);
}

static void densities_of_slabs_are_right(void **state) {
    (void)state;
    static const vec3 at[] = {{0.5f, 0.2f, 0.3f}, {0.1f, 0.6f, -1.4f}, {0.3f, 0.3f, 2.2f}};
    struct mesh_tube tube;
    mesh_tube_start(&tube, 0.2f, 3.0f);
    for (int i = 0; i < 3; i++) test_light_density(&tube.scene, 0, at[i], "mesh");
    test_scene_free(&tube.scene);
}

static void long_meshes_have_little_noise(void **state) {
    (void)state;
    static const float scale[] = {1.0f, 1e-8f, 1e9f};
    for (int k = 0; k < 3; k++) {
        struct mesh_tube tube;
        mesh_tube_start(&tube, 0.004f * scale[k], 3.0f * scale[k]);
        const vec3 p = v3(0.1f * scale[k], 0.02f * scale[k], 1.3f * scale[k]);
        const float deviation = test_light_deviation(&tube.scene, p, v3(-1, 0, 0));
        print_message("scale %g: deviation %.2f\n", (double)scale[k], (double)deviation);
        assert_true(deviation < 3.0f);  // by area it is 6.2
        test_scene_free(&tube.scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(densities_of_slabs_are_right),
                                       cmocka_unit_test(long_meshes_have_little_noise)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
