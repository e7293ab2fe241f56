// SPDX-License-Identifier: Apache-2.0
// What of an image is denoised, by a library that makes every pixel the mean of its image:
// reflected light, as far as its noise explains the change, and never emission.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "render/render_image.h"

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

static struct render render_denoise_new(void) {
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

// Each pixel has two samples of weight 1, which differ by `noise` from their mean: a light of 1
// from records in half of the pixels, of 2 from none in a quarter, and an emission of 8 in another
// half.
static void render_denoise_fill(struct render *r, float noise) {
    for (size_t i = 0; i < PIXELS; i++) {
        const float cached = i % 2 ? 1.0f : 0.0f, uncached = i % 4 ? 0.0f : 2.0f;
        struct image_pixel *p = &r->image->pixel[i];
        p->samples = 2;
        p->weight = 2.0f;
        p->layer[SHADE_EMISSION] = rgb_grey(i < PIXELS / 2 ? 16.0f : 0.0f);
        p->beauty = rgb_add(rgb_grey(2.0f * (cached + uncached)), p->layer[SHADE_EMISSION]);
        r->image->uncached[i].light = rgb_grey(2.0f * uncached);
        r->image->uncached[i].odd = rgb_grey(cached + uncached + noise);
        r->image->uncached[i].odd_weight = 1.0f;
    }
    r->image->taken = 2 * PIXELS;
}

// An image of such pixels with records: whether there is a cache is all that counts.
static struct render render_denoise_make(float noise) {
    static char some;
    struct render r = render_denoise_new();
    r.second_pass.shade.records.cache = (struct cache *)&some;
    render_denoise_fill(&r, noise);
    return r;
}

// Whether pixel i is the sum of its emission, of its cached light times `cached`, of its other
// light times `uncached`, and of `mean`.
static void check_pixel(const struct render *r, size_t i, float cached, float uncached,
                        float mean) {
    const float emission = i < PIXELS / 2 ? 8.0f : 0.0f;
    const float L = cached * (i % 2 ? 1.0f : 0.0f) + uncached * (i % 4 ? 0.0f : 2.0f);
    const float red = film_channel(r->image->film, "R")[i];
    assert_true(fabsf(red - L - emission - mean) < 1e-4f);
}

static void render_denoise_run(struct render *r) {
    bool found;
    render_denoise(r);
    assert_int_equal(r->outcome.denoised, SATIN_OK);
    render_image_film(r, &found);
}

// The mean of all reflected light is 1.
static void noisy_light_is_denoised_with_that_of_records(void **state) {
    (void)state;
    struct render r = render_denoise_make(2.0f);
    render_denoise_run(&r);
    for (size_t i = 0; i < PIXELS; i++) check_pixel(&r, i, 0.0f, 0.0f, 1.0f);
    render_denoise_stop(&r);
}

static void light_without_noise_is_left_as_it_is(void **state) {
    (void)state;
    struct render r = render_denoise_make(0.0f);
    render_denoise_run(&r);
    for (size_t i = 0; i < PIXELS; i++) check_pixel(&r, i, 1.0f, 1.0f, 0.0f);
    render_denoise_stop(&r);
}

// The change is at most 1, and a variance of a quarter of the difference between two samples, and
// so of a hundredth, explains a part of it. Light varies with a period of four pixels, which no
// seven pixels show equally.
static void noise_explains_a_part_of_a_change(void **state) {
    (void)state;
    struct render r = render_denoise_make(0.1f);
    render_denoise_run(&r);
    for (size_t i = 0; i < PIXELS; i++) {
        const float red = film_channel(r.image->film, "R")[i] - (i < PIXELS / 2 ? 8.0f : 0.0f);
        const float given = (i % 2 ? 1.0f : 0.0f) + (i % 4 ? 0.0f : 2.0f);
        if (given == 1.0f)
            assert_true(fabsf(red - 1.0f) < 1e-4f);
        else
            assert_true((red - given) / (1.0f - given) > 0.02f &&
                        (red - given) / (1.0f - given) < 0.08f);
    }
    render_denoise_stop(&r);
}

// Both samples of that pixel are as bright.
static void one_bright_pixel_does_not_keep_the_noise_around(void **state) {
    (void)state;
    struct render r = render_denoise_make(2.0f);
    const size_t bright = PIXELS - WIDTH / 2;
    r.image->pixel[bright].beauty = rgb_grey(200.0f);
    r.image->uncached[bright].odd = rgb_grey(100.0f);
    render_denoise_run(&r);
    const float mean = film_channel(r.image->film, "R")[bright];
    assert_true(mean < 2.0f);
    for (size_t i = 0; i < PIXELS; i++) check_pixel(&r, i, 0.0f, 0.0f, mean);
    render_denoise_stop(&r);
}

static void of_single_samples_the_noise_is_not_known(void **state) {
    (void)state;
    struct render r = render_denoise_make(0.0f);
    for (size_t i = 0; i < PIXELS; i++)
        r.image->uncached[i].odd_weight = i % 2 ? 0.0f : r.image->pixel[i].weight;
    render_denoise_run(&r);
    for (size_t i = 0; i < PIXELS; i++) check_pixel(&r, i, 0.0f, 0.0f, 1.0f);
    render_denoise_stop(&r);
}

// The mean of what is uncached is .5.
static void without_a_cache_the_rest_is_left(void **state) {
    (void)state;
    struct render r = render_denoise_make(2.0f);
    r.second_pass.shade.records.cache = NULL;
    render_denoise_run(&r);
    for (size_t i = 0; i < PIXELS; i++) check_pixel(&r, i, 1.0f, 0.0f, 0.5f);
    render_denoise_stop(&r);
}

// One in four pixels has samples, of which the light is twice the albedo; the others have features
// alone, of an albedo of 1.
static void pixels_without_samples_have_light_on_their_own_albedo(void **state) {
    (void)state;
    static char some;
    struct render r = render_denoise_new();
    r.second_pass.shade.records.cache = (struct cache *)&some;
    r.image->filled = true;
    for (int i = 0; i < PIXELS; i++) {
        const bool sampled = i % 2 == 0 && i / WIDTH % 2 == 0;
        const float albedo = i / WIDTH % 4 ? 0.25f : 0.5f;
        r.image->uncached[i].features.albedo = rgb_grey(sampled ? albedo : 1.0f);
        r.image->uncached[i].weight = 1.0f;
        if (!sampled) continue;
        r.image->pixel[i].samples = 1;
        r.image->pixel[i].weight = 1.0f;
        r.image->pixel[i].beauty = rgb_grey(2.0f * albedo);
    }
    render_denoise_run(&r);
    double mean = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        const bool sampled = i % 2 == 0 && i / WIDTH % 2 == 0;
        const float light = !sampled ? 2.0f : i / WIDTH % 4 ? 0.5f : 1.0f;
        assert_true(fabsf(r.image->noisy.light[i].r - light) < 1e-5f);
        assert_true(r.image->noisy.albedo[i].r == r.image->uncached[i].features.albedo.r);
        mean += (double)light / PIXELS;
    }
    const float *red = film_channel(r.image->film, "R");
    for (int i = 0; i < PIXELS; i++) assert_true(fabs((double)red[i] - mean) < 1e-4);
    render_denoise_stop(&r);
}

int main(void) {
    setenv("SATIN_OIDN", getenv("FAKE_OIDN_LIBRARY"), 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noisy_light_is_denoised_with_that_of_records),
        cmocka_unit_test(light_without_noise_is_left_as_it_is),
        cmocka_unit_test(noise_explains_a_part_of_a_change),
        cmocka_unit_test(one_bright_pixel_does_not_keep_the_noise_around),
        cmocka_unit_test(of_single_samples_the_noise_is_not_known),
        cmocka_unit_test(without_a_cache_the_rest_is_left),
        cmocka_unit_test(pixels_without_samples_have_light_on_their_own_albedo)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
