// SPDX-License-Identifier: Apache-2.0
// What of an image is denoised, by a library that makes every pixel the mean of its image: the
// light of no record, and that of records, too, of an image of few samples. Never emission.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "render/render_image.h"

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

static struct render render_denoise_make(void) {
    struct render r = {.options = satin_options_default};
    r.options.denoise = true;
    r.scene.film.crop_width = WIDTH;
    r.scene.film.crop_height = HEIGHT;
    r.pool = parallel_new(2);
    r.image = render_image_new(&r.scene, &r.options);
    assert_true(r.pool && r.image);
    assert_int_equal(render_denoiser(&r), SATIN_OK);
    r.image->aovs = &r.scene.hints.aovs;
    return r;
}

static void render_denoise_stop(struct render *r) {
    film_denoiser_free(r->denoiser);
    render_image_free(r->image);
    parallel_free(r->pool);
}

// Each pixel has `samples` samples of weight 1: a light of 1 from records in half of the pixels,
// of 2 from none in a quarter, and an emission of 8 in another half.
static void render_denoise_fill(struct render *r, int samples) {
    for (size_t i = 0; i < PIXELS; i++) {
        const float n = (float)samples;
        const rgb cached = rgb_grey(i % 2 ? n : 0.0f), uncached = rgb_grey(i % 4 ? 0.0f : 2.0f * n);
        struct image_pixel *p = &r->image->pixel[i];
        p->samples = (uint32_t)samples;
        p->weight = n;
        p->layer[SHADE_EMISSION] = rgb_grey(i < PIXELS / 2 ? 8.0f * n : 0.0f);
        p->beauty = rgb_add(rgb_add(cached, uncached), p->layer[SHADE_EMISSION]);
        r->image->uncached[i].light = uncached;
    }
    r->image->taken = (uint64_t)samples * PIXELS;
}

// Denoises an image of so many samples per pixel; `records`: whether there is a cache.
static void check_denoised(int samples, bool records, bool all) {
    struct render r = render_denoise_make();
    // Whether there is one is all that counts.
    if (records) r.second_pass.shade.records.cache = (struct cache *)&r;
    render_denoise_fill(&r, samples);
    render_denoise(&r);
    assert_int_equal(r.outcome.denoised, SATIN_OK);
    bool found;
    render_image_film(&r, &found);
    const float *red = film_channel(r.image->film, "R");
    for (size_t i = 0; i < PIXELS; i++) {
        const float emission = i < PIXELS / 2 ? 8.0f : 0.0f, cached = i % 2 ? 1.0f : 0.0f;
        const float reflected = all ? 0.5f + 0.5f : cached + 0.5f;
        assert_true(fabsf(red[i] - reflected - emission) < 1e-4f);
    }
    assert_true((stats_get(&r.stats, "image.denoised_records") > 0.0) == all);
    render_denoise_stop(&r);
}

static void few_samples_have_the_light_of_records_denoised(void **state) {
    (void)state;
    check_denoised(2, true, true);
    check_denoised(15, true, true);
}

static void many_samples_leave_it_as_it_is(void **state) {
    (void)state;
    check_denoised(16, true, false);
    check_denoised(64, true, false);
}

static void without_records_it_is_not_asked(void **state) {
    (void)state;
    check_denoised(2, false, false);
}

int main(void) {
    setenv("SATIN_OIDN", getenv("FAKE_OIDN_LIBRARY"), 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_samples_have_the_light_of_records_denoised),
        cmocka_unit_test(many_samples_leave_it_as_it_is),
        cmocka_unit_test(without_records_it_is_not_asked)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
