// SPDX-License-Identifier: Apache-2.0
// OBJ: the mesh that is read from well-formed text, and the line that every error names.
#include "mesh_case.h"

static void load_mesh_obj_read_text(struct mesh_case *c, struct mesh_request request,
                                    const char *text) {
    assert_int_equal(mesh_case_read(c, load_mesh_obj, request, text, strlen(text)), SATIN_OK);
}

static void all_forms_of_corners_are_read(void **state) {
    (void)state;
    struct mesh_case c;
    load_mesh_obj_read_text(
        &c, mesh_case_plain(),
        "# comment\r\nmtllib x.mtl\r\no name\r\n\r\n"
        "v 0 0 0\r\n  v 1 0 0 1.0\r\nv\t1 1 0\r\nv 0 1 0 # w\r\n"
        "vt 0 0\r\nvt 1 0 0\r\nvt 1 .5e0\r\nvt .25\r\nvn 0 0 2\r\nvn 0 0 1\r\n"
        "g a b\r\nusemtl m\r\ns 1\r\n"
        "f 1/1/1 2/2/1 3/3/1 4/4/2\r\nf 1//1 2//1 3//1\r\nf 1/1 2/2 \\\r\n 3/3\r\nf -4 -3 -2\r\n"
        "l 1 2\r\nf 1/1/1 2/2/1 3/3/1");
    const struct mesh *m = &c.mesh;
    assert_int_equal(m->triangle_count, 6);
    assert_int_equal(m->vertex_count, 4 + 3 + 3 + 3);  // one per distinct triple
    assert_non_null(m->uv);
    const uint32_t fan[6] = {0, 1, 2, 0, 2, 3};
    assert_memory_equal(m->index, fan, sizeof fan);
    assert_memory_equal(m->index + 15, fan, 3 * sizeof *fan);  // the last face is the first again
    for (uint32_t i = 0; i < 3; i++)
        assert_near3(mesh_case_vertex(m->position, m->index[12 + i]),
                     mesh_case_vertex(m->position, m->index[i]), 0.0f);
    assert_float_equal(m->uv[2 * 2 + 1], 0.5f, 0.0f);
    assert_float_equal(m->uv[3 * 2], 0.25f, 0.0f);
    // The last two corners have no normal in the file and get a smooth one.
    for (uint32_t i = 0; i < m->vertex_count; i++)
        assert_near3(mesh_case_vertex(m->normal, i), v3(0, 0, 1), 1e-6f);
    assert_true(c.hash != 1);
    mesh_case_free(&c);
}

