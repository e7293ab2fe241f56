// SPDX-License-Identifier: Apache-2.0
// What a time limit is divided into: nothing without a limit, steps in their order with one, and
// records as much as the measured paces ask for. How many photons, samples and rays there are.
#include "render/render_budget.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/render_state.h"

// A render of 100x100 pixels that began now, so that all but milliseconds of its time are left.
static struct render make(double time) {
    struct render r = {.options = {.time = time,
                                   .width = 100,
                                   .height = 100,
                                   .spp = time > 0.0 ? 1 << 20 : 36,
                                   .adaptive_sampling = true}};
    r.progress = (struct render_progress){.start = stats_wall(), .deadline = INFINITY};
    r.pool = parallel_new(1);
    assert_non_null(r.pool);
    return r;
}

static double image_limit(struct render *r) {
    render_limit_image(r);
    return r->progress.deadline;
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
    render_limit_coarse(&r);
    assert_true(isfinite(r.progress.deadline));
    parallel_free(r.pool);
}

static void steps_end_in_their_order(void **state) {
    (void)state;
    struct render r = make(1000.0);
    render_limit_tables(&r);
    const double tables = r.progress.deadline;
    render_limit_records(&r, NULL);
    const double records = r.progress.deadline, image = image_limit(&r);
    assert_true(0.0 < tables && tables < records && records < image && image < 1000.0);
    parallel_free(r.pool);
}

static void a_limit_that_is_over_is_no_cancellation(void **state) {
    (void)state;
    struct render r = make(1000.0);
    r.progress.deadline = 0.0;
    assert_false(render_time_remains(&r));
    assert_int_equal(render_limit_end(&r, SATIN_CANCELLED), SATIN_OK);
    assert_true(render_time_remains(&r));
    assert_int_equal(render_limit_end(&r, SATIN_ERROR_MEMORY), SATIN_ERROR_MEMORY);
    r.progress.cancelled = true;
    assert_int_equal(render_limit_end(&r, SATIN_CANCELLED), SATIN_CANCELLED);
    parallel_free(r.pool);
}

static void photons_fit_or_are_left(void **state) {
    (void)state;
    const struct render r = make(1000.0);
    const double first = render_budget_first_photons(&r);
    assert_true(first > 0.0 && first < 0.1);
    struct render_more_photons few = render_budget_photons(&r, 30.0, 4.0);
    assert_true(few.fraction > first && few.fraction < 1.0 && few.global == 1.0);
    // Time for twice the photons, and for ten times as many.
    assert_true(render_budget_photons(&r, 8.4, 4.0).fraction == 1.0);
    assert_true(fabs(render_budget_photons(&r, 8.4, 4.0).global - 2.0) < 0.1);
    assert_true(render_budget_photons(&r, 1.7, 4.0).global == 4.0);
    assert_true(render_budget_photons(&r, 1000.0, 4.0).fraction == 0.0);
    parallel_free(r.pool);
}

static void starved_maps_alone_are_made_again(void **state) {
    (void)state;
    const struct render r = make(0.0);
    assert_true(render_budget_first_photons(&r) == 1.0);
    assert_true(render_budget_starved(1000.0, 500.0) == 1.0);
    assert_true(render_budget_starved(1000.0, 2000.0) == 1.0);
    assert_true(render_budget_starved(1000.0, 125.0) == 4.0);
    assert_true(render_budget_starved(1000.0, 0.0) == 8.0);
    assert_true(render_budget_photons(&r, 1.0, 1.2).fraction == 0.0);
    assert_true(render_budget_photons(&r, 1.0, 4.0).fraction == 1.0);
    assert_true(render_budget_photons(&r, 1.0, 4.0).global == 4.0);
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
    const double fraction = r.progress.deadline;
    assert_true(fraction > 200.0 && fraction < 800.0);
    other.indirect2 = 1.0;
    render_limit_records(&r, &other);
    assert_true(r.progress.deadline > fraction + 10.0);
    other = even;
    other.variance = 4.0;
    render_limit_records(&r, &other);
    assert_true(r.progress.deadline < fraction - 10.0);
    other = even;
    other.rays = other.samples = 64e5;
    render_limit_records(&r, &other);
    assert_true(r.progress.deadline > fraction + 10.0);
    parallel_free(r.pool);
}

