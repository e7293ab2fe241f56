// SPDX-License-Identifier: Apache-2.0
// Tables of harmonics: orders by what is reflected, lookups between and at nodes, symmetries.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "base/sampling.h"
#include "brdf/brdf.h"
#include "brdf/brdf_project.h"

static struct brdf phong(float exponent) {
    return (struct brdf){.model = brdf_find("phong"), .specular = {1, 1, 1}, .exponent = exponent};
}

static struct brdf ward(float alpha_u, float alpha_v) {
    return (struct brdf){
        .model = brdf_find("ward"), .specular = {1, 1, 1}, .alpha_u = alpha_u, .alpha_v = alpha_v};
}

static struct brdf brdf_table_metal(float alpha, rgb eta) {
    return (struct brdf){.model = brdf_find("roughconductor"),
                         .specular = {1, 1, 1},
                         .eta = eta,
                         .k = {3, 3, 3},
                         .alpha_u = alpha,
                         .alpha_v = alpha,
                         .distribution = BRDF_GGX};
}

static vec3 brdf_table_direction(float degrees, float phi) {
    float theta = degrees * PI_F / 180.0f;
    return v3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
}

static struct brdf_table *test_brdf_table_build(const struct brdf *b, satin_basis basis, int order,
                                                float error, int threads) {
    struct parallel *pool = parallel_new(threads);
    struct brdf_table *table = NULL;
    assert_non_null(pool);
    const struct brdf_fit fit = {basis, order, error, false};
    assert_int_equal(brdf_table_build(b, &fit, pool, &table), SATIN_OK);
    parallel_free(pool);
    return table;
}

// The rms of the light that a lobe reflects beyond order n, relative to the rms of all, over
// `draws` random lights whose coefficients have power (l + 1)^-3.
static double reflected_error(const float c[196], int n, int draws) {
    struct rng rng = rng_make(9, RNG_TEST, 0);
    double rest = 0.0, all = 0.0;
    for (int i = 0; i < draws; i++) {
        double sum = 0.0, beyond = 0.0;
        for (int l = 0, k = 0; l < 14; l++)
            for (; k < (l + 1) * (l + 1); k++) {
                // They are uniform in [-1, 1], so that all have the variance 1/3.
                double light = (2.0 * (double)rng_float(&rng) - 1.0) / pow(l + 1.0, 1.5);
                double part = light * (double)c[k];
                sum += part;
                if (l >= n) beyond += part;
            }
        rest += beyond * beyond;
        all += sum * sum;
    }
    return sqrt(rest / all);
}

// The order is the least one that keeps the error of reflected radiance within the bound. 4000
// draws give a relative rms to about 2 %; the power beyond order 14 is below .1 % of all here.
static void orders_bound_what_is_reflected(void **state) {
    (void)state;
    const struct brdf brdfs[] = {phong(5), phong(15), phong(22), ward(0.4f, 0.4f)};
    struct project_points *points = malloc(sizeof *points);
    struct project_rule rule;
    brdf_project_rule_make(&rule);
    assert_non_null(points);
    for (size_t i = 0; i < sizeof brdfs / sizeof *brdfs; i++)
        for (int basis = 0; basis < 2; basis++) {
            struct brdf_table *table =
                test_brdf_table_build(&brdfs[i], basis ? SATIN_SH : SATIN_HSH, 14, 0.01f, 2);
            for (float degrees = 5; degrees < 60; degrees += 25) {
                float c[196] = {0};
                const struct project_target target = {basis ? RSH_SPHERE : RSH_HEMISPHERE, 14, 1,
                                                      false};
                brdf_project_glossy(&brdfs[i], brdf_table_direction(degrees, 0), target, &rule,
                                    points, c);
                int n = brdf_table_order(table, brdf_table_direction(degrees, 0));
                assert_true(n > 2 && reflected_error(c, n, 4000) < 1.06 * 0.01);
                assert_true(reflected_error(c, n - 1, 4000) > 0.94 * 0.01);
            }
            brdf_table_free(table);
        }
    free(points);
}

