// SPDX-License-Identifier: Apache-2.0
// roughplastic of a textured roughness: its diffuse lobe is that of a constant one, for values,
// albedos and probabilities.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "brdf/brdf.h"

static const float IORS[] = {1.1f, 1.49f, 1.9f};
// The bounds of src/brdf/brdf_plastic.c, as fractions.
static const double EVAL_BOUND = 0.009, ALBEDO_BOUND = 0.013;

static struct brdf plastic_make(float ior, int k, float alpha, bool textured, struct arena *arena) {
    struct brdf b = {.model = brdf_find("roughplastic"),
                     .diffuse = {0.8f, 0.5f, 0.1f},
                     .specular = {1.0f, 1.0f, 1.0f},
                     .ior = ior,
                     .alpha_u = alpha,
                     .alpha_v = alpha,
                     .distribution = k & 1 ? BRDF_GGX : BRDF_BECKMANN,
                     .nonlinear = k & 2,
                     .rough_texture = textured};
    assert_int_equal(brdf_prepare(&b, arena, NULL), SATIN_OK);
    return b;
}

static vec3 at_cosine(float z, float side) { return v3(side * sqrtf(1.0f - z * z), 0.0f, z); }

static double relative(float got, float want) { return fabs((double)got / (double)want - 1.0); }

static void same_values(const struct brdf *got, const struct brdf *want) {
    for (int i = 0; i < 64; i++) {
        const vec3 wo = at_cosine(((float)(i % 8) + 0.5f) / 8.0f, 1.0f);
        const vec3 wi = at_cosine(((float)(i / 8) + 0.5f) / 8.0f, -1.0f);
        const rgb g = brdf_eval(got, wo, wi, BRDF_DIFFUSE), w = brdf_eval(want, wo, wi, 1);
        assert_true(relative(g.r, w.r) < EVAL_BOUND && relative(g.b, w.b) < EVAL_BOUND);
    }
    for (int i = 0; i < 32; i++) {
        const vec3 wo = at_cosine(((float)i + 0.5f) / 32.0f, 1.0f);
        const float g = brdf_albedo(got, wo, BRDF_DIFFUSE).g;
        assert_true(relative(g, brdf_albedo(want, wo, BRDF_DIFFUSE).g) < ALBEDO_BOUND);
    }
}

static void textured_roughness_is_that_of_a_constant(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++) {
            struct arena arena = {0};
            struct brdf got = plastic_make(IORS[i], k, 0.1f, true, &arena);
            for (float alpha = 3e-4f; alpha < 4.0f; alpha *= 1.37f) {
                const struct brdf want = plastic_make(IORS[i], k, alpha, false, &arena);
                got.alpha_u = alpha;
                same_values(&got, &want);
            }
            arena_free(&arena);
        }
}

// Textures have any value, and a beam widens the glossy lobe alone.
static void any_roughness_has_a_value(void **state) {
    (void)state;
    struct arena arena = {0};
    struct brdf b = plastic_make(1.49f, 1, 0.1f, true, &arena);
    static const float alphas[] = {0.0f, 1e-4f, 5.0f, 1e6f};
    const vec3 wo = at_cosine(0.5f, 1.0f), wi = at_cosine(0.7f, -1.0f);
    for (int i = 0; i < 4; i++) {
        b.alpha_u = alphas[i];
        const float f = brdf_eval(&b, wo, wi, BRDF_DIFFUSE).g;
        assert_true(f > 0.0f && f < 1.0f);
    }
    b.alpha_u = 0.1f;
    struct brdf beam = b;
    beam.alpha_least = 0.4f;
    assert_true(brdf_eval(&b, wo, wi, BRDF_DIFFUSE).g == brdf_eval(&beam, wo, wi, BRDF_DIFFUSE).g);
    arena_free(&arena);
}

static struct brdf brdf_plastic_paint(float roughness, bool textured, float grey) {
    return (struct brdf){.model = brdf_find("roughplastic"),
                         .diffuse = rgb_grey(grey),
                         .specular = rgb_grey(1.0f),
                         .alpha_u = roughness,
                         .alpha_v = roughness,
                         .ior = 1.5f,
                         .rough_texture = textured};
}

// Paints of many colours have the tables of one, and those of other roughness their own.
static void tables_are_made_once_per_shape(void **state) {
    (void)state;
    struct arena arena = {0};
    const struct brdf_glossy *made = NULL;
    struct brdf first = brdf_plastic_paint(0.2f, false, 0.5f),
                alone = brdf_plastic_paint(0.2f, false, 0.7f), same = alone,
                rougher = brdf_plastic_paint(0.3f, false, 0.5f),
                textured = brdf_plastic_paint(0.2f, true, 0.5f);
    assert_int_equal(brdf_prepare(&alone, &arena, NULL), SATIN_OK);
    assert_int_equal(brdf_prepare(&first, &arena, &made), SATIN_OK);
    assert_int_equal(brdf_prepare(&rougher, &arena, &made), SATIN_OK);
    assert_int_equal(brdf_prepare(&textured, &arena, &made), SATIN_OK);
    const size_t bytes = arena.bytes;
    assert_int_equal(brdf_prepare(&same, &arena, &made), SATIN_OK);
    assert_int_equal(arena.bytes, bytes);
    assert_ptr_equal(same.tables, first.tables);
    assert_ptr_not_equal(rougher.tables, first.tables);
    assert_ptr_not_equal(textured.tables, first.tables);
    const vec3 wo = v3_unit(v3(0.3f, 0.2f, 0.6f)), wi = v3_unit(v3(-0.5f, 0.1f, 0.4f));
    const rgb a = brdf_eval(&same, wo, wi, BRDF_SMOOTH), b = brdf_eval(&alone, wo, wi, BRDF_SMOOTH);
    assert_memory_equal(&a, &b, sizeof a);
    const rgb all = brdf_albedo(&same, wo, BRDF_ALL), other = brdf_albedo(&alone, wo, BRDF_ALL);
    assert_memory_equal(&all, &other, sizeof all);
    arena_free(&arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(textured_roughness_is_that_of_a_constant),
        cmocka_unit_test(any_roughness_has_a_value),
        cmocka_unit_test(tables_are_made_once_per_shape),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
