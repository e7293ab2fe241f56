// SPDX-License-Identifier: Apache-2.0
// A file of version 0.6 gives the same scene as its translation to version 3.
#include "load/load_mitsuba06.h"

#include "light/light.h"
#include "load/load_build.h"
#include "load/load_params.h"
#include "scene_case.h"

static const char mitsuba06[] =
    "<scene version='0.6.0'><integrator type='path'><integer name='maxDepth' value='7'/>"
    "<boolean name='hideEmitters' value='true'/></integrator>"
    "<sensor type='thinlens'><float name='fov' value='40'/><string name='fovAxis' value='y'/>"
    "<float name='nearClip' value='.5'/><float name='apertureRadius' value='.25'/>"
    "<transform name='toWorld'><lookAt origin='0 0 5' target='0 0 0' up='0 1 0'/></transform>"
    "<sampler type='sobol'><integer name='sampleCount' value='9'/></sampler>"
    "<film type='ldrfilm'><boolean name='banner' value='false'/>"
    "<integer name='width' value='40'/></film></sensor><emitter type='constant'/>"
    "<shape type='sphere'><bsdf type='roughplastic'>"
    "<srgb name='diffuseReflectance' value='.5 .5 #'/></bsdf></shape></scene>";

static void names_of_version_06_are_translated(void **state) {
    (void)state;
    struct scene_case c;
    assert_null(scene_case_load(&c, mitsuba06));  // the colour's '#'
    char text[2048];
    snprintf(text, sizeof text, "%s", mitsuba06);
    memcpy(strchr(text, '#'), "1", 1);
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    assert_true(scene->hints.max_depth == 7 && scene->hints.hide_emitters == 1);
    assert_true(scene->hints.spp == 9 && scene->film.width == 40 && scene->film.height == 576);
    assert_true(scene->camera.near_clip == 0.5f && scene->camera.aperture == 0.25f);
    assert_int_equal(c.warnings, 0);  // none for the banner, which never is in an image
    satin_scene_free(scene);
}

// The camera is where the first key of its <animation> is; a transform in a key is an error.
static void the_first_key_of_an_animation_is_taken(void **state) {
    (void)state;
    static const char moved[] =
        "<scene version='%s'><sensor type='perspective'><animation name='%s'>"
        "<transform time='0'><translate x='3'/>%s<translate y='2'/></transform>"
        "<transform time='1'><translate x='5'/></transform><transform time='2'/>"
        "</animation><float name='fov' value='40'/></sensor><emitter type='constant'/></scene>";
    struct scene_case c;
    char text[1024];
    for (int version = 0; version < 2; version++) {
        snprintf(text, sizeof text, moved, version ? "3.0.0" : "0.6.0",
                 version ? "to_world" : "toWorld", "");
        satin_scene *scene = scene_case_load(&c, text);
        assert_non_null(scene);
        assert_true(scene->camera.to_world.m[0][3] == 3.0f &&
                    scene->camera.to_world.m[1][3] == 2.0f);
        assert_true(c.warnings == 1 && strstr(c.warning, "motion is not supported"));
        satin_scene_free(scene);
    }
    snprintf(text, sizeof text, moved, "0.6.0", "toWorld", "<transform name='a'/>");
    assert_null(scene_case_load(&c, text));
    assert_non_null(strstr(c.error, "<transform> cannot stand inside <transform>"));
}

// A factor around the heights is the bumpmap's own.
static void the_scale_of_bumps_is_moved(void **state) {
    (void)state;
    static const char bumps[] =
        "<scene version='%s'><sensor type='perspective'/><shape type='cube'>"
        "<bsdf type='bumpmap'><texture type='scale'><texture type='checkerboard'/>%s"
        "</texture><bsdf type='diffuse'/></bsdf></shape></scene>";
    struct scene_case c;
    char text[1024];
    snprintf(text, sizeof text, bumps, "0.6.0", "<float name='scale' value='7'/>");
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    const struct material_bump *bump = scene->material[0].front.bump;
    assert_true(bump->scale == 7.0f && bump->height->kind == TEXTURE_CHECKERBOARD);
    satin_scene_free(scene);
    snprintf(text, sizeof text, bumps, "0.6.0", "<rgb name='scale' value='1 2 3'/>");
    assert_null(scene_case_load(&c, text));
    snprintf(text, sizeof text, bumps, "3.0.0", "");
    scene = scene_case_load(&c, text);
    assert_non_null(scene);
    bump = scene->material[0].front.bump;
    assert_true(bump->scale == 1.0f && bump->height->kind == TEXTURE_SCALED);
    satin_scene_free(scene);
}

