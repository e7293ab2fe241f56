// SPDX-License-Identifier: Apache-2.0
// max_smooth_angle: a cube keeps its edges below 90 degrees and loses them above.
#include "load/load_mesh.h"

#include "mesh_case.h"
#include "scene/scene.h"

static const char load_mesh_smooth_cube[] =
    "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n"
    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

static void read_cube(struct mesh_case *c, float angle) {
    struct mesh_request request = mesh_case_plain();
    request.smooth_angle = angle;
    assert_int_equal(mesh_case_read(c, load_mesh_obj, request, load_mesh_smooth_cube,
                                    strlen(load_mesh_smooth_cube)),
                     SATIN_OK);
    assert_true(c->mesh.triangle_count == 12 && c->mesh.vertex_count == 36);
}

static void sharp_edges_are_kept(void **state) {
    (void)state;
    struct mesh_case c;
    read_cube(&c, 80.0f);
    for (uint32_t i = 0; i < 36; i++) {
        uint32_t t = i - i % 3;
        vec3 a = mesh_case_vertex(c.mesh.position, c.mesh.index[t]),
             b = mesh_case_vertex(c.mesh.position, c.mesh.index[t + 1]),
             d = mesh_case_vertex(c.mesh.position, c.mesh.index[t + 2]);
        vec3 face = v3_unit(v3_cross(v3_sub(b, a), v3_sub(d, a)));
        assert_near3(mesh_case_vertex(c.mesh.normal, c.mesh.index[i]), face, 1e-6f);
    }
    mesh_case_free(&c);
}

static void flatter_edges_are_smoothed(void **state) {
    (void)state;
    struct mesh_case c;
    read_cube(&c, 100.0f);
    for (uint32_t i = 0; i < 36; i++) {
        vec3 p = mesh_case_vertex(c.mesh.position, i);
        assert_near3(mesh_case_vertex(c.mesh.normal, i), v3_unit(p), 1e-6f);
    }
    mesh_case_free(&c);
}

static void impossible_smoothing_is_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"<float name='max_smooth_angle' value='181'/>",
         "its max_smooth_angle is over 180 degrees"},
        {"<float name='max_smooth_angle' value='30'/><boolean name='face_normals' value='true'/>",
         "it has both face_normals and max_smooth_angle"}};
    scene_case_file("cube.obj", load_mesh_smooth_cube);
    for (int i = 0; i < 2; i++) {
        char text[512];
        struct scene_case c;
        satin_scene *scene = NULL;
        struct log log = scene_case_begin(&c);
        snprintf(text, sizeof text,
                 SCENE_TEXT("<shape type='obj'><string name='filename' value='cube.obj'/>%s"
                            "</shape>"),
                 cases[i][0]);
        scene_case_file("scene.xml", text);
        assert_int_equal(satin_scene_load("scene.xml", NULL, 0, log.fn, log.user, &scene),
                         SATIN_ERROR_INPUT);
        assert_non_null(strstr(c.error, cases[i][1]));
    }
}

static void an_angle_of_zero_keeps_all_edges(void **state) {
    (void)state;
    struct scene_case c;
    scene_case_file("cube.obj", load_mesh_smooth_cube);
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<shape type='obj'><string name='filename' value='cube.obj'/>"
                       "<float name='max_smooth_angle' value='0'/></shape>"));
    assert_true(scene && scene->shape[0].face_normals && !scene->shape[0].mesh.normal);
    satin_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(sharp_edges_are_kept),
                                       cmocka_unit_test(flatter_edges_are_smoothed),
                                       cmocka_unit_test(impossible_smoothing_is_refused),
                                       cmocka_unit_test(an_angle_of_zero_keeps_all_edges)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
