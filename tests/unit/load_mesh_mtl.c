// SPDX-License-Identifier: Apache-2.0
// OBJs with several BRDFs: those of the scene by the names of materials, and those of the files
// that an OBJ of version 0.6 names.
#include <png.h>

#include "scene/scene.h"
#include "scene_case.h"

#define SCENE06(parts)                                                                     \
    "<scene version='0.6.0'><sensor type='perspective'/><emitter type='constant'/><shape " \
    "type='obj'><string "                                                                  \
    "name='filename' "                                                                     \
    "value='a.obj'/>" parts "</shape></scene>"

static const char two_faces[] =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl a b\nf 1 3 4\n";

static const struct brdf *load_mesh_mtl_base(const satin_scene *scene, size_t shape) {
    return &scene->material[scene->shape[shape].material].front.base;
}

static void materials_have_brdfs_of_their_own(void **state) {
    (void)state;
    struct scene_case c;
    scene_case_file("a.obj", two_faces);
    satin_scene *scene = scene_case_load(
        &c, SCENE06("<bsdf type='diffuse' name='a b'><rgb name='reflectance' value='.25'/></bsdf>"
                    "<bsdf type='plastic' name='none'/><bsdf type='conductor'/>"));
    assert_non_null(scene);
    assert_int_equal(scene->shape_count, 2);
    assert_float_equal(load_mesh_mtl_base(scene, 0)->diffuse.r, .25f, 0.0f);
    assert_string_equal(load_mesh_mtl_base(scene, 1)->model->name, "conductor");
    assert_true(c.warnings == 1 &&
                strstr(c.warning, "no face of the file has the material 'none'"));
    satin_scene_free(scene);
    assert_null(scene_case_load(&c, SCENE06("<bsdf type='plastic'/><bsdf type='diffuse'/>")));
    assert_non_null(strstr(c.error, "shape 'obj' has two <bsdf>s"));
    assert_null(scene_case_load(
        &c, SCENE06("<bsdf type='plastic' name='red'/><bsdf type='diffuse' name='red'/>")));
    assert_non_null(strstr(c.error, "shape 'obj' has two <bsdf>s of the name 'red'"));
}

static void files_of_materials_are_read(void **state) {
    (void)state;
    struct scene_case c;
    scene_case_file("a.obj", two_faces);
    scene_case_file("a.mtl",
                    "# text\nnewmtl red\r\n Kd 1 0 .5\nKs 0 0 0\nillum 2\nNs 10\n"
                    "newmtl a b\nKd .5 .5 .5\nKs .25 .25 .25\nNs 40\nillum 2\nd 0.5\n"
                    "newmtl red\nKd 0 0 1\nnewmtl other\nmap_Kd none.png\nbump none.png\n");
    satin_scene *scene = scene_case_load(&c, SCENE06(""));
    assert_non_null(scene);
    assert_int_equal(c.warnings, 0);  // what no face has is not read
    assert_int_equal(scene->shape_count, 2);
    assert_string_equal(load_mesh_mtl_base(scene, 0)->model->name, "diffuse");
    assert_float_equal(load_mesh_mtl_base(scene, 0)->diffuse.r, 1.0f, 1e-6f);
    assert_float_equal(load_mesh_mtl_base(scene, 0)->diffuse.b, .2140411f, 1e-6f);
    const struct material *masked = &scene->material[scene->shape[1].material];
    assert_true(masked->front.component[0] && masked->front.holes);
    assert_string_equal(masked->name, "a b");
    satin_scene_free(scene);
}

// Names keep their capitals, a mark of UTF-8 is skipped, words after numbers have no meaning.
static void materials_of_other_programs_are_read(void **state) {
    (void)state;
    struct scene_case c;
    scene_case_file("a.obj",
                    "mtllib A.mtl none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl Mat.001\nf 1 2 3\n"
                    "usemtl matA\nf 1 3 2\nusemtl lost\nf 2 1 3\n");
    scene_case_file("a.mtl",
                    "\xef\xbb\xbfnewmtl Mat.001\nKD .5 # half\nNs 10 # none\nd 1.5\n"
                    "newmtl matA\nKs\nmap_kd -s 1 2 3 a.png\n");
    assert_null(scene_case_load(&c, SCENE06("")));
    assert_string_equal(c.error, "a.mtl:7: cannot read 'a.png': No such file or directory");
    const unsigned char texel[3] = {255, 0, 0};
    png_image png = {
        .version = PNG_IMAGE_VERSION, .width = 1, .height = 1, .format = PNG_FORMAT_RGB};
    assert_true(png_image_write_to_file(&png, "a.png", 0, texel, 0, NULL));
    satin_scene *scene = scene_case_load(&c, SCENE06(""));
    assert_non_null(scene);
    assert_int_equal(scene->shape_count, 3);
    assert_float_equal(load_mesh_mtl_base(scene, 0)->diffuse.g, .2140411f, 1e-6f);
    assert_float_equal(load_mesh_mtl_base(scene, 1)->diffuse.r, 1.0f, 1e-6f);
    // The other case of the file's name, the missing file, 1.5, the missing number, and the lost
    // material.
    assert_int_equal(c.warnings, 5);
    satin_scene_free(scene);
}

static void attributes_of_materials_are_missing(void **state) {
    (void)state;
    struct scene_case c;
    scene_case_file("a.obj", two_faces);
    assert_null(
        scene_case_load(&c, SCENE06("<bsdf type='diffuse' name='red'><texture type='vertexcolors' "
                                    "name='reflectance'/></bsdf><bsdf type='diffuse'/>")));
    assert_non_null(strstr(c.error, "shape 'obj' has no attribute 'vertexcolors' for its texture"));
}

static void missing_materials_are_grey(void **state) {
    (void)state;
    struct scene_case c;
    scene_case_file("a.obj", two_faces);
    remove("a.mtl");
    satin_scene *scene = scene_case_load(&c, SCENE06(""));
    assert_true(scene && scene->shape_count == 1 && c.warnings == 1);
    assert_non_null(strstr(c.warning,
                           "cannot read 'a.mtl': No such file or directory; its "
                           "materials are grey"));
    satin_scene_free(scene);
    // Version 3 reads no materials.
    scene = scene_case_load(&c,
                            "<scene version='3.0.0'><sensor type='perspective'/><shape "
                            "type='obj'><string name='filename' value='a.obj'/></shape></scene>");
    assert_true(scene && scene->shape_count == 1 && c.warnings == 0);
    satin_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(materials_have_brdfs_of_their_own),
                                       cmocka_unit_test(files_of_materials_are_read),
                                       cmocka_unit_test(materials_of_other_programs_are_read),
                                       cmocka_unit_test(attributes_of_materials_are_missing),
                                       cmocka_unit_test(missing_materials_are_grey)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
