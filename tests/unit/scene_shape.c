// SPDX-License-Identifier: Apache-2.0
// Rectangle and cube: facing, texture coordinates, mirrors and flips; the area and bounds of every
// shape.
#include "mesh_case.h"
#include "test_scene.h"

typedef satin_status (*maker)(struct arena *, const struct mesh_request *, struct mesh *);

// Every triangle faces away from the centre (of a cube) or up, its normals agree with it, and its
// texture coordinates are Mitsuba's function of the vertex.
static void check_facing(maker make, struct mat4 m, bool flip, vec3 centre) {
    struct arena arena = {0};
    struct mesh_request request = {.to_world = m, .flip_normals = flip};
    struct mesh mesh;
    assert_int_equal(make(&arena, &request, &mesh), SATIN_OK);
    for (uint32_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *i = mesh.index + t * 3;
        vec3 a = mesh_case_vertex(mesh.position, i[0]), b = mesh_case_vertex(mesh.position, i[1]),
             c = mesh_case_vertex(mesh.position, i[2]);
        vec3 ng = v3_unit(v3_cross(v3_sub(b, a), v3_sub(c, a)));
        assert_true(v3_dot(ng, v3_sub(a, centre)) > 0.0f);
        for (int k = 0; k < 3; k++)
            assert_near3(mesh_case_vertex(mesh.normal, i[k]), flip ? v3_neg(ng) : ng, 1e-6f);
    }
    arena_free(&arena);
}

static void scene_shape_faces_as_mitsuba(void **state) {
    (void)state;
    static const vec3 size[4] = {{1, 1, 1}, {-1, 1, 1}, {2, -3, 0.5f}, {-1, -1, 1}};
    for (int i = 0; i < 4; i++)
        for (int flip = 0; flip < 2; flip++) {
            struct mat4 m = test_transform(v3(5, 6, 7), size[i]);
            check_facing(load_mesh_cube, m, flip, v3(5, 6, 7));
            check_facing(load_mesh_rectangle, m, flip, v3(5, 6, 0));
        }
}

static void texture_coordinates_are_as_in_mitsuba(void **state) {
    (void)state;
    struct arena arena = {0};
    struct mesh_request request = mesh_case_plain();
    struct mesh mesh;
    assert_int_equal(load_mesh_rectangle(&arena, &request, &mesh), SATIN_OK);
    for (uint32_t i = 0; i < 4; i++) {
        assert_float_equal(mesh.uv[i * 2], 0.5f * mesh.position[i * 3] + 0.5f, 0.0f);
        assert_float_equal(mesh.uv[i * 2 + 1], 0.5f * mesh.position[i * 3 + 1] + 0.5f, 0.0f);
    }
    assert_int_equal(load_mesh_cube(&arena, &request, &mesh), SATIN_OK);
    // On the cube's top, measured with Mitsuba: u = (y + 1) / 2, v = (x + 1) / 2.
    for (uint32_t i = 12; i < 16; i++) {
        assert_float_equal(mesh.position[i * 3 + 2], 1.0f, 0.0f);
        assert_float_equal(mesh.uv[i * 2], 0.5f * mesh.position[i * 3 + 1] + 0.5f, 0.0f);
        assert_float_equal(mesh.uv[i * 2 + 1], 0.5f * mesh.position[i * 3] + 0.5f, 0.0f);
    }
    arena_free(&arena);
}

static void areas_are_right(void **state) {
    (void)state;
    static struct test_scene t;
    test_scene_init(&t);
    struct mat4 rotation = mat4_rotate(v3(1, 2, 3), 50), scale = mat4_scale(v3(2, 3, 4));
    struct mat4 m = mat4_mul(&rotation, &scale);
    struct mat4 even = test_transform(v3(9, 8, 7), v3(-2, 2, 2)), tall = mat4_scale(v3(2, 2, 5));
    struct {
        uint32_t shape;
        double area;
    } known[] = {
        {test_rectangle(&t, m, 0), 24.0},
        {test_cube(&t, m, false, 0), 8.0 * (6 + 8 + 12)},
        {test_quadric(&t, SHAPE_DISK, m, false, 0), M_PI * 6.0},
        {test_quadric(&t, SHAPE_SPHERE, even, false, 0), 16.0 * M_PI},
        {test_quadric(&t, SHAPE_CYLINDER, tall, false, 0), 20.0 * M_PI},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        double area = t.shape[known[i].shape].area;
        assert_true(fabs(area - known[i].area) <= 1e-6 * known[i].area);
    }
    assert_true(t.shape[3].flip_normals);  // the mirrored sphere
    test_scene_free(&t);
}

static void bounds_hold_every_shape(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    const struct mat4 m = test_transform(v3(1, 2, 3), v3(2, 2, 2));
    test_cube(&t, m, false, grey);
    test_quadric(&t, SHAPE_SPHERE, m, false, grey);
    test_quadric(&t, SHAPE_DISK, m, false, grey);
    test_quadric(&t, SHAPE_CYLINDER, m, false, grey);
    static const float side[4][2] = {{-2, 2}, {-2, 2}, {0, 0}, {0, 2}};  // along z; else -2 to 2
    for (int i = 0; i < 4; i++) {
        vec3 lo, hi;
        scene_shape_bounds(&t.shape[i], &lo, &hi);
        assert_near3(lo, v3(-1, 0, 3 + side[i][0]), 1e-6f);
        assert_near3(hi, v3(3, 4, 3 + side[i][1]), 1e-6f);
    }
    // The box is that of the disk, which is smaller than that of its rotated square.
    const uint32_t rotated =
        test_quadric(&t, SHAPE_DISK, mat4_rotate(v3(0, 0, 1), 45.0f), false, grey);
    vec3 lo, hi;
    scene_shape_bounds(&t.shape[rotated], &lo, &hi);
    assert_near3(lo, v3(-1, -1, 0), 1e-6f);
    assert_near3(hi, v3(1, 1, 0), 1e-6f);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scene_shape_faces_as_mitsuba),
        cmocka_unit_test(texture_coordinates_are_as_in_mitsuba),
        cmocka_unit_test(areas_are_right),
        cmocka_unit_test(bounds_hold_every_shape),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
