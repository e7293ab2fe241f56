// SPDX-License-Identifier: Apache-2.0
// The first round of records with a time limit has the rays that its time allows, the rounds become
// finer until they end, and adaptive caching compares a bounded number of points.
#include "render/render_budget.h"

#include <math.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static satin_options options_of(satin_quality quality) {
    satin_options o = satin_options_default;
    satin_options_preset(&o, quality);
    o.time = 10.0;
    return o;
}

static void coarse_records_get_more_rays(void **state) {
    (void)state;
    const satin_options o = options_of(SATIN_PREVIEW);  // 600 rays
    const struct render_covering all = {.rays = RENDER_COARSEST}, half = {.rays = 0.5f}, few = {0};
    for (int stride = 1; stride <= RENDER_COARSEST; stride *= 2) {
        assert_true(render_covering_rays(&o, &all, stride) == 1.0f);
        assert_true(render_covering_rays(&o, &half, stride) >=
                    fmaxf(0.5f * (float)stride / RENDER_COARSEST, 100.0f / 600.0f));
        assert_true(render_covering_rays(&o, &few, stride) == 100.0f / 600.0f);
    }
    assert_true(render_covering_rays(&o, &half, RENDER_COARSEST) == 0.5f);
}

// The plan of a level at whose `needed` sites seven tenths of that number of records are expected,
// after 100 records by all rays in a second.
static struct render_covering planned(const satin_options *o, int stride, double needed,
                                      double left) {
    struct render_covering c = {.rays = RENDER_COARSEST};
    render_covering_filled(o, &c, stride, 100.0, 1.0);
    render_covering_next(&c);
    render_covering_plan(o, &c, stride, 1000.0, needed, left);
    return c;
}

static void the_time_limits_the_rays_of_records(void **state) {
    (void)state;
    const satin_options o = options_of(SATIN_PRODUCTION);  // 4000 rays
    for (double left = 0.1; left < 0.7; left *= 2.0) {
        const struct render_covering c = planned(&o, 1, 100.0, left);
        assert_true(fabs(0.7 * (double)render_covering_rays(&o, &c, 1) - left) < 1e-3);
    }
    float before = 0.0f;
    for (double left = 0.01; left < 100.0; left *= 2.0) {
        const struct render_covering c = planned(&o, RENDER_COARSEST, 100.0, left);
        const float rays = render_covering_rays(&o, &c, 1);
        assert_true(rays >= before);
        before = rays;
    }
    assert_true(before == 1.0f);
    const struct render_covering none = planned(&o, RENDER_COARSEST, 100.0, 0.0);
    assert_true(render_covering_rays(&o, &none, 16) == 100.0f / 4000.0f);
    struct render_covering first = {0};
    render_covering_plan(&o, &first, RENDER_COARSEST, 1000.0, 100.0, 0.0);
    assert_true(first.rays == RENDER_COARSEST);
}

// What covers the same area in fewer sites leaves them more rays.
static void uncovered_sites_limit_the_rays(void **state) {
    (void)state;
    const satin_options o = options_of(SATIN_PRODUCTION);
    float before = INFINITY;
    for (double needed = 1.0; needed < 1e6; needed *= 4.0) {
        const struct render_covering c = planned(&o, 8, needed, 1.0);
        assert_true(c.rays <= before);
        before = c.rays;
    }
    assert_true(before < 0.1f);
}

// Two of three seconds were spent on 200 records by a quarter of their rays: these count as 50.
static void few_rays_foretell_a_longer_round(void **state) {
    (void)state;
    const satin_options o = options_of(SATIN_PRODUCTION);
    struct render_covering c = {.rays = RENDER_COARSEST};
    assert_true(render_covering_by_all_rays(&c, 3.0) == 3.0);
    render_covering_filled(&o, &c, 1, 100.0, 1.0);
    assert_true(render_covering_by_all_rays(&c, 3.0) == 3.0);
    render_covering_next(&c);
    c.rays = 0.25f;
    render_covering_filled(&o, &c, RENDER_COARSEST, 200.0, 2.0);
    assert_true(render_covering_by_all_rays(&c, 3.0) == 6.0);
}

static void levels_that_take_too_long_to_search_do_not_pay(void **state) {
    (void)state;
    struct render_covering c = {0};
    assert_true(render_covering_pays(&c, 1e9, 1e-3));  // not measured yet
    c.pixels = 1e6;
    c.search = 1.0;
    assert_true(render_covering_search(&c, 2e6) == 2.0);
    assert_true(render_covering_pays(&c, 1e6, 10.0));
    assert_false(render_covering_pays(&c, 1e6, 1.5));
    assert_false(render_covering_pays(&c, 1e6, -1.0));
    // Records of a level that does not pay need no rays.
    const satin_options o = options_of(SATIN_PRODUCTION);
    struct render_covering all = planned(&o, 2, 100.0, 1.0), fewer = all;
    all.search = 0.0;
    fewer.search = 1.0;
    all.pixels = fewer.pixels = 1000.0;
    render_covering_plan(&o, &all, 2, 1000.0, 100.0, 1.0);
    render_covering_plan(&o, &fewer, 2, 1000.0, 100.0, 1.0);
    assert_true(fewer.rays > all.rays);
}