// Names, scales and colours that version 3 writes in another way.
static void parameters_keep_their_meaning(void **state) {
    (void)state;
    static const char body[] =
        "<sensor type='perspective'/><shape type='rectangle'><bsdf type='diffuse'>"
        "<texture type='checkerboard' name='diffuseReflectance'><float name='voffset' value='.5'/>"
        "<float name='uscale' value='4'/></texture></bsdf>"
        "<emitter type='area'><spectrum name='radiance' value='2'/></emitter></shape>"
        "<shape type='rectangle'><transform name='toWorld'><translate z='1'/></transform>"
        "<bsdf type='diffuse'><srgb name='reflectance' value='.5'/></bsdf>"
        "<emitter type='area'><blackbody name='radiance' temperature='5000K' scale='.001'/>"
        "</emitter></shape></scene>";
    char text[2048];
    struct scene_case c;
    snprintf(text, sizeof text, "<scene version='0.5.0'>%s", body);
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    const struct texture *texture = scene->material[0].front.slot[BRDF_SLOT_DIFFUSE];
    assert_true(texture->to_uv[0] == 4 && texture->to_uv[4] == 1 && texture->to_uv[5] == 0.5f);
    assert_true(scene->light[0].value.r == 2 && scene->light[0].value.b == 2);
    assert_true(fabsf(scene->light[1].value.r - 15.263024f) < 1e-4f);
    assert_true(fabsf(scene->material[1].front.base.diffuse.g - 0.21404114f) < 1e-6f);
    satin_scene_free(scene);
    // In version 3 these names are wrong.
    snprintf(text, sizeof text, "<scene version='3.0.0'>%s", body);
    assert_null(scene_case_load(&c, text));
    assert_true(c.errors == 1 && strstr(c.error, "unknown element <srgb>"));
}

// A metal without a name is copper, in version 3 it is a mirror; a gamma of -1 is the file's own.
static void defaults_of_version_06_are_kept(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c,
        "<scene version='0.6.0'><sensor type='perspective'/>"
        "<shape type='sphere'><bsdf type='roughconductor'/></shape>"
        "<shape type='sphere'><bsdf type='conductor'><rgb name='k' value='2'/></bsdf></shape>"
        "<shape type='sphere'><bsdf type='conductor'><string name='material' value='none'/>"
        "</bsdf></shape></scene>");
    assert_non_null(scene);
    rgb eta, k;
    assert_true(load_metal_find("Cu", &eta, &k));
    const struct material *m = scene->material;
    assert_true(m[0].front.base.eta.r == eta.r && m[0].front.base.k.g == k.g);
    assert_true(m[1].front.base.eta.r == eta.r && m[1].front.base.k.g == 2.0f);
    assert_true(m[2].front.base.eta.r == 0.0f && m[2].front.base.k.g == 1.0f);
    satin_scene_free(scene);
    assert_null(
        scene_case_load(&c,
                        "<scene version='0.6.0'><sensor type='perspective'/><shape type='sphere'>"
                        "<bsdf type='diffuse'><texture name='reflectance' type='bitmap'>"
                        "<string name='filename' value='none.png'/>"
                        "<float name='gamma' value='-1'/></texture></bsdf></shape></scene>"));
    assert_non_null(strstr(c.error, "none.png"));
}

