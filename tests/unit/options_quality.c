// SPDX-License-Identifier: Apache-2.0
// The options as functions of effort: they pass through the presets, are monotonous between and
// beyond them, begin at the first, and do not change options that the user chose.
#include "render/options_quality.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "render/options_table.h"

static const double PIXELS = 80000.0;

static satin_options options_quality_make(satin_quality quality) {
    satin_options o = satin_options_default;
    satin_options_preset(&o, quality);
    return o;
}

static void the_default_is_preview(void **state) {
    (void)state;
    const satin_options o = options_quality_make(SATIN_PREVIEW);
    assert_memory_equal(&o, &satin_options_default, sizeof o);
}

static void little_time_gives_a_draft_and_production_its_own(void **state) {
    (void)state;
    satin_options least = options_quality_make(SATIN_DRAFT),
                  last = options_quality_make(SATIN_PRODUCTION);
    options_quality_seconds(&least, 1e-9, PIXELS);
    options_quality_seconds(&last, 9e-4 * PIXELS, PIXELS);
    satin_options draft = options_quality_make(SATIN_DRAFT),
                  production = options_quality_make(SATIN_PRODUCTION);
    // Samples that fit are more than those of the preset, so each has fewer gather rays; with
    // little time they are fewer than those of draft, so each has fewer light samples, and
    // finer rounds of records follow coarser ones. A long limit has time for more photons than the
    // preset, whose time goes to its samples, and more records of fewer rays.
    draft.glossy_samples = production.glossy_samples = 2;
    draft.light_samples = 2;
    draft.radiance_a = 0.4f;
    production.photons = 2500000;
    production.caustic_photons = 4000000;
    production.irradiance_rays = 2000;
    assert_memory_equal(&least, &draft, sizeof least);
    assert_memory_equal(&last, &production, sizeof last);
}

// Compares ten seconds of 64 cores with ten of two, which production takes.
static void many_cores_ask_for_more(void **state) {
    (void)state;
    satin_options two = options_quality_make(SATIN_PREVIEW),
                  many = options_quality_make(SATIN_PREVIEW);
    const double pixels = 2.0 * 10.0 / 9e-4;
    options_quality_seconds(&two, 2.0 * 10.0, pixels);
    options_quality_seconds(&many, 64.0 * 10.0, pixels);
    assert_int_equal(two.irradiance_rays, 2000);
    assert_true(2 * many.irradiance_rays > 3 * two.irradiance_rays);
    assert_true(2 * many.radiance_rays > 3 * two.radiance_rays);
    assert_true(many.photons > 2 * two.photons && many.caustic_photons > 2 * two.caustic_photons);
}

// With any time, the options are within the ranges that the user may give.
static void no_time_leaves_the_ranges(void **state) {
    (void)state;
    satin_options o = options_quality_make(SATIN_PREVIEW);
    options_quality_seconds(&o, 1e18, 1.0);
    assert_int_equal(o.radiance_rays, 1048576);
    for (int i = 0; i < options_table_count; i++) {
        char text[OPTION_TEXT_SIZE];
        satin_options again = o;
        option_print(&options_table[i], &o, text, sizeof text);
        if (options_table[i].by_quality) assert_true(option_parse(&options_table[i], text, &again));
    }
}

static void more_time_never_buys_less(void **state) {
    (void)state;
    satin_options before = options_quality_make(SATIN_PREVIEW);
    options_quality_seconds(&before, 0.01, PIXELS);
    for (double seconds = 0.01; seconds < 1e7; seconds *= 1.07) {
        satin_options o = options_quality_make(SATIN_PREVIEW);
        options_quality_seconds(&o, seconds, PIXELS);
        assert_true(o.photons >= before.photons && o.caustic_photons >= before.caustic_photons);
        assert_true(o.irradiance_rays >= before.irradiance_rays);
        assert_true(o.radiance_rays >= before.radiance_rays);
        assert_true(o.irradiance_a <= before.irradiance_a && o.radiance_a <= before.radiance_a);
        assert_true(o.light_samples >= before.light_samples);
        before = o;
    }
}

// The number of photons depends on the time of the whole image, all else on that of a pixel: four
// times the pixels in four times the seconds change the photons alone.
static void seconds_are_divided_by_pixels(void **state) {
    (void)state;
    satin_options small = options_quality_make(SATIN_PREVIEW),
                  large = options_quality_make(SATIN_PREVIEW);
    options_quality_seconds(&small, 12.0, PIXELS);
    options_quality_seconds(&large, 48.0, 4.0 * PIXELS);
    assert_true(large.photons > small.photons);
    large.photons = small.photons;
    large.caustic_photons = small.caustic_photons;
    assert_memory_equal(&small, &large, sizeof small);
}

// The time decides the options, whatever the quality is, except for those that the user chose.
static void options_that_the_user_chose_stay(void **state) {
    (void)state;
    satin_options draft = options_quality_make(SATIN_DRAFT),
                  production = options_quality_make(SATIN_PRODUCTION);
    draft.photons = production.photons = 7;
    draft.radiance_a = production.radiance_a = 0.77f;
    options_quality_seconds(&draft, 20.0, PIXELS);
    options_quality_seconds(&production, 20.0, PIXELS);
    assert_int_equal(draft.photons, 7);
    assert_true(draft.radiance_a == 0.77f);
    production.quality = SATIN_DRAFT;
    assert_memory_equal(&draft, &production, sizeof draft);
}

static void a_denoised_image_takes_samples_rather_than_glossy_rays(void **state) {
    (void)state;
    satin_options noisy = options_quality_make(SATIN_PREVIEW), denoised = noisy, chosen = noisy;
    denoised.denoise = chosen.denoise = true;
    chosen.glossy_samples = 3;
    options_quality_seconds(&noisy, 20.0, PIXELS);
    options_quality_seconds(&denoised, 20.0, PIXELS);
    options_quality_seconds(&chosen, 20.0, PIXELS);
    assert_true(noisy.glossy_samples > 1);
    assert_int_equal(denoised.glossy_samples, 1);
    assert_int_equal(chosen.glossy_samples, 3);
}

// More time gives more passes, not larger ones.
static void passes_of_sppm_do_not_grow(void **state) {
    (void)state;
    const satin_options draft = options_quality_make(SATIN_DRAFT);
    for (double seconds = 1.0; seconds < 2000.0; seconds *= 10.0) {
        satin_options o = options_quality_make(SATIN_PREVIEW);
        o.integrator = SATIN_SPPM;
        options_quality_seconds(&o, seconds, PIXELS);
        assert_int_equal(o.photons, draft.photons);
        assert_int_equal(o.caustic_photons, draft.caustic_photons);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_default_is_preview),
        cmocka_unit_test(little_time_gives_a_draft_and_production_its_own),
        cmocka_unit_test(many_cores_ask_for_more),
        cmocka_unit_test(no_time_leaves_the_ranges),
        cmocka_unit_test(more_time_never_buys_less),
        cmocka_unit_test(seconds_are_divided_by_pixels),
        cmocka_unit_test(options_that_the_user_chose_stay),
        cmocka_unit_test(a_denoised_image_takes_samples_rather_than_glossy_rays),
        cmocka_unit_test(passes_of_sppm_do_not_grow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