static const char quad[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1 4/1\n";

static void the_requested_changes_are_applied(void **state) {
    (void)state;
    struct mesh_case c;
    struct mesh_request request = {
        .to_world = mat4_translate(v3(0, 0, 5)), .flip_normals = true, .flip_tex_coords = true};
    load_mesh_obj_read_text(&c, request, quad);
    assert_near3(mesh_case_vertex(c.mesh.position, 2), v3(1, 1, 5), 0.0f);
    assert_near3(mesh_case_vertex(c.mesh.normal, 2), v3(0, 0, -1), 1e-6f);
    assert_float_equal(c.mesh.uv[1], 0.75f, 0.0f);
    mesh_case_free(&c);
    request.face_normals = true;
    load_mesh_obj_read_text(&c, request, quad);
    assert_null(c.mesh.normal);
    mesh_case_free(&c);
}

// Three points in a line are no triangle that a ray could hit, at any position.
static void triangles_without_area_are_dropped(void **state) {
    (void)state;
    struct mesh_case c;
    load_mesh_obj_read_text(&c, mesh_case_plain(),
                            "v .1 .1 .1\nv .3 .3 .3\nv .9 .9 .9\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    const uint32_t *index = c.mesh.index;
    assert_true(index[0] == index[1] && index[0] == index[2]);
    assert_true(index[3] != index[4] && index[3] != index[5] && index[4] != index[5]);
    mesh_case_free(&c);
}

// The normals of the file decide which side is the front, mirrored or not.
static void triangles_are_wound_by_their_normals(void **state) {
    (void)state;
    static const char text[] =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1//2 2//2 3//2\n";
    for (int mirror = 0; mirror < 2; mirror++) {
        struct mesh_case c;
        struct mesh_request request = {.to_world = mat4_scale(v3(mirror ? -2 : 1, 1, 3))};
        load_mesh_obj_read_text(&c, request, text);
        for (uint32_t t = 0; t < 2; t++) {
            const uint32_t *i = c.mesh.index + t * 3;
            vec3 a = mesh_case_vertex(c.mesh.position, i[0]),
                 b = mesh_case_vertex(c.mesh.position, i[1]),
                 d = mesh_case_vertex(c.mesh.position, i[2]);
            vec3 n = mesh_case_vertex(c.mesh.normal, i[0]);
            assert_near3(n, v3(0, 0, t ? 1 : -1), 1e-6f);
            assert_true(v3_dot(v3_cross(v3_sub(b, a), v3_sub(d, a)), n) > 0.0f);
        }
        mesh_case_free(&c);
    }
}

static void an_error_names_its_line(void **state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } wrong[] = {
        {"", "mesh: there is no face in it"},
        {"v 0 0 0\nv 1 0 0\nf 1 2\n", "mesh:3: a face needs at least three corners"},
        {"v 0 0\n", "mesh:1: expected a number"},
        {"\n\nv 0 0 x\n", "mesh:3: expected a number"},
        {"v 0 0 1x\n", "mesh:1: expected a number"},
        {"v nan 0 0\n", "mesh:1: expected a number"},
        {"v 1e99 0 0\n", "mesh:1: a coordinate is not finite"},
        {"vt inf 0\n", "mesh:1: expected a number"},
        {"v 0 0 0\nf 1 2 3\n", "mesh:2: a face refers to vertex 2, but there are 1 so far"},
        {"v 0 0 0\nf 0 1 1\n", "mesh:2: a face refers to vertex 0, but there are 1 so far"},
        {"v 0 0 0\nf -2 1 1\n", "mesh:2: a face refers to vertex -2, but there are 1 so far"},
        {"v 0 0 0\nf 99999999999999999999 1 1\n", "mesh:2: a face refers to vertex"},
        {"v 0 0 0\nf 1/1 1/1 1/1\n", "mesh:2: a face refers to texture coordinate 1"},
        {"v 0 0 0\nf 1//1 1//1 1//1\n", "mesh:2: a face refers to normal 1, but there are 0"},
        {"v 0 0 0\nf 1 a 1\n", "mesh:2: expected the index of a face corner"},
        {"v 0 0 0\nf 1/ 1/ 1/\n", "mesh:2: expected the index of a face corner"},
        {"v 1e30 0 0\nf 1 1 1\n", "mesh: vertex 0 is not finite or too far away"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        mesh_case_refuse(load_mesh_obj, wrong[i].text, strlen(wrong[i].text), wrong[i].message);
}

static void a_missing_mesh_names_the_scene(void **state) {
    (void)state;
    struct scene_case log;
    struct arena arena = {0};
    struct load_source source = {
        scene_case_begin(&log), {"scene.xml", 3, 7}, &arena, "missing", NULL};
    struct mesh mesh;
    struct mesh_request request = mesh_case_plain();
    assert_int_equal(load_mesh_obj(&source, &request, &mesh), SATIN_ERROR_INPUT);
    assert_memory_equal(log.error, "scene.xml:3:7: cannot read 'missing'", 36);
}

// The triangles of a mesh, all in a row.
static void load_mesh_obj_has(const struct mesh *mesh, uint32_t triangles, vec3 first_corner) {
    assert_int_equal(mesh->triangle_count, triangles);
    if (triangles)
        assert_near3(mesh_case_vertex(mesh->position, mesh->index[0]), first_corner, 0.0f);
}

static void faces_are_divided_by_their_materials(void **state) {
    (void)state;
    static const char text[] =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 2 3 4\nusemtl red one \r\n"
        "f 1 2 3 4\nusemtl other\nf 3 4 1\nusemtl  red one\nf 4 1 2\n";
    const char *const material[] = {"red", "red one"};
    struct mesh_request request = mesh_case_plain();
    request.material = material;
    request.material_count = 2;
    struct arena arena = {0};
    struct scene_case log;
    struct mesh mesh[3];
    scene_case_bytes("mesh", text, strlen(text));
    const struct load_source source = {scene_case_begin(&log), {0}, &arena, "mesh", NULL};
    assert_int_equal(load_mesh_obj(&source, &request, mesh), SATIN_OK);
    load_mesh_obj_has(&mesh[0], 0, v3(0, 0, 0));
    load_mesh_obj_has(&mesh[1], 3, v3(0, 0, 0));
    load_mesh_obj_has(&mesh[2], 2, v3(1, 0, 0));
    assert_int_equal(mesh[1].vertex_count, 4);
    arena_free(&arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_forms_of_corners_are_read),
        cmocka_unit_test(the_requested_changes_are_applied),
        cmocka_unit_test(triangles_are_wound_by_their_normals),
        cmocka_unit_test(triangles_without_area_are_dropped),
        cmocka_unit_test(an_error_names_its_line),
        cmocka_unit_test(faces_are_divided_by_their_materials),
        cmocka_unit_test(a_missing_mesh_names_the_scene),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
