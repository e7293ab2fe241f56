// SPDX-License-Identifier: Apache-2.0
// How the normal changes along surfaces, from the surface points that rays hit.
#include <math.h>

#include "scene/scene.h"
#include "scene_case.h"

// The change of the normal along x, per length, where a ray down z hits the only shape of a scene
// file.
static vec3 change_along_x(const char *text, float x, float y) {
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    const struct ray ray = {v3(x, y, 9), 0.0f, v3(0, 0, -1), INFINITY};
    struct interaction s;
    assert_true(scene_intersect(scene, &ray, &s));
    const vec3 found = scene_normal_change(scene, &s, v3(1, 0, 0));
    satin_scene_free(scene);
    return found;
}

static void spheres_and_planes_are_exact(void **state) {
    (void)state;
    static const struct {
        const char *text;
        float change;
    } known[] = {
        {SCENE_TEXT("<shape type='sphere'><float name='radius' value='.25'/></shape>"), 4.0f},
        {SCENE_TEXT("<shape type='sphere'><transform name='to_world'><scale value='5'/>"
                    "</transform></shape>"),
         0.2f},
        {SCENE_TEXT("<shape type='disk'/>"), 0.0f},
        {SCENE_TEXT("<shape type='rectangle'/>"), 0.0f},
        {SCENE_TEXT("<shape type='cube'/>"), 0.0f},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        assert_float_equal(change_along_x(known[i].text, 0.0f, 0.01f).x, known[i].change,
                           1e-5f * known[i].change);
}

// A band of eight smooth quads around the y axis, of radius 2: a chord of 45 degrees is 8 % shorter
// than its arc, and so is the difference of two unit normals, which a ray that hits the middle of a
// chord divides by the length of their mean, cos 22.5 degrees.
static void meshes_rotate_with_their_normals(void **state) {
    (void)state;
    enum { SIDES = 8 };
    char text[4096];
    int length = 0;
    for (int i = 0; i < SIDES; i++)
        for (int k = 0; k < 2; k++) {
            const double angle = 2.0 * M_PI * (i + 0.5) / SIDES, x = sin(angle), z = cos(angle);
            length +=
                snprintf(text + length, sizeof text - (size_t)length,
                         "v %.9g %d %.9g\nvn %.9g 0 %.9g\n", 2.0 * x, 2 * k - 1, 2.0 * z, x, z);
        }
    for (int i = 0; i < SIDES; i++) {
        const int a = 2 * i + 1, b = 2 * ((i + 1) % SIDES) + 1;
        length +=
            snprintf(text + length, sizeof text - (size_t)length, "f %d//%d %d//%d %d//%d %d//%d\n",
                     a, a, b, b, b + 1, b + 1, a + 1, a + 1);
    }
    scene_case_file("band.obj", text);
    const vec3 smooth = change_along_x(
        SCENE_TEXT("<shape type='obj'><string name='filename' value='band.obj'/></shape>"), 0.0f,
        0.2f);
    assert_float_equal(smooth.x, 0.5f / cosf(PI_F / SIDES), 1e-4f);
    assert_float_equal(v3_len(smooth), smooth.x, 1e-4f);
    const vec3 flat =
        change_along_x(SCENE_TEXT("<shape type='obj'><string name='filename' value='band.obj'/>"
                                  "<boolean name='face_normals' value='true'/></shape>"),
                       0.0f, 0.2f);
    assert_true(v3_len(flat) == 0.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_and_planes_are_exact),
        cmocka_unit_test(meshes_rotate_with_their_normals),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
