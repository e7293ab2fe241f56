// SPDX-License-Identifier: Apache-2.0
// The light samples at entries of irradiance by the time that they take, and how far maps with few
// photons grow.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/render_budget.h"
#include "render/render_state.h"

static int sky_samples(double limit, double seconds) {
    static struct render r;
    r.options.time = limit;
    const struct gather_entry_samples samples = render_budget_entry_samples(&r, seconds);
    assert_int_equal(samples.others, 8);
    return samples.sky;
}

static void a_limit_has_fewer_samples_of_slow_entries(void **state) {
    (void)state;
    assert_int_equal(sky_samples(0.0, 1e9), 64);  // no limit
    assert_int_equal(sky_samples(10.0, 0.0), 64);
    assert_int_equal(sky_samples(10.0, 0.39), 64);
    assert_int_equal(sky_samples(10.0, 0.8), 32);
    assert_int_equal(sky_samples(10.0, 1.7), 16);
    assert_int_equal(sky_samples(10.0, 100.0), 16);
}

static void fewer_samples_take_less_time(void **state) {
    (void)state;
    static struct render r;
    r.options.time = 10.0;
    assert_float_equal(render_budget_direct(&r, 0.2), 0.2, 1e-9);
    assert_float_equal(render_budget_direct(&r, 0.8), 0.4, 1e-9);
    assert_float_equal(render_budget_direct(&r, 8.0), 2.0, 1e-9);
}

// With a time limit, so many paths of `photons` have stored so many photons.
static double starved_factor(int64_t photons, double time, double paths, double kept) {
    return render_budget_starved(&(satin_options){.photons = photons, .time = time}, paths, kept);
}

static void starved_maps_grow_unless_they_stay_sparse(void **state) {
    (void)state;
    assert_float_equal(starved_factor(100000, 8.0, 6250.0, 6250.0), 2.5, 1e-9);
    assert_float_equal(starved_factor(100000, 8.0, 6250.0, 625.0), 5.0, 1e-9);
    assert_float_equal(starved_factor(100000, 8.0, 6250.0, 120.0), 8.0, 1e-9);
    // 8 times as many would store 14,400 photons.
    assert_float_equal(starved_factor(100000, 8.0, 6250.0, 112.0), 1.0 / 16.0, 1e-9);
    assert_float_equal(starved_factor(100000, 8.0, 6250.0, 0.0), 1.0 / 16.0, 1e-9);
    // Many photons are no sparse map, although few of their paths store any.
    assert_float_equal(starved_factor(1000000, 8.0, 62500.0, 1120.0), 8.0, 1e-9);
    // Without a limit no fewer are traced than the options have.
    assert_float_equal(render_budget_grow(starved_factor(100000, 0.0, 1e5, 0.0)), 1.0, 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_limit_has_fewer_samples_of_slow_entries),
        cmocka_unit_test(fewer_samples_take_less_time),
        cmocka_unit_test(starved_maps_grow_unless_they_stay_sparse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
