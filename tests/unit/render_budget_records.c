// SPDX-License-Identifier: Apache-2.0
// How much work records are: rounds become finer until they end, and the rays of the first round
// are those that its time allows.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/render_budget.h"

static satin_options make(satin_quality quality) {
    satin_options o = satin_options_default;
    satin_options_preset(&o, quality);
    o.time = 10.0;
    return o;
}

static void check_rounds(const satin_options *o) {
    const int rounds = render_budget_rounds(o);
    assert_in_range(rounds, 5, 20);
    struct render_widths before = render_budget_round(o, 0);
    for (int i = 0; i < rounds; i++) {
        const struct render_widths widths = render_budget_round(o, i);
        bool finer = i == 0;
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
            assert_true(widths.of[k] > 0.0f && widths.of[k] <= before.of[k]);
            assert_true(widths.of[k] <= render_budget_widest(o));
            finer |= widths.of[k] < before.of[k];
        }
        assert_true(finer);
        before = widths;
    }
}

static void rounds_become_finer_until_they_end(void **state) {
    (void)state;
    satin_options o = make(SATIN_DRAFT);
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
    satin_options o = make(SATIN_PREVIEW);
    for (float pixels = 1.0f; pixels < 50.0f; pixels *= 2.0f) {
        o.irradiance_min_pixels = o.radiance_min_pixels = pixels;
        const struct render_widths w = render_budget_round(&o, render_budget_rounds(&o) - 1);
        for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
            assert_true(fabsf(w.of[k] * render_budget_least_radius(w.of[k]) * pixels - 0.5f) <
                        1e-3f);
    }
    assert_true(render_budget_least_radius(2.5f) == 1.0f);
}

static void no_record_is_read_wider_than_it_may_be(void **state) {
    (void)state;
    satin_options o = make(SATIN_PREVIEW);
    o.irradiance_widen = 3.0f;
    assert_true(render_budget_widest(&o) == 3.0f);
    o.irradiance_widen = o.radiance_widen = 1.5f;
    assert_true(render_budget_widest(&o) == render_budget_round(&o, 0).of[CACHE_RADIANCE]);
    o.time = 0.0;
    assert_true(render_budget_widest(&o) == 1.5f);
}

static void coarse_records_get_more_rays(void **state) {
    (void)state;
    const satin_options o = make(SATIN_PREVIEW);  // 600 rays
    const struct render_covering all = {.rays = RENDER_COARSEST}, half = {.rays = 0.5f}, few = {0};
    for (int stride = 1; stride <= RENDER_COARSEST; stride *= 2) {
        assert_true(render_budget_rays(&o, &all, stride) == 1.0f);
        assert_true(render_budget_rays(&o, &half, stride) >=
                    fmaxf(0.5f * (float)stride / RENDER_COARSEST, 32.0f / 600.0f));
        assert_true(render_budget_rays(&o, &few, stride) == 32.0f / 600.0f);
    }
    assert_true(render_budget_rays(&o, &half, RENDER_COARSEST) == 0.5f);
}

// After a level of 100 records by all rays in a second, a level finer than the coarsest one.
static struct render_covering after_level(const satin_options *o, int stride, double left) {
    struct render_covering c = {.rays = RENDER_COARSEST, .records = 100.0};
    render_budget_level(o, &c, stride, 100.0, 1.0, left);
    return c;
}

static void rays_are_what_the_time_allows(void **state) {
    (void)state;
    const satin_options o = make(SATIN_PRODUCTION);  // 2000 rays
    // The last level makes 1.4 times the records of the one before it.
    for (double left = 0.1; left < 1.4; left *= 2.0) {
        const struct render_covering c = after_level(&o, 2, left);
        assert_true(fabs(1.4 * (double)render_budget_rays(&o, &c, 1) - left) < 1e-3);
    }
    float before = 0.0f;
    for (double left = 0.01; left < 100.0; left *= 2.0) {
        const struct render_covering c = after_level(&o, RENDER_COARSEST, left);
        const float rays = render_budget_rays(&o, &c, 1);
        assert_true(rays >= before);
        before = rays;
    }
    const struct render_covering none = after_level(&o, RENDER_COARSEST, 0.0);
    assert_true(render_budget_rays(&o, &none, 16) == 32.0f / 2000.0f);
    assert_true(before == 1.0f);
    const struct render_covering last = after_level(&o, 1, 0.0);
    assert_true(last.rays == RENDER_COARSEST);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rounds_become_finer_until_they_end),
        cmocka_unit_test(the_last_records_are_half_a_pixel_wide),
        cmocka_unit_test(no_record_is_read_wider_than_it_may_be),
        cmocka_unit_test(coarse_records_get_more_rays),
        cmocka_unit_test(rays_are_what_the_time_allows),
        cmocka_unit_test(adaptive_caching_compares_a_bounded_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
