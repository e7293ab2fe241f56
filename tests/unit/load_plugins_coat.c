// SPDX-License-Identifier: Apache-2.0
// Coats of version 0.6: their parameters in both spellings, what they wrap, and what they do not.
#include "scene_case.h"

#include "scene/scene.h"

static satin_scene *load_coat(struct scene_case *c, const char *bsdf) {
    char text[2048];
    snprintf(text, sizeof text,
             "<scene version='0.6.0'><sensor type='perspective'/>\n<shape type='disk'>\n%s\n"
             "</shape></scene>",
             bsdf);
    return scene_case_load(c, text);
}

#define GREY "<bsdf type='diffuse'><rgb name='reflectance' value='.5'/></bsdf>"
#define COAT(parts) "<bsdf type='coating'>" parts "</bsdf>"
#define ROUGH(parts) "<bsdf type='roughcoating'>" parts "</bsdf>"
#define WEIGHT "<float name='weight' value='.25'/>"

static void parameters_of_coats_are_read(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = load_coat(
        &c, COAT("<float name='intIOR' value='1.8'/><string name='extIOR' value='water'/>"
                 "<float name='thickness' value='2'/><rgb name='sigmaA' value='.1 .2 .4'/>"
                 "<rgb name='specularReflectance' value='.5 .6 .7'/>" GREY));
    assert_non_null(scene);
    const struct brdf *b = &scene->material[0].front.base;
    assert_true(b->coat && b->coat_depth.r == .2f && b->coat_depth.b == .8f);
    assert_true(b->coat_specular.g == .6f && b->diffuse.g == .5f);
    assert_string_equal(b->model->name, "coating over diffuse");
    struct brdf_sample s[2];
    assert_int_equal(brdf_delta(b, v3(0, 0, 1), BRDF_RADIANCE, s), 1);
    assert_float_equal(s[0].weight.r, .5f * sqrf((1.8f - 1.333f) / (1.8f + 1.333f)), 1e-5f);
    satin_scene_free(scene);
}

static void rough_coats_have_a_roughness(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = load_coat(
        &c, ROUGH("<float name='alpha' value='.3'/><string name='distribution' value='ggx'/>"
                  "<bsdf type='conductor'/>"));
    assert_non_null(scene);
    const struct brdf *b = &scene->material[0].front.base;
    assert_int_equal(brdf_lobes(b), BRDF_GLOSSY | BRDF_DELTA);
    assert_true(brdf_eval(b, v3(0, 0, 1), v3(0, 0, 1), BRDF_ALL).g > 0.0f);
    satin_scene_free(scene);
}

// Textures of the coat are slots of the nested BRDF's side.
static void coats_are_textured(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = load_coat(
        &c, COAT("<float name='thickness' value='2'/><texture name='sigmaA' type='checkerboard'>"
                 "<rgb name='color0' value='1'/><rgb name='color1' value='0'/></texture>"
                 "<texture name='specularReflectance' type='checkerboard'>"
                 "<rgb name='color0' value='1'/><rgb name='color1' value='0'/></texture>" GREY));
    assert_non_null(scene);
    const struct material_side *side = &scene->material[0].front;
    assert_true(side->base.coat_depth.g == 1.0f && side->base.coat_specular.g == .5f);
    const struct texture_lookup at = scene_texture_at((vec2){.25f, .25f});
    assert_true(scene_texture_eval(side->slot[BRDF_SLOT_COAT_DEPTH], &at).g == 2.0f);
    assert_true(scene_texture_eval(side->slot[BRDF_SLOT_COAT_SPECULAR], &at).g == 1.0f);
    satin_scene_free(scene);
}

// A coat over others is over each of their leaves.
static void coats_wrap_what_does_not_transmit(void **state) {
    (void)state;
    static const char *const inner[] = {
        "<bsdf type='blendbsdf'>" WEIGHT GREY "<bsdf type='phong'/></bsdf>",
        "<bsdf type='mixturebsdf'><string name='weights' value='.5 .5'/>" GREY
        "<bsdf type='plastic'/></bsdf>",
        "<bsdf type='twosided'>" GREY "<bsdf type='roughplastic'/></bsdf>",
        "<bsdf type='bumpmap'><texture type='checkerboard'/>" GREY "</bsdf>",
        "<bsdf type='principled'/>"};
    for (size_t i = 0; i < sizeof inner / sizeof *inner; i++) {
        struct scene_case c;
        char text[1024];
        snprintf(text, sizeof text, ROUGH("%s"), inner[i]);
        satin_scene *scene = load_coat(&c, text);
        assert_non_null(scene);
        const struct material *m = &scene->material[0];
        const struct material_side *front = &m->front, *back = &m->back;
        if (front->component[0]) {
            assert_true(front->component[0]->base.coat && front->component[1]->base.coat);
            front = back = front->component[1];
        }
        assert_true(front->base.coat && back->base.coat);
        assert_true(m->two_sided == (i == 2));
        satin_scene_free(scene);
    }
}

static void wrong_coats_are_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {COAT(""), "scene.xml:3:1: coating takes one <bsdf>"},
        {COAT(GREY GREY), "scene.xml:3:1: coating takes one <bsdf>"},
        {COAT("<bsdf type='dielectric'/>"),
         "scene.xml:3:1: 'dielectric' transmits, so it cannot have a coat"},
        {COAT("<bsdf type='difftrans'/>"),
         "scene.xml:3:1: 'principledthin' transmits, so it cannot have a coat"},
        {ROUGH("<bsdf type='mask'>" GREY "</bsdf>"),
         "scene.xml:3:1: BRDF 'roughcoating': it cannot wrap a mask or null; a mask may be "
         "around it"},
        {COAT(ROUGH(GREY)), "scene.xml:3:1: BRDF 'coating': a coat cannot wrap another one"},
        {COAT("<float name='intIOR' value='1000'/>" GREY),
         "scene.xml:3:1: int_ior / ext_ior is 999.72"},
        {ROUGH("<float name='intIOR' value='1'/><float name='extIOR' value='1'/>" GREY),
         "scene.xml:3:1: BRDF 'roughcoating': int_ior and ext_ior must differ"},
        {COAT("<float name='thickness' value='-1'/>" GREY), "scene.xml:3:22: thickness is -1"},
        {ROUGH("<texture name='alpha' type='checkerboard'/>" GREY), "scene.xml:3:27: "}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        if (load_coat(&c, cases[i][0])) fail_msg("%s is read", cases[i][0]);
        assert_int_equal(c.errors, 1);
        if (strncmp(c.error, cases[i][1], strlen(cases[i][1])) != 0)
            assert_string_equal(c.error, cases[i][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parameters_of_coats_are_read),
        cmocka_unit_test(rough_coats_have_a_roughness),
        cmocka_unit_test(coats_are_textured),
        cmocka_unit_test(coats_wrap_what_does_not_transmit),
        cmocka_unit_test(wrong_coats_are_refused),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
