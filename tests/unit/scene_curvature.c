// SPDX-License-Identifier: Apache-2.0
// Curvature of every kind of shape, from the surface points that rays hit.
#include <math.h>

#include "scene/scene.h"
#include "scene_case.h"

// The curvature where a ray hits the only shape of a scene file.
static float curvature_at(const char *text, vec3 o, vec3 d) {
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    const struct ray ray = {o, 0.0f, v3_unit(d), INFINITY};
    struct interaction s;
    assert_true(scene_intersect(scene, &ray, &s));
    const float found = scene_curvature(scene, &s);
    satin_scene_free(scene);
    return found;
}

static void quadrics_and_planes_are_exact(void **state) {
    (void)state;
    const vec3 o = v3(0, 0, 9), down = v3(0.01f, 0.02f, -1);
    static const struct {
        const char *text;
        float curvature;
    } known[] = {
        {SCENE_TEXT("<shape type='sphere'><float name='radius' value='.25'/></shape>"), 4.0f},
        {SCENE_TEXT("<shape type='sphere'><transform name='to_world'><scale value='5'/>"
                    "</transform></shape>"),
         0.2f},
        {SCENE_TEXT("<shape type='cylinder'><point name='p0' value='-3,0,0'/>"
                    "<point name='p1' value='3,0,0'/><float name='radius' value='.4'/></shape>"),
         2.5f},
        {SCENE_TEXT("<shape type='disk'/>"), 0.0f},
        {SCENE_TEXT("<shape type='rectangle'/>"), 0.0f},
        {SCENE_TEXT("<shape type='cube'/>"), 0.0f},
        {SCENE_TEXT("<shape type='shapegroup' id='g'><shape type='sphere'/></shape>"
                    "<shape type='instance'><ref id='g'/><transform name='to_world'>"
                    "<scale value='2'/><rotate x='1' angle='30'/></transform></shape>"),
         0.5f},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        assert_float_equal(curvature_at(known[i].text, o, down), known[i].curvature,
                           1e-5f * known[i].curvature);
}

// A band of eight smooth quads around the y axis, of radius 2: a chord of 45 degrees is 8 % shorter
// than its arc, and so is the difference of two unit normals.
static void meshes_rotate_with_their_normals(void **state) {
    (void)state;
    enum { SIDES = 8 };
    char text[4096];
    int length = 0;
    for (int i = 0; i < SIDES; i++)
        for (int k = 0; k < 2; k++) {
            const double angle = 2.0 * M_PI * i / SIDES, x = sin(angle), z = cos(angle);
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
    const float found = curvature_at(
        SCENE_TEXT("<shape type='obj'><string name='filename' value='band.obj'/></shape>"),
        v3(0.3f, 0.2f, 9), v3(0, 0, -1));
    assert_float_equal(found, 0.5f, 1e-4f);
    const float flat =
        curvature_at(SCENE_TEXT("<shape type='obj'><string name='filename' value='band.obj'/>"
                                "<boolean name='face_normals' value='true'/></shape>"),
                     v3(0.3f, 0.2f, 9), v3(0, 0, -1));
    assert_true(flat == 0.0f);
}

static void curves_are_tubes(void **state) {
    (void)state;
    scene_case_file("tube.txt", "-1 0 0 .2\n1 0 0 .2\n");
    assert_float_equal(
        curvature_at(
            SCENE_TEXT(
                "<shape type='linearcurve'><string name='filename' value='tube.txt'/></shape>"),
            v3(0, 0, 5), v3(0, 0, -1)),
        5.0f, 1e-5f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quadrics_and_planes_are_exact),
        cmocka_unit_test(meshes_rotate_with_their_normals),
        cmocka_unit_test(curves_are_tubes),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
