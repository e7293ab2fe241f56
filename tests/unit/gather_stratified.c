// SPDX-License-Identifier: Apache-2.0
// Stratified gradients where they are known: at the centre of a unit sphere whose radiance is 1 +
// x, dE/dx = 3 pi / 4 and dE/dy = 0. Weights that follow the samples' own angles miss this at any
// number of rays: they rotate it by .7 towards -y (docs/equations.md, erratum 1).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "gather/gather_gradients.h"
#include "rsh/rsh.h"

enum { RAYS = 16384, ORDER = 4, N2 = ORDER * ORDER };

// The bound is seven times the rms error over 20 seeds at this number of rays, three times the
// largest.
static const double TOLERANCE = 0.0026;

static const double SLOPE = 0.75 * 3.14159265358979323846;

static const struct frame GATHER_STRATIFIED_FRAME = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// One jittered ray per stratum; L = 1 + a . w in red, green twice and blue three times that.
static void gather_stratified_look(struct gather_hemisphere *h, const struct gather_layout *l,
                                   vec3 a) {
    struct rng rng = rng_make(7, RNG_GATHER, 1);
    for (int j = 0; j < l->M; j++)
        for (int k = 0; k < l->N; k++) {
            size_t i = (size_t)j * (size_t)l->N + (size_t)k;
            float u = ((float)j + rng_float(&rng)) / (float)l->M;
            float v = ((float)k + rng_float(&rng)) / (float)l->N;
            vec3 w = l->order ? sample_uniform_hemisphere(fmaxf(1.0f - u, 0.0f), v)
                              : sample_cosine_hemisphere(u, v);
            float L = 1.0f + v3_dot(a, w);
            h->ray[i].ray.d = w;
            h->ray[i].first = (struct gather_first){1.0f, v3_neg(w)};
            h->L[i] = rgb_make(L, 2.0f * L, 3.0f * L);
        }
}

static void irradiance_in_a_sphere_has_its_gradients(void **state) {
    (void)state;
    struct gather_layout *l = gather_layout_new(RAYS, SATIN_HSH, 0);
    struct gather_hemisphere *h = gather_hemisphere_new(gather_layout_rays(l));
    gather_hemisphere_begin(h, l, &GATHER_STRATIFIED_FRAME);
    gather_stratified_look(h, l, v3(1.0f, 0.0f, 0.0f));
    for (int kind = 0; kind < 2; kind++) {
        vec3 grad[3] = {{0}};
        gather_stratified_irradiance(h, kind == 1, grad);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs((double)grad[c].x / (c + 1) - SLOPE) < TOLERANCE);
            assert_true(fabs((double)grad[c].y / (c + 1)) < TOLERANCE);
            assert_true(grad[c].z == 0.0f);
        }
    }
    gather_hemisphere_free(h);
    gather_layout_free(l);
}

// As E = Lambda . cosine, so is its gradient. HSH of order 2 hold the cosine.
static void radiance_in_a_sphere_has_its_gradients(void **state) {
    (void)state;
    struct gather_layout *l = gather_layout_new(RAYS, SATIN_HSH, ORDER);
    struct gather_hemisphere *h = gather_hemisphere_new(gather_layout_rays(l));
    gather_hemisphere_begin(h, l, &GATHER_STRATIFIED_FRAME);
    // cos(theta) = (sqrt(2 pi) H_0 + sqrt(2 pi / 3) H_1) / 2.
    const double c0 = 0.5 * sqrt(2.0 * 3.14159265358979), c2 = c0 / sqrt(3.0);
    for (int rotated = 0; rotated < 2; rotated++) {
        float dx[3 * N2] = {0}, dy[3 * N2] = {0};
        gather_stratified_look(h, l, rotated ? v3(0.0f, 1.0f, 0.0f) : v3(1.0f, 0.0f, 0.0f));
        gather_stratified_radiance(h, dx, dy);
        for (int c = 0; c < 3; c++) {
            double x = (c0 * (double)dx[c * N2] + c2 * (double)dx[c * N2 + 2]) / (c + 1);
            double y = (c0 * (double)dy[c * N2] + c2 * (double)dy[c * N2 + 2]) / (c + 1);
            assert_true(fabs(x - (rotated ? 0.0 : SLOPE)) < TOLERANCE);
            assert_true(fabs(y - (rotated ? SLOPE : 0.0)) < TOLERANCE);
        }
    }
    gather_hemisphere_free(h);
    gather_layout_free(l);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_in_a_sphere_has_its_gradients),
        cmocka_unit_test(radiance_in_a_sphere_has_its_gradients),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