static void sharp_edges_at_grazing_angles_are_not_held(void **state) {
    (void)state;
    struct brdf b = ward(0.6f, 0.25f);
    struct brdf_table *table = test_brdf_table_build(&b, SATIN_HSH, 10, 0.01f, 2);
    assert_true(brdf_table_order(table, v3(0, 0, 1)) > 0);
    assert_int_equal(brdf_table_order(table, brdf_table_direction(85, 0)), 0);
    assert_int_equal(brdf_table_order(table, v3(0, 0, -1)), 0);
    float fraction = brdf_table_describe(table).fraction;
    assert_true(fraction > 0.4f && fraction < 0.95f);
    brdf_table_free(table);
    b = phong(15);
    table = test_brdf_table_build(&b, SATIN_HSH, 10, 0.01f, 2);
    assert_int_equal(brdf_table_describe(table).channels, 1);
    assert_true(brdf_table_describe(table).fraction == 1.0f);
    brdf_table_free(table);
}

// Distance of looked-up coefficients from a direct projection, over the lobe's norm.
static double lookup_error(const struct brdf *b, const struct brdf_table *table, rsh_basis basis,
                           vec3 wo, struct project_points *points) {
    float got[300], want[300] = {0};
    struct project_rule rule;
    int n = brdf_table_lookup(table, wo, got), channels = brdf_table_describe(table).channels;
    if (!n) return 0.0;
    assert_int_equal(n, brdf_table_order(table, wo));
    brdf_project_rule_make(&rule);
    const struct project_target target = {basis, n, channels, false};
    double norm = brdf_project_glossy(b, wo, target, &rule, points, want);
    double error = 0.0;
    for (int i = 0; i < channels * n * n; i++) error += pow((double)(got[i] - want[i]), 2);
    return sqrt(error / norm);
}

// Rotating an isotropic lobe, mirroring an anisotropic one, and interpolating between nodes, all
// against direct projection. The bounds are twice the largest error over 3,000 directions; only the
// anisotropic map, near the horizon, comes close to its own.
static void lookups_agree_with_projection(void **state) {
    (void)state;
    const rgb gold = {.2f, .5f, 1.4f};
    const struct {
        struct brdf b;
        satin_basis basis;
        int order;
        double bound;
    } cases[] = {
        {phong(22), SATIN_HSH, 10, 2e-4},
        {phong(3), SATIN_SH, 10, 2e-4},
        {brdf_table_metal(0.3f, gold), SATIN_HSH, 8, 2e-4},
        {ward(0.25f, 0.6f), SATIN_HSH, 7, 1e-2},
    };
    struct project_points *points = malloc(sizeof *points);
    assert_non_null(points);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct brdf_table *table =
            test_brdf_table_build(&cases[i].b, cases[i].basis, cases[i].order, 0.2f, 2);
        rsh_basis basis = brdf_rsh_basis(cases[i].basis);
        struct rng rng = rng_make(5, RNG_TEST, i);
        for (int k = 0; k < 60; k++) {
            vec3 wo = sample_cosine_hemisphere(rng_float(&rng), rng_float(&rng));
            assert_true(lookup_error(&cases[i].b, table, basis, wo, points) < cases[i].bound);
        }
        brdf_table_free(table);
    }
    free(points);
}

// Constant light has one hemispherical coefficient, sqrt(2 pi), so the dot product is the glossy
// albedo; that of Phong at normal incidence is exactly 1.
static void constant_light_gives_the_albedo(void **state) {
    (void)state;
    float c[300];
    struct brdf b = phong(15);
    struct brdf_table *table = test_brdf_table_build(&b, SATIN_HSH, 10, 0.05f, 1);
    assert_true(brdf_table_lookup(table, v3(0, 0, 1), c) > 0);
    assert_true(fabsf(c[0] * sqrtf(2.0f * PI_F) - 1.0f) < 2e-4f);
    for (float degrees = 10; degrees < 80; degrees += 15) {
        vec3 wo = brdf_table_direction(degrees, 2.0f);
        double mean = 0.0;
        for (uint32_t i = 0; i < 16384; i++) {
            vec2 u = sample_sobol2(i, 7);
            struct brdf_sample s;
            if (brdf_sample_wi(&b, wo, 0.5f, u, BRDF_GLOSSY, BRDF_RADIANCE, &s))
                mean += (double)s.weight.g / 16384;
        }
        assert_true(brdf_table_lookup(table, wo, c) > 0);
        assert_true(fabs((double)c[0] * sqrt(2.0 * M_PI) - mean) < 1e-3);
    }
    brdf_table_free(table);
}

