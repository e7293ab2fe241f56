// SPDX-License-Identifier: Apache-2.0
// Harmonics over a range of roughness: between rungs they are those of a table made there; a lobe
// that is too smooth is not represented; a range that does not vary is one table.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "brdf/brdf.h"
#include "rsh/rsh.h"

static const struct brdf_fit fit = {SATIN_HSH, 10, 0.01f, false};

static struct brdf brdf_range_metal(float alpha) {
    return (struct brdf){.model = brdf_find("roughconductor"),
                         .specular = {1, 1, 1},
                         .eta = {.2f, .9f, 1.1f},
                         .k = {3.9f, 2.4f, 2.1f},
                         .distribution = BRDF_GGX,
                         .alpha_u = alpha,
                         .alpha_v = alpha};
}

// Squared relative difference of the range's coefficients at b from those of b's own table.
static double brdf_range_difference(const struct brdf_range *range, const struct brdf *b,
                                    struct parallel *pool, vec3 wo) {
    struct brdf_table *own;
    float c[3 * RSH_MAX_COEFFICIENTS], d[3 * RSH_MAX_COEFFICIENTS];
    assert_int_equal(brdf_table_build(b, &fit, pool, &own), SATIN_OK);
    int n = brdf_range_lookup(range, b, wo, c), m = brdf_table_lookup(own, wo, d);
    assert_true(n >= m && m > 0 && n == brdf_range_order(range, b, wo));
    double error = 0.0, norm = 0.0;
    for (int channel = 0; channel < 3; channel++)
        for (int k = 0; k < m * m; k++) {
            double e = (double)c[channel * n * n + k] - (double)d[channel * m * m + k];
            error += e * e;
            norm += (double)d[channel * m * m + k] * (double)d[channel * m * m + k];
        }
    brdf_table_free(own);
    return error / norm;
}

static void lookups_interpolate_between_rungs(void **state) {
    (void)state;
    struct parallel *pool = parallel_new(2);
    struct brdf base = brdf_range_metal(.4f);
    struct brdf_roughness over = {BRDF_SLOT_ALPHA_U, .02f, .7f};
    struct brdf_range *range;
    assert_int_equal(brdf_range_build(&base, &over, &fit, pool, &range), SATIN_OK);
    assert_int_equal(brdf_range_describe(range).channels, 3);
    const float alphas[] = {.45f, .55f, .63f, .7f};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++) {
            struct brdf b = brdf_range_metal(alphas[i]);
            float theta = .3f + .4f * (float)k;
            assert_true(brdf_range_difference(range, &b, pool, v3(sinf(theta), 0, cosf(theta))) <
                        0.005);
        }
    // These are too smooth for the order, below the range, and above it.
    const float outside[] = {.03f, .001f, .9f};
    for (int i = 0; i < 3; i++) {
        struct brdf b = brdf_range_metal(outside[i]);
        float c[3 * RSH_MAX_COEFFICIENTS];
        assert_int_equal(brdf_range_order(range, &b, v3(0, 0, 1)), 0);
        assert_int_equal(brdf_range_lookup(range, &b, v3(0, 0, 1), c), 0);
    }
    brdf_range_free(range);
    parallel_free(pool);
}

static void one_table_serves_constants(void **state) {
    (void)state;
    struct parallel *pool = parallel_new(2);
    struct brdf base = brdf_range_metal(.5f);
    struct brdf_range *range;
    assert_int_equal(brdf_range_build(&base, NULL, &fit, pool, &range), SATIN_OK);
    assert_true(brdf_range_difference(range, &base, pool, v3(.6f, 0, .8f)) == 0.0);
    brdf_range_free(range);
    // A table without a bound of the error has some order everywhere.
    struct brdf sharp = brdf_range_metal(.05f);
    struct brdf_fit forced = fit;
    forced.always = true;
    assert_int_equal(brdf_range_build(&sharp, NULL, &forced, pool, &range), SATIN_OK);
    assert_int_equal(brdf_range_order(range, &sharp, v3(0, 0, 1)), fit.max_order);
    brdf_range_free(range);
    brdf_range_free(NULL);
    parallel_free(pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lookups_interpolate_between_rungs),
        cmocka_unit_test(one_table_serves_constants),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