static void passes_grow_until_little_is_left(void **state) {
    (void)state;
    struct render r = make(1000.0);
    const uint64_t pixels = 10000, done = 64 * pixels;
    assert_int_equal(render_budget_pass(&r, done, 1.0), 0);  // a tenth of a sample per pixel
    const uint64_t few = render_budget_pass(&r, done, 0.5);
    assert_true(few > 999 && few < 2 * pixels);
    const uint64_t many = render_budget_pass(&r, done, 0.001);
    assert_true(many > 490000 && many < 501000);
    assert_int_equal(render_budget_pass(&r, done, 1e-9), done);
    // All pixels get their equal samples, or none.
    assert_int_equal(render_budget_pass(&r, pixels, 0.06), pixels);
    assert_int_equal(render_budget_pass(&r, pixels, 0.5), 0);
    parallel_free(r.pool);
}

// Samples of all passes of a render without a time limit, whose equal samples come first.
static void check_passes(const struct render *r, uint64_t equal) {
    const uint64_t pixels = 10000, all = (uint64_t)r->options.spp * pixels;
    uint64_t done = 0, more;
    assert_int_equal(render_budget_even_samples(&r->options), equal);
    while ((more = render_budget_pass(r, done, 1e9)) > 0) {
        assert_true(more <= (done > pixels ? done : pixels));
        if (done < equal * pixels) assert_true(more % pixels == 0 && done + more <= equal * pixels);
        done += more;
    }
    assert_int_equal(done, all);
}

static void passes_take_what_the_options_say(void **state) {
    (void)state;
    struct render r = make(0.0);
    check_passes(&r, 9);
    r.options.spp = 6;
    check_passes(&r, 2);
    r.options.spp = 3;
    check_passes(&r, 3);
    r.options.spp = 36;
    r.options.adaptive_sampling = false;
    check_passes(&r, 36);
    r.options.adaptive_sampling = true;
    r.options.integrator = SATIN_PATH;
    check_passes(&r, 36);
    parallel_free(r.pool);
}

static void first_samples_are_few(void **state) {
    (void)state;
    for (int width = 1; width < 100000; width *= 3)
        for (int height = 1; height < 20000; height *= 3) {
            const int stride = render_budget_first_stride(width, height);
            assert_true(stride >= 16 && (stride & (stride - 1)) == 0);
            assert_true((width / stride) * (height / stride) <= 256);
            assert_true(stride == 16 || (2 * width / stride) * (2 * height / stride) > 256);
        }
}

static void rays_at_rims_are_a_part_of_the_image(void **state) {
    (void)state;
    const size_t pixels = 160000;
    for (size_t rims = 1; rims <= pixels; rims *= 2) {
        const uint32_t rays = render_budget_rim_rays(pixels, rims);
        assert_true(rays >= 1 && rays <= 128 && (rays & (rays - 1)) == 0);
        assert_true(rays * rims <= 2 * pixels);
        assert_true(rays == 128 || 2 * rays * rims > 2 * pixels);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_limit_ends_nothing),
        cmocka_unit_test(steps_end_in_their_order),
        cmocka_unit_test(a_limit_that_is_over_is_no_cancellation),
        cmocka_unit_test(photons_fit_or_are_left),
        cmocka_unit_test(starved_maps_alone_are_made_again),
        cmocka_unit_test(records_get_what_the_paces_ask_for),
        cmocka_unit_test(passes_grow_until_little_is_left),
        cmocka_unit_test(passes_take_what_the_options_say),
        cmocka_unit_test(first_samples_are_few),
        cmocka_unit_test(rays_at_rims_are_a_part_of_the_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
