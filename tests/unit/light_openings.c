// SPDX-License-Identifier: Apache-2.0
// Densities of rays and of directions through openings: they are normalized, and those of what is
// drawn.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "base/rng.h"
#include "base/sampling.h"
#include "light/light_kinds.h"

// What is drawn has a density, but for a few that rounding puts into the bin beside theirs.
enum { DRAWN = 10000, MISSING_MOST = 10 };

// Openings of random weights in a third of the bins.
static void random_openings(struct rng *rng, struct light_openings *out) {
    float weight[LIGHT_HISTOGRAM_BINS];
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++)
        weight[i] = rng_float(rng) < 0.33f ? rng_float(rng) : 0.0f;
    const struct light_box box = light_box_make(v3(-1, -2, 0.5f), v3(2, 1, 1.5f));
    light_openings_build(&box, weight, out);
}

// The mean over all directions of a density over solid angle, times all of it, is 1.
static void densities_of_directions_are_normalized(void **state) {
    static const vec3 FROM[] = {{4, 0, 1}, {3, 3, 3}, {0, 0, -1}, {-2, -2.5f, 1}};
    (void)state;
    struct rng rng = rng_make(1, RNG_TEST, 0);
    struct light_openings openings;
    random_openings(&rng, &openings);
    for (int k = 0; k < 4; k++) {
        enum { DIRECTIONS = 1 << 21 };
        double sum = 0.0;
        assert_true(light_openings_faced(&openings, FROM[k]));
        for (uint32_t i = 0; i < DIRECTIONS; i++) {
            const vec2 u = sample_sobol2(i, 5);
            const vec3 w = sample_uniform_cone(u.x, u.y, 2.0f);
            sum += 4.0 * M_PI / DIRECTIONS * (double)light_openings_pdf(&openings, FROM[k], w);
        }
        assert_true(fabs(sum - 1.0) < 0.02);
        int missing = 0;
        for (int i = 0; i < DRAWN; i++) {
            const float u = rng_float(&rng), v = rng_float(&rng);
            const vec3 w = light_openings_direction(&openings, FROM[k], u, v);
            missing += !(light_openings_pdf(&openings, FROM[k], w) > 0.0f);
        }
        assert_true(missing <= MISSING_MOST);
    }
    assert_false(light_openings_faced(&openings, v3(0, 0, 1)));
    assert_true(light_openings_pdf(&openings, v3(0, 0, 1), v3(1, 0, 0)) == 0.0f);
    assert_true(light_openings_pdf(&openings, v3(4, 0, 1), v3(1, 0, 0)) == 0.0f);
}

// The integral over the area of the density of rays along a direction is 1.
static void densities_of_rays_are_normalized(void **state) {
    (void)state;
    struct rng rng = rng_make(2, RNG_TEST, 0);
    struct light_openings openings;
    random_openings(&rng, &openings);
    for (int k = 0; k < 8; k++) {
        enum { RAYS = 1 << 20 };
        const vec3 d = sample_uniform_cone(rng_float(&rng), rng_float(&rng), 2.0f);
        const struct frame frame = frame_from_normal(d);
        double sum = 0.0;
        float most = 0.0f;
        assert_true(light_openings_face(&openings, d));
        for (uint32_t i = 0; i < RAYS; i++) {
            const vec2 u = sample_sobol2(i, 6);
            const vec3 o = frame_to_world(&frame, v3(8.0f * u.x - 4.0f, 8.0f * u.y - 4.0f, -20.0f));
            const struct ray ray = {o, 0.0f, d, INFINITY};
            const float density = light_openings_density(&openings, &ray);
            sum += 64.0 / RAYS * (double)density;
            most = fmaxf(most, density);
        }
        assert_true(fabs(sum - 1.0) < 0.02);
        assert_true(fabsf(most / light_openings_most(&openings, d) - 1.0f) < 1e-3f);
        int missing = 0;
        for (int i = 0; i < DRAWN; i++) {
            const float u = rng_float(&rng), v = rng_float(&rng);
            const vec3 p = light_openings_point(&openings, d, u, v);
            const struct ray ray = {v3_mad(p, -20.0f, d), 0.0f, d, INFINITY};
            missing += !(light_openings_density(&openings, &ray) > 0.0f);
        }
        assert_true(missing <= MISSING_MOST);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(densities_of_directions_are_normalized),
        cmocka_unit_test(densities_of_rays_are_normalized),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