// The reflectance has two names; a roughness of 0 is meant so.
static void rough_diffuse_surfaces_are_read(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c,
        "<scene version='0.6.0'><sensor type='perspective'/>"
        "<shape type='sphere'><bsdf type='roughdiffuse'/></shape>"
        "<shape type='sphere'><bsdf type='roughdiffuse'><rgb name='diffuseReflectance' value='.2'/>"
        "<float name='alpha' value='0'/><boolean name='useFastApprox' value='true'/></bsdf></shape>"
        "<shape type='sphere'><bsdf type='roughdiffuse'><texture type='gridtexture' name='alpha'/>"
        "<texture type='gridtexture' name='reflectance'/></bsdf></shape></scene>");
    assert_non_null(scene);
    const struct material *m = scene->material;
    assert_true(m[0].front.base.alpha_u == 0.2f && m[0].front.base.diffuse.g == 0.5f);
    assert_false(m[0].front.base.fast);
    assert_true(m[1].front.base.alpha_u == 0.0f && m[1].front.base.diffuse.g == 0.2f);
    assert_true(m[1].front.base.fast);
    assert_true(m[2].front.slot[BRDF_SLOT_ALPHA_U] && m[2].front.slot[BRDF_SLOT_DIFFUSE]);
    satin_scene_free(scene);
}

// These are the textures of that version.
static void textures_of_version_06_are_read(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c,
        "<scene version='0.6.0'><sensor type='perspective'/><emitter type='constant'/>"
        "<shape type='sphere'><bsdf type='diffuse'><texture type='scale' name='reflectance'>"
        "<rgb name='scale' value='.5 .25 1'/><texture type='scale'><float name='scale' value='.5'/>"
        "<texture type='gridtexture'><rgb name='color0' value='1'/><rgb name='color1' value='0'/>"
        "<float name='lineWidth' value='.25'/><float name='uvscale' value='4'/></texture></texture>"
        "</texture></bsdf></shape></scene>");
    assert_non_null(scene);
    const struct material_side *side = &scene->material[0].front;
    const struct texture *outer = side->slot[BRDF_SLOT_DIFFUSE],
                         *inner = scene_texture_unscaled(outer);
    assert_true(c.warnings == 0 && outer->kind == TEXTURE_SCALED && inner->kind == TEXTURE_GRID);
    assert_true(inner->to_uv[0] == 4 && inner->to_uv[4] == 4 && inner->scale == .25f);
    assert_true(side->base.diffuse.r == .0625f && side->base.diffuse.g == .03125f);
    struct texture_lookup at = scene_texture_at((vec2){.125f, .125f});
    assert_true(scene_texture_eval(outer, &at).g == .125f);
    satin_scene_free(scene);
    static const char *const bad[][2] = {
        {"<texture name='reflectance' type='scale'/>", "texture 'scale' takes one <texture>"},
        {"<texture name='reflectance' type='wireframe'/>", "texture 'wireframe' is not supported"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char text[256];
        snprintf(
            text, sizeof text,
            "<scene version='0.6.0'><shape type='sphere'><bsdf type='diffuse'>%s</bsdf></shape>"
            "<sensor type='perspective'/></scene>",
            bad[i][0]);
        assert_null(scene_case_load(&c, text));
        assert_non_null(strstr(c.error, bad[i][1]));
    }
}

// The colours of a PLY file with bytes are decoded from sRGB, unless the shape has linear ones.
static void colours_of_vertices_are_read(void **state) {
    (void)state;
    static const char mesh[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 255 51 0\n1 0 0 255 51 0\n0 1 0 255 51 0\n3 0 1 2\n";
    static const char form[] =
        "<scene version='0.6.0'><sensor type='perspective'/><shape type='%s'>%s"
        "<bsdf type='diffuse'><texture type='vertexcolors' name='reflectance'/></bsdf></shape>"
        "</scene>";
    for (int linear = 0; linear < 2; linear++) {
        struct scene_case c;
        char text[1024], parts[256];
        scene_case_bytes("colours.ply", mesh, sizeof mesh - 1);
        snprintf(parts, sizeof parts, "<string name='filename' value='colours.ply'/>%s",
                 linear ? "<boolean name='srgb' value='false'/>" : "");
        snprintf(text, sizeof text, form, "ply", parts);
        satin_scene *scene = scene_case_load(&c, text);
        assert_non_null(scene);
        struct texture_lookup at = {.mesh = &scene->shape[0].mesh};
        const rgb color = scene_texture_eval(scene->material[0].front.slot[BRDF_SLOT_DIFFUSE], &at);
        assert_true(color.r == 1.0f && color.b == 0.0f);
        assert_float_equal(color.g, linear ? 0.2f : 0.03310477f, 1e-6f);
        satin_scene_free(scene);
    }
    struct scene_case c;
    char text[1024];
    snprintf(text, sizeof text, form, "sphere", "");
    assert_null(scene_case_load(&c, text));
    assert_non_null(strstr(c.error, "shape 'sphere' has no attribute 'vertexcolors'"));
}

static void what_has_no_translation_is_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"<shape type='disk'><bsdf type='roughplastic'>"
         "<string name='distribution' value='zz'/></bsdf></shape>",
         "scene.xml:1:69: distribution: unknown value 'zz'; known are beckmann, ggx"},
        {"<emitter type='sunsky'><vector name='sunDirecton' y='1'/></emitter>",
         "scene.xml:1:47: emitter 'sunsky' has no parameter 'sunDirecton' (did you mean "
         "'sun_direction'?)"},
        {"<shape type='disk'><bsdf type='hk'/></shape>",
         "scene.xml:1:43: BRDF 'hk' is not supported"},
        {"<shape type='disk'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>"
         "<float name='gamma' value='1.8'/></texture></bsdf></shape>",
         "scene.xml:1:106: gamma is '1.8', but must be 1, 2.2 or -1"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        char text[512];
        snprintf(text, sizeof text, "<scene version='0.6.0'>%s<sensor type='perspective'/></scene>",
                 cases[i][0]);
        assert_null(scene_case_load(&c, text));
        assert_int_equal(c.errors, 1);
        assert_int_equal(strncmp(c.error, cases[i][1], strlen(cases[i][1])), 0);
    }
}

