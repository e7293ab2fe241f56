// SPDX-License-Identifier: Apache-2.0
// What a time limit is divided into: nothing without a limit, steps in their order with one, and
// records as much as follows from the measured paces; and the numbers of photons, samples and rays.
#include "render/render_budget.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "budget_case.h"

static double image_limit(struct render *r) {
    render_limit_image(r);
    return r->progress.deadline;
}

static void no_limit_ends_nothing(void **state) {
    (void)state;
    struct render r = budget_case(0.0);
    render_limit_photon_pilot(&r);
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
    struct render r = budget_case(1000.0);
    render_limit_tables(&r);
    const double tables = r.progress.deadline;
    render_limit_records(&r, NULL);
    const double records = r.progress.deadline, image = image_limit(&r);
    assert_true(0.0 < tables && tables < records && records < image && image < 1000.0);
    // A second round of records follows if there is time for .3 of it.
    r.progress.deadline = records;
    assert_true(render_budget_next_round(&r, 3.2 * (records - 1.0)));
    assert_false(render_budget_next_round(&r, 3.5 * records));
    // Otherwise its coarse records have .15 of the time.
    render_limit_coarse_records(&r);
    assert_true(fabs(r.progress.deadline - 0.15 * image) < 2.0);
    parallel_free(r.pool);
}

static void the_pilot_takes_a_tenth_at_most(void **state) {
    (void)state;
    const struct render r = budget_case(1000.0);
    assert_int_equal(render_budget_pilot(&r, 0.0), 0);
    assert_int_equal(render_budget_pilot(&r, 1e6), RENDER_PILOT_SIDE);
    // There is time for some 400 pixels.
    const int side = render_budget_pilot(&r, 400.0 * RENDER_PILOT_SAMPLES / 100.0);
    assert_true(side == 19 || side == 20);
    parallel_free(r.pool);
}

static void a_limit_that_is_over_is_no_cancellation(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
    r.progress.deadline = 0.0;
    assert_false(render_time_remains(&r));
    assert_int_equal(render_limit_end(&r, SATIN_CANCELLED), SATIN_OK);
    assert_true(render_time_remains(&r));
    assert_int_equal(render_limit_end(&r, SATIN_ERROR_MEMORY), SATIN_ERROR_MEMORY);
    r.progress.cancelled_in = STAGE_RECORDS;
    assert_int_equal(render_limit_end(&r, SATIN_CANCELLED), SATIN_CANCELLED);
    parallel_free(r.pool);
}

static void photons_fit_into_the_time_or_are_left_out(void **state) {
    (void)state;
    const struct render r = budget_case(1000.0);
    const double first = render_budget_first_photons();
    assert_true(first > 0.0 && first < 0.1);
    struct render_photon_counts few = render_budget_photons(&r, 480, 4.0, 0.0);
    assert_true(few.fraction > first && few.fraction < 1.0 && few.global == 1.0);
    // There is time for twice the photons, and for ten times as many.
    assert_true(render_budget_photons(&r, 134.4, 4.0, 0.0).fraction == 1.0);
    assert_true(fabs(render_budget_photons(&r, 134.4, 4.0, 0.0).global - 2.0) < 0.1);
    assert_true(render_budget_photons(&r, 27.2, 4.0, 0.0).global == 4.0);
    assert_true(render_budget_photons(&r, 16000, 4.0, 0.0).fraction == 0.0);
    // Caustics have more time, and more photons if they fit.
    assert_true(render_budget_photons(&r, 480, 4.0, 1.0).fraction > few.fraction);
    assert_true(render_budget_photons(&r, 134.4, 4.0, 0.0).caustic == 0.25);
    assert_true(render_budget_photons(&r, 134.4, 4.0, 0.25).caustic == 1.0);
    assert_true(render_budget_photons(&r, 134.4, 4.0, 1.0).caustic > 2.0);
    assert_true(render_budget_photons(&r, 27.2, 4.0, 1.0).caustic == 4.0);
    assert_true(render_budget_caustics(0.0) == 0.0 && render_budget_caustics(10.0) == 1.0);
    parallel_free(r.pool);
}

