// SPDX-License-Identifier: Apache-2.0
// Meshes of height fields: where their vertices are, which side is the front, and their normals.
#include "mesh_case.h"

static satin_status make_field(struct mesh_case *c, struct mesh_request request, int width,
                               int height, const float *value) {
    *c = (struct mesh_case){.hash = 1};
    const struct heights heights = {width, height, 1, value, {1, 1, 1}};
    return load_mesh_heightfield(&c->arena, &request, &heights, &c->mesh);
}

static void vertices_are_at_the_heights(void **state) {
    (void)state;
    static const float value[6] = {1, 2, -3, 4, 5, 6};
    static const uint32_t first_cell[6] = {3, 0, 4, 4, 0, 1};
    struct mesh_case c;
    assert_int_equal(make_field(&c, mesh_case_plain(), 3, 2, value), SATIN_OK);
    assert_true(c.mesh.vertex_count == 6 && c.mesh.triangle_count == 4);
    assert_memory_equal(c.mesh.index, first_cell, sizeof first_cell);
    for (uint32_t i = 0; i < 6; i++) {
        const float x = (float)(i % 3) - 1.0f, y = i < 3 ? -1.0f : 1.0f;
        assert_near3(mesh_case_vertex(c.mesh.position, i), v3(x, y, value[i]), 0.0f);
        assert_float_equal(c.mesh.uv[2 * i], 0.5f * (x + 1.0f), 0.0f);
        assert_float_equal(c.mesh.uv[2 * i + 1], i < 3 ? 0.0f : 1.0f, 0.0f);
    }
    mesh_case_free(&c);
}

// One height is as a square of four, and a row is as two equal ones.
static void a_row_alone_counts_twice(void **state) {
    (void)state;
    static const float value[3] = {1, 2, 3};
    struct mesh_case c;
    assert_int_equal(make_field(&c, mesh_case_plain(), 1, 1, value), SATIN_OK);
    assert_true(c.mesh.vertex_count == 4 && c.mesh.triangle_count == 2);
    assert_near3(mesh_case_vertex(c.mesh.position, 3), v3(1, 1, 1), 0.0f);
    mesh_case_free(&c);
    assert_int_equal(make_field(&c, mesh_case_plain(), 3, 1, value), SATIN_OK);
    assert_near3(mesh_case_vertex(c.mesh.position, 5), v3(1, 1, 3), 0.0f);
    mesh_case_free(&c);
    assert_int_equal(make_field(&c, mesh_case_plain(), 1, 3, value), SATIN_OK);
    assert_near3(mesh_case_vertex(c.mesh.position, 4), v3(-1, 1, 3), 0.0f);
    mesh_case_free(&c);
}

static void check_fronts(const struct mesh *mesh, vec3 up) {
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        vec3 p[3];
        for (int k = 0; k < 3; k++) p[k] = mesh_case_vertex(mesh->position, mesh->index[3 * t + k]);
        assert_true(v3_dot(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])), up) > 0.0f);
    }
}

// A plane has its normal at every vertex, whatever the number of samples, and a transform that
// stretches or mirrors it.
static void planes_have_their_normal(void **state) {
    (void)state;
    enum { W = 9, H = 4 };
    float value[W * H];
    for (int i = 0; i < W * H; i++)
        value[i] = 0.7f * (float)(i % W) / (W - 1) - 0.3f * (float)(i / W) / (H - 1);
    static const vec3 scales[] = {{1, 1, 1}, {2, 0.5f, 3}, {-1, 1, 2}, {1, 1, -1}};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        const vec3 s = scales[i];
        struct mesh_case c;
        struct mesh_request request = {.to_world = mat4_scale(s)};
        assert_int_equal(make_field(&c, request, W, H, value), SATIN_OK);
        // z = .35 x - .15 y in object space.
        const vec3 n = v3_unit(v3(-0.35f / s.x, 0.15f / s.y, 1.0f / s.z));
        for (uint32_t v = 0; v < c.mesh.vertex_count; v++)
            assert_near3(mesh_case_vertex(c.mesh.normal, v), n, 1e-6f);
        check_fronts(&c.mesh, n);
        mesh_case_free(&c);
        request.flip_normals = true;
        assert_int_equal(make_field(&c, request, W, H, value), SATIN_OK);
        assert_near3(mesh_case_vertex(c.mesh.normal, 3), v3_neg(n), 1e-6f);
        mesh_case_free(&c);
        request.face_normals = true;
        assert_int_equal(make_field(&c, request, W, H, value), SATIN_OK);
        assert_null(c.mesh.normal);
        mesh_case_free(&c);
    }
}

// At the middle vertex of four cells, the normals of their bilinear patches in a space in which
// cells have the size 1 are added, as in Mitsuba 0.6.
static void normals_are_sums_over_patches(void **state) {
    (void)state;
    static const float value[9] = {0, 0, 0, 0, 1, 0, 0, 0, 0.5f};
    // The slopes along x and y of the patches at their corner in the middle.
    static const float slope[4][2] = {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
    vec3 sum = {0, 0, 0};
    for (int i = 0; i < 4; i++) sum = v3_add(sum, v3_unit(v3(-slope[i][0], -slope[i][1], 1)));
    struct mesh_case c;
    assert_int_equal(make_field(&c, mesh_case_plain(), 3, 3, value), SATIN_OK);
    assert_near3(mesh_case_vertex(c.mesh.normal, 4), v3_unit(sum), 1e-6f);
    // The corner beside the last cell has only its slopes.
    assert_near3(mesh_case_vertex(c.mesh.normal, 8), v3_unit(v3(-.5f, -.5f, 1)), 1e-6f);
    assert_near3(mesh_case_vertex(c.mesh.normal, 5),
                 v3_unit(v3_add(v3_unit(v3(1, 0, 1)), v3_unit(v3(1, -.5f, 1)))), 1e-6f);
    mesh_case_free(&c);
}

static void colours_count_by_their_luminance(void **state) {
    (void)state;
    static const float value[12] = {.5f, .5f, .5f, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const struct heights heights = {2, 2, 3, value, {2, 2, 4}};
    struct mesh_case c = {.hash = 1};
    const struct mesh_request request = mesh_case_plain();
    assert_int_equal(load_mesh_heightfield(&c.arena, &request, &heights, &c.mesh), SATIN_OK);
    const float expected[4] = {rgb_luminance(rgb_make(1, 1, 2)), 2 * LUMINANCE_R, 2 * LUMINANCE_G,
                               4 * LUMINANCE_B};
    for (uint32_t i = 0; i < 4; i++)
        assert_float_equal(c.mesh.position[3 * i + 2], expected[i], 1e-6f);
    mesh_case_free(&c);
}

static void fields_that_are_too_large_are_refused(void **state) {
    (void)state;
    static const float value[4] = {0, 1e30f, 0, 0}, flat[4] = {0, 0, 0, 0};
    struct mesh_case c;
    assert_int_equal(make_field(&c, mesh_case_plain(), 2, 2, value), SATIN_ERROR_INPUT);
    mesh_case_free(&c);
    struct mesh_request request = {.to_world = mat4_scale(v3(1e30f, 1, 1))};
    assert_int_equal(make_field(&c, request, 2, 2, flat), SATIN_ERROR_INPUT);
    mesh_case_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(vertices_are_at_the_heights),
                                       cmocka_unit_test(a_row_alone_counts_twice),
                                       cmocka_unit_test(planes_have_their_normal),
                                       cmocka_unit_test(normals_are_sums_over_patches),
                                       cmocka_unit_test(colours_count_by_their_luminance),
                                       cmocka_unit_test(fields_that_are_too_large_are_refused)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
