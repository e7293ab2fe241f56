// SPDX-License-Identifier: Apache-2.0
// The limit of a record's radius by the curvature of the light that it reflects, below a ceiling
// whose light is known: there the lobes of all points see equal shapes of it, so the reflected
// light has the same Laplacian as that of the ceiling.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/sampling.h"
#include "fill/fill_record.h"

enum { ROWS = 200, COLUMNS = 200 };

static const float HEIGHT = 2.0f, ACCURACY = 0.3f;

static const struct fill_glossy *fill_curvature_clamp_lobe(void) {
    static struct fill_glossy glossy;
    glossy.brdf =
        (struct brdf){.model = brdf_find("phong"), .specular = rgb_grey(1.0f), .exponent = 22.0f};
    glossy.wo = v3(0, 0, 1);
    return &glossy;
}

// Rays to a ceiling whose radiance is 1 + curvature x^2 / 2.
static struct gather_hemisphere *below_ceiling(float curvature) {
    struct gather_hemisphere *h = gather_hemisphere_new(ROWS * COLUMNS);
    assert_non_null(h);
    h->frame = frame_from_normal(v3(0, 0, 1));
    h->stratified = h->count = h->all = ROWS * COLUMNS;
    for (size_t i = 0; i < h->all; i++) {
        const float u = ((float)(i / COLUMNS) + 0.5f) / ROWS,
                    v = ((float)(i % COLUMNS) + 0.5f) / COLUMNS;
        const vec3 w = sample_uniform_hemisphere(u, v);
        const float r = HEIGHT / w.z;
        h->x[i] = w.x;
        h->y[i] = w.y;
        h->z[i] = w.z;
        h->ray[i].first = (struct gather_first){r, v3(0, 0, -1)};
        h->L[i] = rgb_grey(1.0f + 0.5f * curvature * r * w.x * r * w.x);
    }
    return h;
}

static float fill_curvature_clamp_limit(float curvature, float R, float least) {
    struct gather_hemisphere *h = below_ceiling(curvature);
    const float found =
        fill_curvature_clamp_radius(h, fill_curvature_clamp_lobe(), ACCURACY, R, least);
    gather_hemisphere_free(h);
    return found;
}

// The light that the record reflects over that which it reflects of radiance 1.
static float brightness(float curvature) {
    struct gather_hemisphere *h = below_ceiling(curvature);
    const struct fill_glossy *glossy = fill_curvature_clamp_lobe();
    const float L = gather_hemisphere_reflected(h, &glossy->brdf, glossy->wo, BRDF_GLOSSY).g;
    for (size_t i = 0; i < h->all; i++) h->L[i] = rgb_grey(1.0f);
    const float one = gather_hemisphere_reflected(h, &glossy->brdf, glossy->wo, BRDF_GLOSSY).g;
    gather_hemisphere_free(h);
    return L / one;
}

static void uniform_light_has_no_limit(void **state) {
    (void)state;
    assert_true(fill_curvature_clamp_limit(0.0f, 3.0f, 0.1f) == 3.0f);
}

// The second difference over a R is curvature (a R)^2, and .2 a^2 of the light at the limit. The
// tolerance is for 100x100 rays instead of an integral, and for the farthest of them, whose solid
// angle changes too much.
static void the_limit_is_that_of_the_ceiling(void **state) {
    (void)state;
    for (float curvature = 0.5f; curvature < 10.0f; curvature *= 2.0f) {
        const float wanted = sqrtf(0.2f * brightness(curvature) / curvature);
        assert_float_equal(fill_curvature_clamp_limit(curvature, 1.5f * wanted, 1e-3f), wanted,
                           0.03f * wanted);
    }
}

static void small_records_are_left_alone(void **state) {
    (void)state;
    const float wanted = sqrtf(0.2f * brightness(2.0f) / 2.0f);
    assert_true(fill_curvature_clamp_limit(2.0f, 0.9f * wanted, 1e-3f) == 0.9f * wanted);
    assert_true(fill_curvature_clamp_limit(2.0f, 1.5f * wanted, 2.0f * wanted) == 1.5f * wanted);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uniform_light_has_no_limit),
        cmocka_unit_test(the_limit_is_that_of_the_ceiling),
        cmocka_unit_test(small_records_are_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