// Photons of integrators photons and sppm, however many there are and however short the time.
static void photons_that_nothing_replaces_fit(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
    satin_options *o = &r.options;
    o->photons = 999000000;
    o->caustic_photons = 1000000;
    o->integrator = SATIN_PHOTONS;
    const double first = render_budget_least_photons(o) * 1e9;
    assert_true(first > 1000.0 && first < 2000.0);
    assert_true(fabs(render_budget_photon_seconds(&r) - 300.0) < 1.0);
    o->integrator = SATIN_SPPM;
    assert_true(fabs(render_budget_photon_seconds(&r) - 100.0) < 1.0);
    // Few that were fast show that many more fit, but not how many.
    const double more = render_budget_more_photons(1e-6, 1e-4, 100.0);
    assert_true(more > 10e-6 && more < 20e-6);
    assert_true(fabs(render_budget_more_photons(0.01, 20.0, 100.0) - 0.045) < 1e-9);
    assert_true(render_budget_more_photons(0.5, 20.0, 100.0) == 1.0);
    // No more fit, or there is no limit.
    assert_true(render_budget_more_photons(1e-6, 200.0, 100.0) == 1e-6);
    assert_true(render_budget_more_photons(1e-6, 200.0, -1.0) == 1e-6);
    o->photons = 100;
    o->caustic_photons = 0;
    assert_true(render_budget_least_photons(o) == 1.0);
    o->photons = 1000000000;
    o->time = 0.0;
    assert_true(render_budget_least_photons(o) == 1.0);
    assert_true(render_budget_more_photons(1.0, 1e9, render_budget_photon_seconds(&r)) == 1.0);
    parallel_free(r.pool);
}

static void the_number_of_paths_follows_from_that_of_photons(void **state) {
    (void)state;
    satin_options o = {.photons = 300000, .caustic_photons = 7, .guide_clusters = true};
    o.gather_direct = true;
    const struct photon_paths paths = render_budget_paths(&o, 0.0);
    assert_true(paths.global == 300000 && paths.caustic == 7);
    assert_true(paths.clusters == 100000 && paths.direct == 150000);
    o.photons = 3;
    assert_true(render_budget_paths(&o, 0.0).clusters == 1 << 15);
    o.photons = 1 << 24;
    assert_true(render_budget_paths(&o, 0.0).clusters == 1 << 18);
    o.integrator = SATIN_PHOTONS;
    assert_true(render_budget_paths(&o, 0.0).clusters == 0 &&
                render_budget_paths(&o, 0.0).direct == 0);
}

static void as_many_paths_show_the_view_as_it_can_hold(void **state) {
    (void)state;
    const satin_options o = {.photons = 1 << 20};
    const int seen = render_budget_paths(&o, 0.0).seen;
    assert_true(seen >= 1 && seen <= GUIDE_SEEN_PATHS_MAX);
    assert_true(render_budget_visibility(&o, 1.0).paths >= seen);
}

static void a_short_limit_measures_less(void **state) {
    (void)state;
    const satin_options o = {.photons = 3, .guide_clusters = true};
    const struct {
        double core_seconds, fraction;
    } expected[] = {{0.0, 1.0}, {60.0, 1.0}, {20.0, 1.0}, {5.0, 0.25}, {0.01, 0.0625}};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        const double seconds = expected[i].core_seconds, fraction = expected[i].fraction;
        assert_true(render_budget_paths(&o, seconds).emission == (int)(fraction * 32768.0));
    }
}

// All paths, unless a tenth of a second by the first ones shows that the limit is too short.
static void visibility_is_measured_by_what_a_limit_allows(void **state) {
    (void)state;
    satin_options o = {.photons = 3};
    assert_true(render_budget_first_visibility(&o) == 1.0);
    assert_int_equal(render_budget_visibility(&o, 1.0).paths, 4096);
    o.time = 100.0;
    const double first = render_budget_first_visibility(&o);
    assert_true(first < 0.25);
    assert_int_equal(render_budget_visibility(&o, first).paths, (int)(first * 4096.0));
    assert_true(render_budget_more_visibility(&o, first, 0.05, false) == 1.0);
    assert_true(render_budget_more_visibility(&o, first, 0.5, false) == 4.0 * first);
    assert_true(render_budget_more_visibility(&o, 0.5, 0.1, false) == 1.0);
    assert_true(render_budget_more_visibility(&o, 1.0, 0.1, false) == 1.0);
    o.time = 1.0;
    assert_true(render_budget_more_visibility(&o, first, 0.1, false) == first);
    assert_true(render_budget_more_visibility(&o, first, 0.05, true) == 4.0 * first);
}

static void rays_per_bin_grow_with_photons(void **state) {
    (void)state;
    const struct {
        int64_t photons;
        int rays;
    } expected[] = {{0, 1}, {199999, 1}, {200000, 2}, {300000, 3}, {1 << 24, 4}};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        assert_int_equal(
            render_budget_visibility(&(satin_options){.photons = expected[i].photons}, 1.0)
                .bin_rays,
            expected[i].rays);
}

