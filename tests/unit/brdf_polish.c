// SPDX-License-Identifier: Apache-2.0
// Polished surfaces: which ones are, and that their delta lobe has the directions and weights of
// the glossy lobe that it replaces.
#include "satin/scene.h"

#include "brdf/brdf.h"
#include "scene/scene.h"
#include "scene_case.h"

static struct brdf polish_case_make(const char *model, float alpha, struct arena *arena) {
    struct brdf b = {.model = brdf_find(model),
                     .diffuse = {0.5f, 0.5f, 0.5f},
                     .specular = {1, 1, 1},
                     .eta = {0.2f, 0.9f, 1.1f},
                     .k = {3.9f, 2.4f, 2.2f},
                     .ior = 1.5f,
                     .alpha_u = alpha,
                     .alpha_v = alpha,
                     .distribution = BRDF_GGX};
    assert_int_equal(brdf_prepare(&b, arena, NULL), SATIN_OK);
    return b;
}

static void only_smooth_surfaces_are_polished(void **state) {
    (void)state;
    struct arena arena = {0};
    struct brdf smooth = polish_case_make("roughconductor", BRDF_POLISHED, &arena);
    struct brdf rough = polish_case_make("roughconductor", 1.1f * BRDF_POLISHED, &arena);
    brdf_polish(&smooth);
    brdf_polish(&rough);
    assert_true(brdf_is_polished(&smooth) && !brdf_is_polished(&rough));
    assert_int_equal(brdf_lobes(&smooth), BRDF_DELTA);
    struct brdf one = polish_case_make("roughconductor", 0.001f, &arena);  // rough along y
    one.alpha_v = 0.3f;
    brdf_polish(&one);
    assert_false(brdf_is_polished(&one));
    struct brdf diffuse = polish_case_make("diffuse", 0.0f, &arena);
    brdf_polish(&diffuse);
    assert_false(brdf_is_polished(&diffuse));
    arena_free(&arena);
}

static void a_facet_reflects_as_the_glossy_lobe(void **state) {
    (void)state;
    struct arena arena = {0};
    const struct brdf rough = polish_case_make("roughconductor", 0.008f, &arena);
    struct brdf b = rough;
    brdf_polish(&b);
    for (int k = 0; k < 1000; k++) {
        const float z = 0.05f + 0.9f * (float)(k % 10) / 9.0f;
        const vec3 wo = v3(sqrtf(1.0f - z * z), 0.0f, z);
        const vec2 u = {((float)(k % 100) + 0.5f) / 100.0f, ((float)(k / 10) + 0.5f) / 100.0f};
        struct brdf_sample delta, glossy;
        const bool reflects = brdf_sample_wi(&b, wo, 0.0f, u, BRDF_DELTA, BRDF_RADIANCE, &delta);
        assert_int_equal(reflects,
                         brdf_sample_wi(&rough, wo, 0.0f, u, BRDF_GLOSSY, BRDF_RADIANCE, &glossy));
        if (!reflects) continue;
        assert_int_equal(delta.lobe, BRDF_DELTA);
        assert_true(delta.pdf_w == 0.0f);
        assert_true(v3_dist2(delta.wi, glossy.wi) == 0.0f);
        assert_true(fabsf(delta.weight.g - glossy.weight.g) < 1e-4f * glossy.weight.g);
    }
    const vec3 wo = v3(0.6f, 0.0f, 0.8f);
    const rgb before = brdf_albedo(&rough, wo, BRDF_ALL), after = brdf_albedo(&b, wo, BRDF_ALL);
    assert_true(fabsf(before.g - after.g) < 0.01f);
    arena_free(&arena);
}

#define MIRROR                                                                                    \
    "<bsdf type='twosided'><bsdf type='roughconductor'><float name='alpha' value='.005'/></bsdf>" \
    "</bsdf>"

static bool loads_polished(const char *text) {
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, text);
    if (!scene) fail_msg("%s", c.error);
    const struct material *m = scene->material;
    const bool front = brdf_is_polished(&m->front.base), back = brdf_is_polished(&m->back.base);
    assert_int_equal(front, back);
    satin_scene_free(scene);
    return front;
}

// A light without an extent is only found by light samples, which a delta lobe does not have.
static void a_light_without_extent_prevents_polish(void **state) {
    (void)state;
    assert_true(loads_polished(SCENE_TEXT("<shape type='disk'>" MIRROR "</shape>")));
    assert_true(loads_polished(SCENE_TEXT("<shape type='disk'>" MIRROR "</shape>"
                                          "<emitter type='constant'/>")));
    assert_false(loads_polished(SCENE_TEXT("<shape type='disk'>" MIRROR "</shape>"
                                           "<emitter type='point'/>")));
    assert_false(loads_polished(SCENE_TEXT("<shape type='disk'>" MIRROR "</shape>"
                                           "<emitter type='directional'/>")));
}

static void textured_roughness_is_not_polished(void **state) {
    (void)state;
    assert_false(loads_polished(
        SCENE_TEXT("<shape type='disk'><bsdf type='twosided'><bsdf type='roughconductor'>"
                   "<texture type='checkerboard' name='alpha'>"
                   "<rgb name='color0' value='.001'/><rgb name='color1' value='.4'/></texture>"
                   "</bsdf></bsdf></shape>")));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_smooth_surfaces_are_polished),
        cmocka_unit_test(a_facet_reflects_as_the_glossy_lobe),
        cmocka_unit_test(a_light_without_extent_prevents_polish),
        cmocka_unit_test(textured_roughness_is_not_polished),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
