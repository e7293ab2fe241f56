// SPDX-License-Identifier: Apache-2.0
// Mixtures of version 0.6 and normal maps of one value.
#include "scene_case.h"

#include "scene/scene.h"

static satin_scene *load_bsdf(struct scene_case *c, const char *bsdf) {
    char text[1024];
    snprintf(text, sizeof text, SCENE_TEXT("<shape type='disk'>%s</shape>"), bsdf);
    return scene_case_load(c, text);
}

#define MIXTURE(weights, parts) \
    "<bsdf type='mixturebsdf'><string name='weights' value='" weights "'/>" parts "</bsdf>"
#define GREY(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"

// The weighted sum of the diffuse reflectances of a tree.
static float tree_albedo(const struct material_side *side) {
    if (!side->component[0]) return side->base.diffuse.r;
    return (1.0f - side->weight) * tree_albedo(side->component[0]) +
           side->weight * tree_albedo(side->component[1]);
}

static void mixtures_are_weighted_sums(void **state) {
    (void)state;
    static const struct {
        const char *bsdf;
        float albedo;
        int warnings;
    } cases[] = {
        {MIXTURE("1", GREY(".5")), .5f, 0},
        {MIXTURE("0.3, 0.7", GREY(".5") GREY("1")), .85f, 0},
        {MIXTURE(".25 .25 .5", GREY("0") GREY("1") GREY(".2")), .35f, 0},
        {MIXTURE(".2 .3", GREY("1") GREY(".5")), .35f, 0},
        {MIXTURE("0 .4", GREY("1") GREY(".5")), .2f, 0},
        {MIXTURE("0 0", GREY("1") GREY(".5")), 0.0f, 0},
        {MIXTURE("1 3", GREY("1") GREY(".2")), .4f, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        satin_scene *scene = load_bsdf(&c, cases[i].bsdf);
        assert_non_null(scene);
        assert_float_equal(tree_albedo(&scene->material[0].front), cases[i].albedo, 1e-6f);
        assert_int_equal(c.warnings, cases[i].warnings);
        satin_scene_free(scene);
    }
}

static void a_mixture_with_a_two_sided_part_has_two_sides(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene =
        load_bsdf(&c, MIXTURE(".5 .5", GREY("1") "<bsdf type='twosided'>" GREY(".2") "</bsdf>"));
    assert_non_null(scene);
    const struct material *m = &scene->material[0];
    assert_true(m->two_sided && m->back.component[0]->one_sided);
    assert_false(m->back.component[1]->one_sided);
    satin_scene_free(scene);
}

static void wrong_mixtures_are_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {MIXTURE(".5 .5", GREY("1")), "mixturebsdf has 1 <bsdf>s, but 2 weights"},
        {MIXTURE(".5 x", GREY("1") GREY("1")), "'x' is not a number"},
        {MIXTURE(".5 -1", GREY("1") GREY("1")), "a weight is -1, but must be 0 to 1e6"},
        {MIXTURE("1", ""), "mixturebsdf takes 1 to 16 <bsdf>s"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        assert_null(load_bsdf(&c, cases[i][0]));
        assert_non_null(strstr(c.error, cases[i][1]));
    }
}

static void diffuse_transmission_is_that_of_a_thin_sheet(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene =
        load_bsdf(&c, "<bsdf type='difftrans'><rgb name='transmittance' value='.6 .7 .3'/></bsdf>");
    assert_non_null(scene);
    const struct brdf *b = &scene->material[0].front.base;
    assert_ptr_equal(b->model, brdf_find("principledthin"));
    assert_true(b->diff_trans == 2.0f && b->spec_trans == 0.0f && b->diffuse.g == .7f);
    rgb diffuse, glossy;
    b->model->eval(b, v3(0, 0, 1), v3(0, 0, 1), &diffuse, &glossy);
    assert_true(rgb_black(diffuse) && rgb_black(glossy));
    satin_scene_free(scene);
}

static void a_colour_is_one_normal(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = load_bsdf(&c,
                                   "<bsdf type='normalmap'><rgb name='normalmap' value='.7 .5 .9'/>"
                                   "<bsdf type='diffuse'/></bsdf>");
    assert_non_null(scene);
    const struct texture *normal = scene->material[0].front.bump[0].normal;
    assert_non_null(normal);
    assert_true(normal->kind == TEXTURE_CONSTANT && normal->value.r == .7f);
    satin_scene_free(scene);
    assert_null(load_bsdf(&c, "<bsdf type='normalmap'><bsdf type='diffuse'/></bsdf>"));
    assert_non_null(strstr(c.error, "needs a <texture> or the parameter 'normalmap'"));
}

// The map of version 0.6 has no name.
static void any_texture_inside_is_the_normal_map(void **state) {
    (void)state;
    static const char *const names[] = {"", "name='normalmap'", "name='map'"};
    struct scene_case c;
    char text[256];
    for (int i = 0; i < 3; i++) {
        snprintf(text, sizeof text,
                 "<bsdf type='normalmap'><texture %s type='checkerboard'/>"
                 "<bsdf type='diffuse'/></bsdf>",
                 names[i]);
        satin_scene *scene = load_bsdf(&c, text);
        assert_non_null(scene);
        assert_true(scene->material[0].front.bump[0].normal->kind == TEXTURE_CHECKERBOARD);
        satin_scene_free(scene);
    }
    assert_null(load_bsdf(&c,
                          "<bsdf type='normalmap'><texture type='checkerboard'/>"
                          "<rgb name='normalmap' value='.7 .5 .9'/><bsdf type='diffuse'/></bsdf>"));
    assert_non_null(strstr(c.error, "normalmap takes one <texture>"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mixtures_are_weighted_sums),
        cmocka_unit_test(a_mixture_with_a_two_sided_part_has_two_sides),
        cmocka_unit_test(wrong_mixtures_are_refused),
        cmocka_unit_test(diffuse_transmission_is_that_of_a_thin_sheet),
        cmocka_unit_test(any_texture_inside_is_the_normal_map),
        cmocka_unit_test(a_colour_is_one_normal),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