static void samples_gather_less_with_a_limit(void **state) {
    (void)state;
    // The noise is that of 128 rays of a pixel of 16 samples, or with the time limit that gives it
    // these samples of 16.
    const satin_options limited = {.spp = 1 << 20, .time = 1.0, .width = 100, .height = 100};
    const struct shade_missing plain = render_budget_missing(&(satin_options){.spp = 16}, 0.0),
                               timed = render_budget_missing(&limited, 1.3),
                               longer = render_budget_missing(&limited, 64 * 1.3),
                               shorter = render_budget_missing(&limited, 1e-3);
    assert_int_equal(render_budget_first_gathers(&(satin_options){.spp = 16}), 8);
    assert_int_equal(render_budget_first_gathers(&limited), 1);
    // Where a cache is off, the samples have the rays of a record in common, and each at least 8.
    const satin_options off = {.spp = 4, .irradiance_rays = 100};
    assert_int_equal(render_budget_missing(&off, 0.0).hemisphere, 25);
    assert_int_equal(plain.hemisphere, 8);
    assert_true(fabsf(sqrf(plain.deviation) * 128.0f - 1.0f) < 1e-5f);
    assert_true(fabsf(sqrf(timed.deviation) * 16.0f - 1.0f) < 1e-5f);
    assert_true(fabsf(sqrf(longer.deviation) * 1024.0f - 1.0f) < 1e-5f);
    assert_true(shorter.deviation == 1.0f);
    const struct shade_counts none = {0},
                              counts = {.samples = 2, .points = 2, .rays = 3, .missing_rays = 1};
    assert_true(render_budget_sample_cost(&none, false) == 1.0f);
    assert_true(render_budget_sample_cost(&counts, false) == 13.0f);
    assert_true(render_budget_sample_cost(&counts, true) == 10.0f);
}

// A quarter of the photons makes the lookups twice as wide.
static void lookups_of_fewer_photons_are_wider(void **state) {
    (void)state;
    assert_true(render_budget_lookup(0.25) == 0.5f);
    assert_true(render_budget_lookup(1.0) == 1.0f && render_budget_lookup(4.0) == 1.0f);
    assert_true(render_budget_lookup(0.0) == 1.0f);  // none were wanted
}

// .15 photons per sample of the image, up to 2.5 times those of the options and those of
// production.
static void photons_grow_with_the_image(void **state) {
    (void)state;
    satin_options o = {.spp = 20, .photons = 300000};
    assert_true(render_budget_photons_most(&o, 1e4) == 1.0);
    assert_true(fabs(render_budget_photons_most(&o, 2e5) - 2.0) < 1e-9);
    assert_true(render_budget_photons_most(&o, 1e6) == 2.5);
    o.denoise = true;
    assert_true(render_budget_photons_most(&o, 1e6) == 1.0);
    o = (satin_options){.spp = 20, .photons = 2000000};
    assert_true(render_budget_photons_most(&o, 1e7) == 1.25);
    o.time = 10.0;
    assert_true(render_budget_photons_most(&o, 1e7) == 1.0);
}

// Half a photon of caustics per sample of the image, between those of the options and four times as
// many.
static void caustics_grow_with_the_image(void **state) {
    (void)state;
    satin_options o = {.spp = 20, .caustic_photons = 1000000};
    assert_true(render_budget_caustics_most(&o, 1e4) == 1.0);
    assert_true(render_budget_caustics_most(&o, 2e5) == 2.0);
    assert_true(render_budget_caustics_most(&o, 1e6) == 4.0);
    o.time = 10.0;
    assert_true(render_budget_caustics_most(&o, 1e6) == 1.0);
    o = (satin_options){.spp = 20};
    assert_true(render_budget_caustics_most(&o, 1e6) == 1.0);
}

static void starved_maps_alone_are_made_again(void **state) {
    (void)state;
    satin_options o = {.photons = 100000};
    assert_true(render_budget_starved(&o, 1000.0, 500.0) == 1.0);
    assert_true(render_budget_starved(&o, 1000.0, 2000.0) == 1.0);
    assert_true(render_budget_starved(&o, 1000.0, 125.0) == 4.0);
    assert_true(render_budget_starved(&o, 1000.0, 20.0) == 8.0);
    // At production a starved map gets as many paths as if the options had a million.
    o.photons = 2500000;
    assert_true(fabs(render_budget_starved(&o, 2.5e6, 0.1 * 2.5e6) - 5.0 / 2.5) < 1e-9);
    assert_true(fabs(render_budget_starved(&o, 2.5e6, 0.01 * 2.5e6) - 8.0 / 2.5) < 1e-9);
    o.time = 10.0;
    assert_true(render_budget_starved(&o, 2.5e6, 2.5e6) == 1.0);
    o.photons = 100000;
    o.time = 10.0;
    assert_true(render_budget_starved(&o, 1000.0, 500.0) == 2.5);
    assert_true(render_budget_starved(&o, 1000.0, 125.0) == 4.0);
    o.denoise = true;
    assert_true(render_budget_starved(&o, 1000.0, 500.0) == 1.0);
    assert_true(render_budget_grow(1.2) == 1.0);
    assert_true(render_budget_grow(4.0) == 4.0);
}

