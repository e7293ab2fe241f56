// SPDX-License-Identifier: Apache-2.0
// Irradiance of records on facets that bump and normal maps tilt.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/cache.h"
#include "facet.h"

static double linear_radiance(vec3 w, const void *slope) {
    return 1.0 + (double)*(const float *)slope * (double)w.x;
}

// Radiance 1 + c x has the irradiance pi, and the gradient 2 pi / 3 c of its rotation towards x.
static void rotated_irradiance_is_that_of_the_facet(void **state) {
    (void)state;
    const float slopes[] = {0.0f, 0.8f, -0.8f};
    for (int s = 0; s < 3; s++)
        for (int i = 0; i < FACETS; i++) {
            const vec3 facet = facet_normal(facet_degrees[i] * PI_F / 180.0f);
            const vec3 gradient = v3(0.0f, 2.0f / 3.0f * PI_F * slopes[s], 0.0f);
            const struct cache_irradiance_value value = {.E = rgb_grey(PI_F),
                                                         .grad_r = {gradient, gradient, gradient}};
            const rgb E = cache_rotate_irradiance(&value, v3(0, 0, 1), facet);
            const double expected = facet_irradiance(facet, linear_radiance, &slopes[s]);
            print_message("slope %4.1f, %2.0f degrees: %.4f, %.4f expected\n", (double)slopes[s],
                          (double)facet_degrees[i], (double)E.g, expected);
            assert_true(fabs((double)E.g - expected) < 1e-3 * (double)PI_F);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rotated_irradiance_is_that_of_the_facet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
