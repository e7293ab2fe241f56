// SPDX-License-Identifier: Apache-2.0
// A regression finds slopes, takes noise for none, and leaves out what does not vary.
#include "render/render_regression.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"

static float spread(uint64_t i) { return (float)(rng_mix(i) >> 40) * 0x1p-24f - 0.5f; }

// Values that follow two regressors, with noise; the others are constant.
static void fill_pixels(struct regression *g, float first, float second, float noise) {
    memset(g, 0, sizeof *g);
    g->count = REGRESSION_MOST;
    for (int i = 0; i < g->count; i++) {
        const float u = spread(2 * (uint64_t)i), v = spread(2 * (uint64_t)i + 1);
        g->weight[i] = 1.0f + (float)(i % 3);
        for (int k = 0; k < REGRESSORS; k++) g->x[i][k] = 7.0f;
        g->x[i][1] = 3.0f + u;
        g->x[i][REGRESSOR_DEPTH] = 20.0f + 10.0f * v;
        for (int c = 0; c < REGRESSION_VALUES; c++)
            g->y[i][c] = 5.0f + first * u + second * v +
                         noise * spread(1000 + (uint64_t)(i * REGRESSION_VALUES + c));
    }
}

// What a change of one regressor does to a value.
static float slope_of(const struct regression *g, int regressor, float by) {
    float dx[REGRESSORS] = {0.0f}, change[REGRESSION_VALUES];
    dx[regressor] = by;
    render_regression_change(g, dx, change);
    return change[0] / by;
}

static void slopes_are_found(void **state) {
    (void)state;
    struct regression g;
    fill_pixels(&g, 2.0f, -4.0f, 0.0f);
    render_regression_fit(&g);
    // A ridge of a tenth of the variance makes them a tenth smaller.
    assert_float_equal(slope_of(&g, 1, 0.1f), 2.0f, 0.3f);
    assert_float_equal(slope_of(&g, REGRESSOR_DEPTH, 1.0f), -0.4f, 0.06f);
    for (int k = 0; k < REGRESSORS; k++)
        if (k != 1 && k != REGRESSOR_DEPTH) assert_float_equal(slope_of(&g, k, 1.0f), 0.0f, 1e-6f);
    assert_float_equal(g.most[0] - g.least[0], 4.9f, 1.0f);
}

static void noise_is_no_slope(void **state) {
    (void)state;
    struct regression g;
    fill_pixels(&g, 0.0f, 0.0f, 1.0f);
    render_regression_fit(&g);
    for (int k = 0; k < REGRESSION_LAYERS; k++) assert_float_equal(g.reliance[k], 0.0f, 0.25f);
    fill_pixels(&g, 2.0f, -4.0f, 0.5f);
    render_regression_fit(&g);
    for (int k = 0; k < REGRESSION_LAYERS; k++) assert_true(g.reliance[k] > 0.8f);
}

static void equal_pixels_change_nothing(void **state) {
    (void)state;
    struct regression g;
    fill_pixels(&g, 0.0f, 0.0f, 0.0f);
    render_regression_fit(&g);
    for (int k = 0; k < REGRESSORS; k++) assert_true(fabsf(slope_of(&g, k, 1.0f)) < 1e-5f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slopes_are_found),
        cmocka_unit_test(noise_is_no_slope),
        cmocka_unit_test(equal_pixels_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