// Records get more time where more of the light is indirect, and less where the image is noisier.
// The noise of the image falls faster than the error of records: with more cores records get more.
static void records_get_the_time_that_the_pilot_suggests(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
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

// The first records cover the image soon where direct light is noisy, with time left if that takes
// longer, and in no case is more planned than without any measurement.
static void first_records_leave_time_for_noisy_direct_light(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
    struct render_pace pace = {.rays = 1e5, .samples = 1e5, .direct = 1e6, .indirect2 = 0.5};
    render_limit_records(&r, NULL);
    const double planned = render_budget_first_round(&r), limit = r.progress.deadline;
    render_limit_first_records(&r, &pace);
    const double noisy = render_budget_first_round(&r);
    assert_true(0.0 < noisy && noisy < 0.5 * planned);
    assert_true(r.progress.deadline > 2.0 * noisy && r.progress.deadline < limit - 10.0);
    pace.direct = 0.0;
    render_limit_first_records(&r, &pace);
    assert_true(render_budget_first_round(&r) > 2.0 * noisy);
    assert_true(render_budget_first_round(&r) < planned + 1.0);
    assert_true(fabs(r.progress.deadline - limit) < 1.0);
    // What takes longer than planned goes on with a tenth of the rest.
    r.progress.covered = 0.0;
    assert_true(render_budget_first_round(&r) > 10.0);
    parallel_free(r.pool);
}

// Paths replace two passes where a pixel would have less than 2 samples, unless records are kept
// in a file.
static void few_samples_lead_to_paths(void **state) {
    (void)state;
    struct render r = budget_case(10.0);
    r.options.integrator = SATIN_TWO_PASS;
    assert_true(render_budget_traces_paths(&r, 1900.0));
    assert_false(render_budget_traces_paths(&r, 2100.0));
    r.callbacks.save_cache = "a.cache";
    assert_false(render_budget_traces_paths(&r, 1000.0));
    parallel_free(r.pool);
}

// Photons, samples and items of random numbers may be more than 32 bits count.
static void counts_do_not_wrap_at_32_bits(void **state) {
    (void)state;
    const uint64_t billions = 1000000000000, beyond = (uint64_t)1 << 33;
    const satin_options many = {.photons = (int64_t)billions,
                                .caustic_photons = (int64_t)billions - 1,
                                .first_pass = SATIN_FIRST_PHOTONS};
    const struct photon_paths paths = render_budget_paths(&many, 0.0);
    assert_true(paths.global == billions && paths.caustic == billions - 1);
    assert_true(render_fraction((int64_t)billions, 0.5) == (int64_t)(billions / 2));
    struct render r = budget_case(0.0);
    r.options.integrator = SATIN_PATH;
    r.options.width = r.options.height = 1 << 13;
    r.options.spp = 1 << 20;
    assert_true(render_budget_pass(&r, beyond, 0.0) == beyond);
    const uint64_t all = (uint64_t)1 << 46;
    assert_true(render_budget_pass(&r, all - 5, 0.0) == 5);
    struct rng near = rng_make(1, RNG_TEST, 7), far = rng_make(1, RNG_TEST, beyond + 7);
    assert_int_not_equal(rng_u32(&near), rng_u32(&far));
    struct stats stats = {0};
    stats_set(&stats, "photons.emitted", (double)beyond);
    stats_add(&stats, "photons.emitted", 1.0);
    assert_true((uint64_t)stats_get(&stats, "photons.emitted") == beyond + 1);
    parallel_free(r.pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_samples_lead_to_paths),
        cmocka_unit_test(no_limit_ends_nothing),
        cmocka_unit_test(steps_end_in_their_order),
        cmocka_unit_test(the_pilot_takes_a_tenth_at_most),
        cmocka_unit_test(a_limit_that_is_over_is_no_cancellation),
        cmocka_unit_test(photons_fit_into_the_time_or_are_left_out),
        cmocka_unit_test(photons_that_nothing_replaces_fit),
        cmocka_unit_test(counts_do_not_wrap_at_32_bits),
        cmocka_unit_test(the_number_of_paths_follows_from_that_of_photons),
        cmocka_unit_test(as_many_paths_show_the_view_as_it_can_hold),
        cmocka_unit_test(a_short_limit_measures_less),
        cmocka_unit_test(visibility_is_measured_by_what_a_limit_allows),
        cmocka_unit_test(rays_per_bin_grow_with_photons),
        cmocka_unit_test(samples_gather_less_with_a_limit),
        cmocka_unit_test(lookups_of_fewer_photons_are_wider),
        cmocka_unit_test(photons_grow_with_the_image),
        cmocka_unit_test(caustics_grow_with_the_image),
        cmocka_unit_test(starved_maps_alone_are_made_again),
        cmocka_unit_test(records_get_the_time_that_the_pilot_suggests),
        cmocka_unit_test(first_records_leave_time_for_noisy_direct_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
