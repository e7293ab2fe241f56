// SPDX-License-Identifier: Apache-2.0
// Splines through keyframes: they pass through all of them, without jumps of position or speed.
#include "animation/animation.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { KEYS = 6 };
static const double AT[KEYS] = {3, 10, 12, 13, 20, 60};

// The largest jump of f and of its difference quotient over an interval, in steps of h.
static void spline_jumps(double (*f)(double x), double *jump, double *slope_jump) {
    const double h = 1e-4;
    *jump = *slope_jump = 0.0;
    for (double x = AT[0] + h; x < AT[KEYS - 1] - h; x += h) {
        const double before = f(x) - f(x - h), after = f(x + h) - f(x);
        *jump = fmax(*jump, fabs(after));
        *slope_jump = fmax(*slope_jump, fabs(after - before) / h);
    }
}

static const double VALUES[KEYS] = {1, 5, 5.5, 5.5, 2, 40};
static double spline_value(double x) { return animation_value(KEYS, AT, VALUES, x); }

static void a_value_stays_between_its_neighbours(void **state) {
    (void)state;
    for (int i = 0; i < KEYS; i++) assert_true(fabs(spline_value(AT[i]) - VALUES[i]) < 1e-12);
    for (int i = 0; i + 1 < KEYS; i++) {
        const double lo = fmin(VALUES[i], VALUES[i + 1]), hi = fmax(VALUES[i], VALUES[i + 1]);
        for (double x = AT[i]; x < AT[i + 1]; x += 0.01)
            assert_true(spline_value(x) >= lo - 1e-12 && spline_value(x) <= hi + 1e-12);
    }
    double jump, slope;
    spline_jumps(spline_value, &jump, &slope);
    // No slope is above 10 per frame here, and none changes by more than 10 per frame and frame.
    assert_true(jump < 1e-3 && slope < 1e-3);
    const double one[1] = {7};
    assert_true(animation_value(1, AT, one, 3) == 7);
}

// The third and the fourth point are equal: the camera rests there.
static const double POINTS[KEYS][3] = {{0, 0, 0}, {1, 2, 0}, {8, 2, 1},
                                       {8, 2, 1}, {8, 0, 0}, {0, 0, 5}};
static int spline_axis;
static double spline_coordinate(double x) {
    double knot[KEYS], out[3];
    animation_knots(KEYS, POINTS, knot);
    animation_point(KEYS, AT, POINTS, knot, x, out);
    return out[spline_axis];
}

static void a_point_passes_through_its_keyframes(void **state) {
    (void)state;
    for (spline_axis = 0; spline_axis < 3; spline_axis++) {
        for (int i = 0; i < KEYS; i++)
            assert_true(fabs(spline_coordinate(AT[i]) - POINTS[i][spline_axis]) < 1e-12);
        for (double x = AT[2]; x <= AT[3]; x += 0.01)
            assert_true(spline_coordinate(x) == POINTS[2][spline_axis]);
        double jump, slope;
        spline_jumps(spline_coordinate, &jump, &slope);
        assert_true(jump < 2e-3 && slope < 5e-3);
    }
}

static void equal_steps_on_a_line_have_equal_speed(void **state) {
    (void)state;
    const double at[4] = {0, 10, 20, 30};
    const double point[4][3] = {{0, 1, 2}, {1, 1, 4}, {2, 1, 6}, {3, 1, 8}};
    for (double x = 0; x <= 30; x += 0.5) {
        double knot[4], out[3];
        animation_knots(4, point, knot);
        animation_point(4, at, point, knot, x, out);
        assert_true(fabs(out[0] - x / 10) < 1e-12 && fabs(out[1] - 1) < 1e-12);
        assert_true(fabs(out[2] - 2 - x / 5) < 1e-12);
    }
    double knot[1], out[3];
    animation_knots(1, point, knot);
    animation_point(1, at, point, knot, 0, out);
    assert_true(out[2] == 2.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_value_stays_between_its_neighbours),
        cmocka_unit_test(a_point_passes_through_its_keyframes),
        cmocka_unit_test(equal_steps_on_a_line_have_equal_speed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