#define SENSOR06 "<sensor type='perspective'/>"
#define FILM06(parts) "<sensor type='perspective'><film type='hdrfilm'>" parts "</film></sensor>"

// Reflectances over 1 are scaled as in that version, and what the program itself reads has no
// effect.
static void what_version_06_ignores_is_no_error(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {FILM06("<string name='label[9, 9]' value='$film[&apos;width&apos;]'/>"),
         "film 'hdrfilm' has no parameter 'label[9, 9]', which has no effect"},
        {FILM06("<string name='label' value='$width'/>"), NULL},
        {SENSOR06 "<shape type='disk'><bsdf type='diffuse'>"
                  "<rgb name='reflectance' value='1.5 .75 0' intent='reflectance'/></bsdf></shape>",
         "reflectance is 1.5, and is scaled by 0.66 as in Mitsuba 0.6"},
        {SENSOR06 "<integrator type='multichannel'><integrator type='field'/>"
                  "<integrator type='path'/><integrator type='field'/></integrator>",
         "integrator 'field' has no effect here"},
        {FILM06("<float name='gamma' value='-1'/>"), "'gamma' has no effect here"},
        {SENSOR06 "<integrator type='photonmapper'><integer name='directSamples' value='16'/>"
                  "</integrator>",
         "'directSamples' has no effect here"},
        {SENSOR06 "<bsdf type='hk' id='a'><phase type='hg'/></bsdf>",
         "BRDF 'hk' is not supported; it is not used"},
        {SENSOR06 "<shape type='disk'><bsdf type='phong'><string name='distribution' "
                  "value='phong'/></bsdf></shape>",
         "BRDF 'phong' has no parameter 'distribution', which has no effect"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        char text[512];
        snprintf(text, sizeof text, "<scene version='0.6.0'>%s<emitter type='constant'/></scene>",
                 cases[i][0]);
        satin_scene *scene = scene_case_load(&c, text);
        assert_int_equal(scene != NULL, cases[i][1] != NULL);
        if (!scene) continue;
        assert_non_null(strstr(c.warning, cases[i][1]));
        satin_scene_free(scene);
    }
}

// Shapes that hold a medium are not visible in that version, unless they have a BRDF.
static void containers_of_media_are_not_visible(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, "<scene version='0.6.0'>" SENSOR06
            "<medium type='homogeneous' id='m'/>"
            "<shape type='cube'><ref name='interior' id='m'/></shape>"
            "<shape type='sphere'><medium type='homogeneous' name='interior'/></shape>"
            "<shape type='disk'><ref name='exterior' id='m'/><bsdf type='plastic'/></shape>"
            "<shape type='rectangle'/></scene>");
    static const char *const models[] = {"null", "null", "plastic", "diffuse"};
    assert_non_null(scene);
    for (int i = 0; i < 4; i++)
        assert_string_equal(scene->material[scene->shape[i].material].front.base.model->name,
                            models[i]);
    assert_true(scene->material[scene->shape[0].material].front.base.transmittance.g == 1.0f);
    satin_scene_free(scene);
}