static void check_rounds(const satin_options *o) {
    const int rounds = render_budget_rounds(o);
    assert_in_range(rounds, 5, 20);
    struct render_factors before = render_budget_round(o, 0);
    for (int i = 0; i < rounds; i++) {
        const struct render_factors factors = render_budget_round(o, i);
        bool finer = i == 0;
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
            assert_true(factors.of[k] > 0.0f && factors.of[k] <= before.of[k]);
            assert_true(factors.of[k] <= render_budget_largest_factor(o));
            finer |= factors.of[k] < before.of[k];
        }
        assert_true(finer);
        before = factors;
    }
}

static void rounds_become_finer_until_they_end(void **state) {
    (void)state;
    satin_options o = options_of(SATIN_DRAFT);
    for (float pixels = 0.125f; pixels < 100.0f; pixels *= 2.0f) {
        o.irradiance_min_pixels = pixels;
        o.radiance_min_pixels = 4.0f;
        check_rounds(&o);
        o.irradiance_min_pixels = 0.0f;
        o.radiance_min_pixels = pixels;
        check_rounds(&o);
    }
}

// The least radius falls with a, and is half a pixel at a record's edge in the last round.
static void the_last_records_are_half_a_pixel_wide(void **state) {
    (void)state;
    satin_options o = options_of(SATIN_PREVIEW);
    for (float pixels = 1.0f; pixels < 50.0f; pixels *= 2.0f) {
        o.irradiance_min_pixels = o.radiance_min_pixels = pixels;
        const struct render_factors w = render_budget_round(&o, render_budget_rounds(&o) - 1);
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
            assert_true(fabsf(w.of[k] * render_budget_least_radius(w.of[k]) * pixels - 0.5f) <
                        1e-3f);
    }
    assert_true(render_budget_least_radius(2.5f) == 1.0f);
}

// The search has the factors of a round, or those of the finished one before it, widened. It never
// grows.
static void records_are_found_where_they_are_read(void **state) {
    (void)state;
    satin_options o = options_of(SATIN_PREVIEW);
    o.irradiance_widen = 2.0f;
    o.radiance_widen = 1.2f;
    const float first = render_budget_search(&o, 0).of[CACHE_IRRADIANCE];
    assert_true(first == CACHE_WIDER * render_budget_largest_factor(&o));
    for (int i = 1; i < render_budget_rounds(&o); i++) {
        const struct render_factors found = render_budget_search(&o, i);
        const struct render_factors finished = render_budget_round(&o, i - 1);
        const float widen[CACHE_KINDS] = {o.irradiance_widen, o.radiance_widen};
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
            const float most = render_budget_largest_factor(&o);
            assert_true(found.of[k] >= fminf(finished.of[k] * widen[k], most));
            assert_true(found.of[k] >= render_budget_round(&o, i).of[k]);
            assert_true(found.of[k] <= render_budget_search(&o, i - 1).of[k]);
        }
    }
    assert_true(render_budget_search(&o, 5).of[CACHE_IRRADIANCE] < 0.5f * first);
    o.time = 0.0;
    assert_true(render_budget_search(&o, 0).of[CACHE_RADIANCE] == 2.0f);
}

static void no_record_is_read_wider_than_it_may_be(void **state) {
    (void)state;
    satin_options o = options_of(SATIN_PREVIEW);
    o.irradiance_widen = 3.0f;
    assert_true(render_budget_largest_factor(&o) == 3.0f);
    o.irradiance_widen = o.radiance_widen = 1.5f;
    assert_true(render_budget_largest_factor(&o) == render_budget_round(&o, 0).of[CACHE_RADIANCE]);
    o.time = 0.0;
    assert_true(render_budget_largest_factor(&o) == 1.5f);
}

static void adaptive_caching_compares_a_bounded_number(void **state) {
    (void)state;
    for (int width = 1; width < 40000; width = 2 * width + 1)
        for (int height = 1; height < 40000; height = 2 * height + 1) {
            const int stride = render_budget_adaptive_stride(width, height);
            const int64_t pixels = (int64_t)width * height;
            assert_true(stride >= 2 && pixels / stride / stride <= 1 << 18);
            assert_true(stride == 2 || pixels / (stride - 1) / (stride - 1) > 1 << 18);
        }
}

static void a_view_whose_pixels_are_covered_is_left(void **state) {
    (void)state;
    assert_true(render_budget_view_pays(1.0, RENDER_VIEW_PIXELS));
    assert_false(render_budget_view_pays(0.0, 1.0));
    assert_false(render_budget_view_pays(1.0, RENDER_VIEW_PIXELS + 1.0));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coarse_records_get_more_rays),
        cmocka_unit_test(the_time_limits_the_rays_of_records),
        cmocka_unit_test(uncovered_sites_limit_the_rays),
        cmocka_unit_test(few_rays_foretell_a_longer_round),
        cmocka_unit_test(levels_that_take_too_long_to_search_do_not_pay),
        cmocka_unit_test(rounds_become_finer_until_they_end),
        cmocka_unit_test(the_last_records_are_half_a_pixel_wide),
        cmocka_unit_test(records_are_found_where_they_are_read),
        cmocka_unit_test(no_record_is_read_wider_than_it_may_be),
        cmocka_unit_test(adaptive_caching_compares_a_bounded_number),
        cmocka_unit_test(a_view_whose_pixels_are_covered_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
