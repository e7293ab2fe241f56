// SPDX-License-Identifier: Apache-2.0
// The shadowing of facets by the slopes of bump and normal maps.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/frame.h"
#include "brdf/brdf.h"
#include "facet.h"

static double shadowed_radiance(vec3 w, const void *brdf) {
    const struct brdf *b = brdf;
    // Local directions have the facet's normal along z.
    const struct frame frame = {v3(b->base[0].z, 0, b->base[0].x), v3(0, 1, 0),
                                v3(-b->base[0].x, 0, b->base[0].z)};
    return (double)brdf_bump_shadowing(b, frame_to_local(&frame, w));
}

static double even_radiance(vec3 w, const void *ctx) {
    (void)w;
    (void)ctx;
    return 1.0;
}

static void mean_shadowing_is_that_of_even_light(void **state) {
    (void)state;
    for (int i = 1; i < FACETS; i++) {
        const float angle = facet_degrees[i] * PI_F / 180.0f;
        const vec3 facet = facet_normal(angle);
        struct brdf b = {.model = brdf_find("diffuse")};
        b.base[0] = v3(-sinf(angle), 0.0f, cosf(angle));
        b.bump[0] = minf(0.125f * sqrf(tanf(angle)), 1.0f);
        const double expected = facet_irradiance(facet, shadowed_radiance, &b) /
                                facet_irradiance(facet, even_radiance, NULL);
        print_message("%2.0f degrees: %.4f, %.4f expected\n", (double)facet_degrees[i],
                      (double)brdf_bump_diffuse(&b), expected);
        assert_true(fabs((double)brdf_bump_diffuse(&b) - expected) < 0.004);
    }
}

// A map that tilts by a, around another one that tilts the facet by b more, to either side.
static void two_maps_hide_light_between_their_facets(void **state) {
    (void)state;
    const float outer = 0.6f, inner[] = {-1.0f, -0.5f, 0.3f, 0.7f};
    for (int i = 0; i < 4; i++) {
        const float angle = outer + inner[i];
        struct brdf b = {.model = brdf_find("diffuse"),
                         .base = {v3(-sinf(angle), 0.0f, cosf(angle)),
                                  v3(-sinf(inner[i]), 0.0f, cosf(inner[i]))},
                         .bump = {0.125f * sqrf(tanf(outer)), 0.125f * sqrf(tanf(inner[i]))}};
        const vec3 facet = facet_normal(angle);
        const double expected = facet_irradiance(facet, shadowed_radiance, &b) /
                                facet_irradiance(facet, even_radiance, NULL);
        print_message("%.1f and %4.1f rad: %.4f, %.4f expected\n", (double)outer, (double)inner[i],
                      (double)brdf_bump_diffuse(&b), expected);
        assert_true(fabs((double)brdf_bump_diffuse(&b) - expected) < 0.02);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mean_shadowing_is_that_of_even_light),
        cmocka_unit_test(two_maps_hide_light_between_their_facets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
