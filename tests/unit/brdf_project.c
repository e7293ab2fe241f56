// SPDX-License-Identifier: Apache-2.0
// Quadrature of the glossy lobe against the harmonics, compared with a plain fine grid.
#include "brdf/brdf_project.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { ORDER = 10, COUNT = ORDER * ORDER };

// Integrates by the midpoints of a polar grid about the normal, which is good to a few 1e-5 of the
// lobe's norm for lobes wider than some degrees. Returns the squared norm.
static double grid_projection(const struct brdf *b, vec3 wo, rsh_basis basis, double *c) {
    enum { THETA = 360, PHI = 720 };
    double norm = 0.0;
    memset(c, 0, COUNT * sizeof *c);
    for (int i = 0; i < THETA; i++) {
        double theta = (i + 0.5) * M_PI / 2 / THETA, s = sin(theta), z = cos(theta);
        double area = s * (M_PI / 2 / THETA) * (2 * M_PI / PHI);
        for (int j = 0; j < PHI; j++) {
            double phi = (j + 0.5) * 2 * M_PI / PHI;
            float y[COUNT], w[3] = {(float)(s * cos(phi)), (float)(s * sin(phi)), (float)z};
            double v = z * (double)brdf_eval(b, wo, v3(w[0], w[1], w[2]), BRDF_GLOSSY).g;
            norm += v * v * area;
            if (v < 1e-6) continue;
            rsh_eval(basis, ORDER, w, y);
            for (int k = 0; k < COUNT; k++) c[k] += v * area * (double)y[k];
        }
    }
    return norm;
}

static void projection_agrees_with_a_grid(void **state) {
    (void)state;
    const rgb one = {1, 1, 1}, k = {3, 3, 3};
    const struct brdf lobe[] = {
        {.model = brdf_find("phong"), .specular = one, .exponent = 2},
        {.model = brdf_find("phong"), .specular = one, .exponent = 40},
        {.model = brdf_find("ward"), .specular = one, .alpha_u = .6f, .alpha_v = .25f},
        {.model = brdf_find("roughconductor"),
         .specular = one,
         .eta = one,
         .k = k,
         .alpha_u = .3f,
         .alpha_v = .3f,
         .distribution = BRDF_GGX},
    };
    struct project_rule rule;
    struct project_points *points = malloc(sizeof *points);
    assert_non_null(points);
    brdf_project_rule_make(&rule);
    for (size_t i = 0; i < sizeof lobe / sizeof *lobe; i++)
        for (int angle = 0; angle < 90; angle += 28) {  // 0, 28, 56, 84 degrees
            float theta = (float)angle * PI_F / 180.0f;
            vec3 wo = v3(sinf(theta) * 0.6f, sinf(theta) * 0.8f, cosf(theta));
            rsh_basis basis = angle % 56 ? RSH_SPHERE : RSH_HEMISPHERE;
            double want[COUNT], error = 0.0;
            float got[COUNT] = {0};
            double norm = grid_projection(lobe + i, wo, basis, want);
            const struct project_target target = {basis, ORDER, 1, false};
            double got_norm = brdf_project_glossy(lobe + i, wo, target, &rule, points, got);
            for (int c = 0; c < COUNT; c++) error += pow((double)got[c] - want[c], 2);
            assert_true(sqrt(error / norm) < 1e-3);
            assert_true(fabs(got_norm / norm - 1.0) < 1e-3);
        }
    free(points);
}

// The half rule gives the same cosine terms as the full one.
static void the_half_rule_gives_the_cosine_terms(void **state) {
    (void)state;
    const struct brdf b = {.model = brdf_find("phong"), .specular = {1, .5f, .25f}, .exponent = 10};
    struct project_rule rule;
    struct project_points *points = malloc(sizeof *points);
    assert_non_null(points);
    brdf_project_rule_make(&rule);
    float full[3 * COUNT] = {0}, half[3 * COUNT] = {0};
    vec3 wo = v3(0.6f, 0.0f, 0.8f);
    struct project_target target = {RSH_HEMISPHERE, ORDER, 3, false};
    double norm = brdf_project_glossy(&b, wo, target, &rule, points, full);
    target.half = true;
    double other = brdf_project_glossy(&b, wo, target, &rule, points, half);
    assert_true(fabs(norm / other - 1.0) < 1e-5);
    for (int channel = 0; channel < 3; channel++)
        for (int l = 0; l < ORDER; l++)
            for (int m = -l; m <= l; m++) {
                int i = channel * COUNT + l * (l + 1) + m;
                assert_true(fabsf(full[i] - (m < 0 ? 0.0f : half[i])) < 2e-5f);
            }
    free(points);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(projection_agrees_with_a_grid),
        cmocka_unit_test(the_half_rule_gives_the_cosine_terms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
