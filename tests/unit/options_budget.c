// SPDX-License-Identifier: Apache-2.0
// The curve from effort to options: it passes through the presets, never goes back between them,
// ends at the first and the last, and leaves alone what the user chose.
#include "render/options_budget.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "render/options_table.h"

static const double PIXELS = 160000.0;

static satin_options make(satin_quality quality) {
    satin_options o = satin_options_default;
    satin_options_preset(&o, quality);
    return o;
}

static void the_default_is_preview(void **state) {
    (void)state;
    const satin_options o = make(SATIN_PREVIEW);
    assert_memory_equal(&o, &satin_options_default, sizeof o);
}

static void little_and_much_time_give_the_ends(void **state) {
    (void)state;
    satin_options least = make(SATIN_DRAFT), most = make(SATIN_PRODUCTION);
    options_budget_seconds(&least, 1e-9, PIXELS);
    options_budget_seconds(&most, 1e9, PIXELS);
    const satin_options draft = make(SATIN_DRAFT), production = make(SATIN_PRODUCTION);
    assert_memory_equal(&least, &draft, sizeof least);
    assert_memory_equal(&most, &production, sizeof most);
}

static void more_time_never_buys_less(void **state) {
    (void)state;
    satin_options before = make(SATIN_PREVIEW);
    options_budget_seconds(&before, 0.01, PIXELS);
    for (double seconds = 0.01; seconds < 1e4; seconds *= 1.07) {
        satin_options o = make(SATIN_PREVIEW);
        options_budget_seconds(&o, seconds, PIXELS);
        assert_true(o.photons >= before.photons && o.caustic_photons >= before.caustic_photons);
        assert_true(o.irradiance_rays >= before.irradiance_rays);
        assert_true(o.radiance_rays >= before.radiance_rays);
        assert_true(o.irradiance_a <= before.irradiance_a && o.radiance_a <= before.radiance_a);
        assert_true(o.light_samples >= before.light_samples);
        before = o;
    }
}

// Photons go by the whole image, all else by its pixels: four times the pixels in four times the
// seconds change the photons alone.
static void seconds_are_shared_by_pixels(void **state) {
    (void)state;
    satin_options small = make(SATIN_PREVIEW), large = make(SATIN_PREVIEW);
    options_budget_seconds(&small, 12.0, PIXELS);
    options_budget_seconds(&large, 48.0, 4.0 * PIXELS);
    assert_true(large.photons > small.photons);
    large.photons = small.photons;
    large.caustic_photons = small.caustic_photons;
    assert_memory_equal(&small, &large, sizeof small);
}

// Whatever the quality says, it is the time that decides; but not over the user.
static void what_the_user_chose_stays(void **state) {
    (void)state;
    satin_options draft = make(SATIN_DRAFT), production = make(SATIN_PRODUCTION);
    draft.photons = production.photons = 7;
    draft.radiance_a = production.radiance_a = 0.77f;
    options_budget_seconds(&draft, 20.0, PIXELS);
    options_budget_seconds(&production, 20.0, PIXELS);
    assert_int_equal(draft.photons, 7);
    assert_true(draft.radiance_a == 0.77f);
    production.quality = SATIN_DRAFT;
    assert_memory_equal(&draft, &production, sizeof draft);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_default_is_preview),
        cmocka_unit_test(little_and_much_time_give_the_ends),
        cmocka_unit_test(more_time_never_buys_less),
        cmocka_unit_test(seconds_are_shared_by_pixels),
        cmocka_unit_test(what_the_user_chose_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