// Parameters of that version beside those of the same meaning, and what satin does with them.
static void files_of_other_programs_are_read(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c,
        "<scene version='0.6.0'><sensor type='perspective'/>"
        "<bsdf type='diffuse'><float name='intIOR' value='1'/></bsdf>"
        "<shape type='sphere'><boolean name='faceNormals' value='true'/>"
        "<bsdf type='conductor' id='a'><float name='extEta' value='2'/><float name='alpha' "
        "value='.1'/><rgb name='eta' value='2'/><spectrum name='k' value='4, 6, 8'/></bsdf></shape>"
        "<shape type='sphere'><bsdf type='phong' id='b'>"
        "<rgb name='diffuseReflectance' value='.5 .4 .2'/>"
        "<rgb name='specularReflectance' value='1 .6 .2'/></bsdf></shape>"
        "<shape type='disk'><bsdf type='bump'><texture type='checkerboard'/>"
        "<bsdf type='roughconductor'><string name='distribution' value='as'/>"
        "<float name='alphaU' value='.2'/><float name='alphaV' value='.1'/></bsdf></bsdf></shape>"
        "<emitter type='sunsky'><float name='turbidity' value='4'/><float name='scale' value='3'/>"
        "<float name='skyScale' value='2'/></emitter></scene>");
    assert_non_null(scene);
    const struct brdf *a = &scene->material[0].front.base, *b = &scene->material[1].front.base;
    assert_true(a->eta.r == 1.0f && a->k.r == 2.0f && a->k.g == 3.0f && a->k.b == 4.0f);
    // A sum of 1.5 is scaled to .99.
    assert_float_equal(b->diffuse.r, .33f, 1e-6f);
    assert_float_equal(b->specular.r, .66f, 1e-6f);
    assert_float_equal(b->specular.b, .132f, 1e-6f);
    const struct material_side *facets = &scene->material[2].front;
    assert_non_null(facets->bump[0].height);
    assert_true(facets->base.distribution == BRDF_BECKMANN && facets->base.alpha_v == .1f);
    const struct light *sky = &scene->light[scene->environment];
    assert_true(sky->value.g == 6.0f && sky->sun.y > 0.5f && sky->sun.x < 0.0f);
    // There are warnings for parameters without effect of BRDFs and of shapes, the sum, the
    // distribution, and spheres at one position.
    assert_int_equal(c.warnings, 5);
    satin_scene_free(scene);
}

static void unknown_integrators_samplers_and_films_are_accepted(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c,
        "<scene version='3.0.0'><integrator type='stokes'><integrator type='path'>"
        "<integer name='max_depth' value='7'/></integrator></integrator>"
        "<sensor type='perspective'><sampler type='blue_noise'>"
        "<integer name='sample_count' value='9'/></sampler>"
        "<film type='zarr'><integer name='width' value='40'/><rfilter type='wendland'/></film>"
        "</sensor></scene>");
    assert_non_null(scene);
    assert_true(scene->hints.max_depth == 7 && scene->hints.spp == 9 && scene->film.width == 40);
    assert_int_equal(c.warnings, 4);
    satin_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_version_06_are_translated),
        cmocka_unit_test(the_first_key_of_an_animation_is_taken),
        cmocka_unit_test(the_scale_of_bumps_is_moved),
        cmocka_unit_test(parameters_keep_their_meaning),
        cmocka_unit_test(defaults_of_version_06_are_kept),
        cmocka_unit_test(colours_of_vertices_are_read),
        cmocka_unit_test(what_has_no_translation_is_refused),
        cmocka_unit_test(what_version_06_ignores_is_no_error),
        cmocka_unit_test(containers_of_media_are_not_visible),
        cmocka_unit_test(rough_diffuse_surfaces_are_read),
        cmocka_unit_test(textures_of_version_06_are_read),
        cmocka_unit_test(files_of_other_programs_are_read),
        cmocka_unit_test(unknown_integrators_samplers_and_films_are_accepted)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