static void channels_stay_apart(void **state) {
    (void)state;
    struct brdf b = brdf_table_metal(0.4f, (rgb){.2f, .5f, 1.4f});
    b.specular = (rgb){0, 1, 0};  // taken as 1
    struct brdf_table *table = test_brdf_table_build(&b, SATIN_HSH, 6, 0.05f, 1);
    float c[108];
    int n = brdf_table_lookup(table, v3(0, 0, 1), c);
    assert_true(n > 0);
    assert_int_equal(brdf_table_describe(table).channels, 3);
    assert_true(c[0] > c[n * n] && c[n * n] > c[2 * n * n] && c[2 * n * n] > 0.0f);
    brdf_table_free(table);
}

static void sharp_lobes_and_bad_arguments_are_refused(void **state) {
    (void)state;
    for (float alpha = 0.0001f; alpha < 0.06f; alpha *= 5.0f) {
        struct brdf b = brdf_table_metal(alpha, (rgb){1, 1, 1});
        struct brdf_table *table = test_brdf_table_build(&b, SATIN_HSH, 10, 0.05f, 2);
        float c[100] = {42.0f};
        assert_int_equal(brdf_table_describe(table).order, 0);
        assert_int_equal(brdf_table_lookup(table, v3(0, 0, 1), c), 0);
        assert_true(c[0] == 42.0f);
        brdf_table_free(table);
    }
    struct brdf b = {.model = brdf_find("diffuse"), .diffuse = {1, 1, 1}};
    struct brdf_table *table = NULL;
    struct parallel *pool = parallel_new(1);
    assert_int_equal(
        brdf_table_build(&b, &(struct brdf_fit){SATIN_HSH, 10, 0.05f, false}, pool, &table),
        SATIN_ERROR_ARGUMENT);
    b = phong(3);
    assert_int_equal(
        brdf_table_build(&b, &(struct brdf_fit){SATIN_HSH, 15, 0.05f, false}, pool, &table),
        SATIN_ERROR_ARGUMENT);
    assert_int_equal(
        brdf_table_build(&b, &(struct brdf_fit){SATIN_HSH, 0, 0.05f, false}, pool, &table),
        SATIN_ERROR_ARGUMENT);
    assert_null(table);
    brdf_table_free(NULL);
    parallel_free(pool);
}

static bool brdf_table_cancel(void *user, double done) {
    (void)user, (void)done;
    return true;
}

static void threads_make_no_difference_and_building_can_be_cancelled(void **state) {
    (void)state;
    struct brdf b = phong(8);
    struct brdf_table *one = test_brdf_table_build(&b, SATIN_HSH, 8, 0.05f, 1);
    struct brdf_table *three = test_brdf_table_build(&b, SATIN_HSH, 8, 0.05f, 3);
    for (float degrees = 0; degrees < 90; degrees += 3) {
        float c1[64], c3[64];
        int n = brdf_table_lookup(one, brdf_table_direction(degrees, degrees), c1);
        assert_int_equal(n, brdf_table_lookup(three, brdf_table_direction(degrees, degrees), c3));
        assert_memory_equal(c1, c3, (size_t)(n * n) * sizeof *c1);
    }
    brdf_table_free(one);
    brdf_table_free(three);
    struct parallel *pool = parallel_new(2);
    struct brdf_table *table = NULL;
    parallel_set_progress(pool, brdf_table_cancel, NULL);
    assert_int_equal(
        brdf_table_build(&b, &(struct brdf_fit){SATIN_HSH, 8, 0.05f, false}, pool, &table),
        SATIN_CANCELLED);
    assert_null(table);
    parallel_free(pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orders_bound_what_is_reflected),
        cmocka_unit_test(sharp_edges_at_grazing_angles_are_not_held),
        cmocka_unit_test(lookups_agree_with_projection),
        cmocka_unit_test(constant_light_gives_the_albedo),
        cmocka_unit_test(channels_stay_apart),
        cmocka_unit_test(sharp_lobes_and_bad_arguments_are_refused),
        cmocka_unit_test(threads_make_no_difference_and_building_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
