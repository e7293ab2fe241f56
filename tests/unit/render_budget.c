// SPDX-License-Identifier: Apache-2.0
// What a time limit is divided into: nothing without a limit, steps in their order with one, and
// records as much as the measured paces ask for.
#include "render/render_budget.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/render_state.h"

// A render of 100x100 pixels that began now, so that all but milliseconds of its time are left.
static struct render make(double time) {
    struct render r = {.options = {.time = time, .width = 100, .height = 100}};
    r.budget = (struct render_budget){.start = stats_wall(), .stop_at = INFINITY};
    r.pool = parallel_new(1);
    assert_non_null(r.pool);
    return r;
}

static double image_limit(struct render *r) {
    render_limit_image(r);
    return r->budget.stop_at;
}

static void no_limit_ends_nothing(void **state) {
    (void)state;
    struct render r = make(0.0);
    render_limit_pilot(&r);
    assert_true(render_time_remains(&r));
    render_limit_tables(&r);
    assert_true(render_time_remains(&r));
    render_limit_bounces(&r, 0.0, 0.5);
    assert_true(render_time_remains(&r));
    render_limit_records(&r, NULL);
    assert_true(render_time_remains(&r));
    assert_true(isinf(image_limit(&r)));
    assert_true(isinf(render_time_left(&r)));
    assert_true(isinf(render_budget_pass(&r, 1.0)));
    render_limit_look(&r);
    assert_true(isfinite(r.budget.stop_at));
    parallel_free(r.pool);
}

static void steps_end_in_their_order(void **state) {
    (void)state;
    struct render r = make(1000.0);
    render_limit_tables(&r);
    const double tables = r.budget.stop_at;
    render_limit_records(&r, NULL);
    const double records = r.budget.stop_at, image = image_limit(&r);
    assert_true(0.0 < tables && tables < records && records < image && image < 1000.0);
    parallel_free(r.pool);
}

static void a_limit_that_is_over_is_no_cancellation(void **state) {
    (void)state;
    struct render r = make(1000.0);
    r.budget.stop_at = 0.0;
    assert_false(render_time_remains(&r));
    assert_int_equal(render_limit_end(&r, SATIN_CANCELLED), SATIN_OK);
    assert_true(render_time_remains(&r));
    assert_int_equal(render_limit_end(&r, SATIN_ERROR_MEMORY), SATIN_ERROR_MEMORY);
    r.progress.cancelled_in = STAGE_RECORDS;
    assert_int_equal(render_limit_end(&r, SATIN_CANCELLED), SATIN_CANCELLED);
    parallel_free(r.pool);
}

static void photons_fit_or_are_left(void **state) {
    (void)state;
    const struct render r = make(1000.0);
    const double few = render_budget_photons(&r, 10.0), many = render_budget_photons(&r, 1.0);
    assert_true(few > 3.0 && many > 9.0 * few && many < 300.0);
    assert_true(render_budget_photons(&r, 1000.0) == 0.0);
    parallel_free(r.pool);
}

// Records get more where more of the light is theirs, and less where the image is noisier. The
// noise of the image falls faster than the error of records: with more cores records get more.
static void records_get_what_the_paces_ask_for(void **state) {
    (void)state;
    struct render r = make(1000.0);
    const struct render_pace even = {
        .rays = 1e5, .samples = 1e5, .variance = 1.0, .indirect2 = 0.5};
    struct render_pace other = even;
    render_limit_records(&r, &even);
    const double fraction = r.budget.stop_at;
    assert_true(fraction > 200.0 && fraction < 800.0);
    other.indirect2 = 1.0;
    render_limit_records(&r, &other);
    assert_true(r.budget.stop_at > fraction + 10.0);
    other = even;
    other.variance = 4.0;
    render_limit_records(&r, &other);
    assert_true(r.budget.stop_at < fraction - 10.0);
    other = even;
    other.rays = other.samples = 64e5;
    render_limit_records(&r, &other);
    assert_true(r.budget.stop_at > fraction + 10.0);
    parallel_free(r.pool);
}

static void passes_grow_until_little_is_left(void **state) {
    (void)state;
    struct render r = make(1000.0);
    const double pixels = 1e4, fit = 999.0;
    assert_true(render_budget_pass(&r, 1.0) == 0.0);  // less than a tenth of a sample per pixel
    const double few = render_budget_pass(&r, 0.5);
    assert_true(few > fit && few < 2.0 * pixels);
    const double many = render_budget_pass(&r, 0.001);
    assert_true(many > 0.49e3 * fit && many < 0.51e3 * 1000.0);
    parallel_free(r.pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_limit_ends_nothing),
        cmocka_unit_test(steps_end_in_their_order),
        cmocka_unit_test(a_limit_that_is_over_is_no_cancellation),
        cmocka_unit_test(photons_fit_or_are_left),
        cmocka_unit_test(records_get_what_the_paces_ask_for),
        cmocka_unit_test(passes_grow_until_little_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
