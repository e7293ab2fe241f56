// SPDX-License-Identifier: Apache-2.0
// How few projections a table takes, by the number of times that its BRDF is evaluated.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "brdf/brdf.h"
#include "brdf/brdf_project.h"

static uint64_t evaluations;
static const struct brdf_model *counted_model;

static void counting_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    evaluations++;
    counted_model->eval(b, wo, wi, diffuse, glossy);
}

// The number of projections by all azimuths that would have as many evaluations.
static double projections(struct brdf b, const char *model, float *fraction) {
    struct parallel *pool = parallel_new(1);
    struct brdf_table *table = NULL;
    counted_model = brdf_find(model);
    struct brdf_model counting = *counted_model;
    counting.eval = counting_eval;
    b.model = &counting;
    b.specular = rgb_grey(1.0f);
    evaluations = 0;
    assert_non_null(pool);
    const struct brdf_fit fit = {SATIN_HSH, 10, 0.01f, false};
    assert_int_equal(brdf_table_build(&b, &fit, pool, &table), SATIN_OK);
    *fraction = brdf_table_describe(table).fraction;
    brdf_table_free(table);
    parallel_free(pool);
    return (double)evaluations / (2.0 * PROJECT_POINTS);
}

// The quadrant has 3,400 nodes, of which the coarsest grid has 62, the radius 256 and 16.
static void sharp_lobes_are_projected_at_the_coarsest_nodes_alone(void **state) {
    (void)state;
    float fraction;
    const double quadrant =
        projections((struct brdf){.alpha_u = .07f, .alpha_v = .12f}, "ward", &fraction);
    assert_true(quadrant > 20.0 && quadrant <= 62.1 && fraction == 0.0f);
    // Half the azimuths.
    const double radius = projections((struct brdf){.exponent = 200.0f}, "phong", &fraction);
    assert_true(radius > 2.0 && radius < 9.0 && fraction == 0.0f);
}

static void smooth_lobes_are_interpolated(void **state) {
    (void)state;
    float fraction;
    const double quadrant =
        projections((struct brdf){.alpha_u = .3f, .alpha_v = .25f}, "ward", &fraction);
    assert_true(quadrant < 450.0 && fraction > 0.3f);
    const double radius = projections((struct brdf){.exponent = 10.0f}, "phong", &fraction);
    assert_true(radius < 40.0 && fraction == 1.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sharp_lobes_are_projected_at_the_coarsest_nodes_alone),
        cmocka_unit_test(smooth_lobes_are_interpolated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
