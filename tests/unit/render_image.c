// SPDX-License-Identifier: Apache-2.0
// The passes of the image: how many samples each has, how many light samples the first ones, and
// how many rays the rims of lamps.
#include "render/render_budget.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "budget_case.h"
#include "render/render_image.h"

static void passes_grow_until_little_is_left(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
    const uint64_t pixels = 10000, done = 64 * pixels;
    assert_int_equal(render_budget_pass(&r, done, 1.0), 0);  // a tenth of a sample per pixel
    const uint64_t few = render_budget_pass(&r, done, 0.5);
    assert_true(few > 999 && few < 2 * pixels);
    const uint64_t many = render_budget_pass(&r, done, 0.001);
    assert_true(many > 490000 && many < 501000);
    assert_int_equal(render_budget_pass(&r, done, 1e-9), done);
    // Some pixels get the second of their equal samples, also if all samples are equal.
    for (int adaptive = 1; adaptive >= 0; adaptive--) {
        r.options.adaptive_sampling = adaptive;
        assert_int_equal(render_budget_pass(&r, pixels, 0.06), pixels);
        const uint64_t some = render_budget_pass(&r, pixels, 0.5);
        assert_true(some > 1500 && some < 2500);
        assert_int_equal(render_budget_pass(&r, pixels, 1.0), 0);
    }
    // A pass of sppm has one sample of each.
    r.options.integrator = SATIN_SPPM;
    assert_int_equal(render_budget_pass(&r, pixels, 0.06), pixels);
    assert_int_equal(render_budget_pass(&r, pixels, 0.5), 0);
    parallel_free(r.pool);
}

// Counts the samples of all passes of a render without a time limit, whose equal samples come
// first.
static void check_passes(const struct render *r, uint64_t equal) {
    const uint64_t pixels = 10000, all = (uint64_t)r->options.spp * pixels;
    uint64_t done = 0, more;
    assert_int_equal(render_budget_equal_samples(&r->options), equal);
    while ((more = render_budget_pass(r, done, 1e9)) > 0) {
        assert_true(more <= (done > pixels ? done : pixels));
        if (done < equal * pixels) assert_true(more % pixels == 0 && done + more <= equal * pixels);
        done += more;
    }
    assert_int_equal(done, all);
}

static void passes_take_what_the_options_say(void **state) {
    (void)state;
    struct render r = budget_case(0.0);
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

static void rays_at_rims_are_a_fraction_of_the_samples(void **state) {
    (void)state;
    const size_t pixels = 1 << 16;
    // Most rays of a pixel, by samples per pixel or core seconds.
    static const struct {
        int spp;
        double core_seconds;
        uint32_t most;
    } row[] = {{1, 0.0, 128},    {9, 0.0, 256}, {16, 0.0, 512}, {36, 0.0, 1024},
               {512, 0.0, 1024}, {9, 0.5, 128}, {9, 4.0, 512},  {9, 1e9, 1024}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        satin_options o = satin_options_default;
        o.spp = row[i].spp;
        o.time = row[i].core_seconds > 0.0 ? 1.0 : 0.0;
        for (size_t rims = 1; rims <= pixels; rims *= 2) {
            const double fraction = (double)rims / (double)pixels;
            struct render_rim_rays known = {.fraction = fraction, .first = 4};
            const uint32_t rays = render_budget_rim_rays(&o, row[i].core_seconds, &known);
            assert_true(rays > 0 && (rays & (rays - 1)) == 0);
            assert_true(rays * rims <= 16 * pixels);
            assert_true(rays == row[i].most || 2 * rays * rims > 16 * pixels);
            known.seconds = 1e-4 * (double)rims;
            const uint32_t fit = render_budget_rim_rays(&o, row[i].core_seconds, &known);
            const double most = o.time > 0.0 ? 0.05 * row[i].core_seconds : INFINITY;
            assert_true(fit * known.seconds <= most && fit <= rays);
            assert_true(fit == rays || 2.0 * (fit + 0.5) * known.seconds > most);
            known = (struct render_rim_rays){.fraction = fraction, .first = 1, .late = true};
            const uint32_t late = render_budget_rim_rays(&o, row[i].core_seconds, &known);
            assert_true(late > 0 && late <= rays && late * rims <= 2 * pixels);
        }
        // Where all pixels have many rays, those at rims have at least as many.
        const struct render_rim_rays all = {.fraction = 1.0, .first = 32};
        assert_true(render_budget_rim_rays(&o, row[i].core_seconds, &all) == 64);
    }
}

// Light samples become fewer where less than two samples of each pixel fit, down to two.
static void short_limits_have_fewer_light_samples(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
    render_limit_image(&r);
    const double pixels = 10000.0, seconds = r.progress.deadline;
    r.options.light_samples = 8;
    assert_int_equal(render_budget_lights(&r, seconds / (pixels * 1.6)), 8);
    // Three quarters of the samples that should fit: the time of half of the light samples.
    assert_int_equal(render_budget_lights(&r, seconds / (pixels * 1.13)), 4);
    assert_int_equal(render_budget_lights(&r, seconds / (pixels * 0.5)), 2);
    r.options.light_samples = 1;
    assert_int_equal(render_budget_lights(&r, seconds / (pixels * 0.5)), 1);
    parallel_free(r.pool);
}

// What the filter of noise takes is kept as soon as it is known that enough pixels will have a
// sample, half of it before they have, unless it is more than a quarter of the limit.
static void time_for_the_filter_of_noise_is_kept(void **state) {
    (void)state;
    static const double PIXEL_SECONDS[] = {0.01, 0.03}, KEPT[] = {100.0, 0.0};
    for (int i = 0; i < 2; i++) {
        struct render r = budget_case(1000.0);
        struct image_noisy light;
        struct render_image image = {.width = 100, .height = 100, .noisy_light = &light};
        r.image = &image;
        r.progress.noise_pixel_seconds = PIXEL_SECONDS[i];
        assert_true(fabs(render_budget_left(&r) - 1000.0) < 1.0);
        assert_false(render_budget_filters_noise(&r));
        image.noise_fits = true;
        assert_true(fabs(render_budget_left(&r) - (1000.0 - 0.5 * KEPT[i])) < 1.0);
        image.taken = 10000;
        assert_true(fabs(render_budget_left(&r) - (1000.0 - KEPT[i])) < 1.0);
        assert_int_equal(render_budget_filters_noise(&r), i == 0);
        parallel_free(r.pool);
    }
}

static void noise_of_few_samples_is_not_filtered(void **state) {
    (void)state;
    assert_true(render_budget_fits_noise(0.0));
    assert_true(render_budget_fits_noise(0.89));
    assert_false(render_budget_fits_noise(0.91));
}

// What comes after the image is not usable by what comes before it, unless it takes nearly all of
// the limit.
static void steps_divide_what_is_usable(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
    assert_true(fabs(render_budget_usable(&r) - 1000.0) < 1.0);
    r.progress.write_pixel_seconds = 0.03;
    assert_true(fabs(render_budget_usable(&r) - 700.0) < 1.0);
    r.progress.write_pixel_seconds = 0.2;
    assert_true(fabs(render_budget_usable(&r) - 100.0) < 1.0);
    r.options.time = 0.0;
    assert_true(isinf(render_budget_usable(&r)));
    parallel_free(r.pool);
}

// Rays at rims after the limit are left out where they would take more than half of it.
static void late_rims_do_not_take_long(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        struct render r = budget_case(1000.0);
        struct render_image image = {.width = 100, .height = 100};
        r.image = &image;
        r.options.integrator = SATIN_TWO_PASS;
        r.progress.rim_pixel_seconds = i == 0 ? 0.04 : 0.06;
        assert_int_equal(render_budget_late_rims(&r) > 0.0, i == 0);
        assert_true(fabs(render_budget_left(&r) - (i == 0 ? 600.0 : 1000.0)) < 1.0);
        image.rims_taken = 1;
        assert_true(render_budget_late_rims(&r) == 0.0);
        parallel_free(r.pool);
    }
}

// Kernels of irradiance are as large as fits into a tenth of the limit.
static void filters_of_irradiance_fit(void **state) {
    (void)state;
    struct render r = budget_case(1000.0);
    struct image_gathered gathered;
    struct image_noisy light;
    struct render_image image = {.width = 100,
                                 .height = 100,
                                 .noisy_light = &light,
                                 .gathered = &gathered,
                                 .counts = {.points = 100, .gathered = 1}};
    r.image = &image;
    r.progress.noise_pixel_seconds = 0.03;
    const float largest = render_irradiance_radius(&image, &r.options);
    assert_true(render_budget_filter_radius(&r) == largest);
    const double without = render_budget_left(&r);
    image.counts.gathered = 100;
    assert_true(without - render_budget_left(&r) < 101.0);
    const float radius = render_budget_filter_radius(&r);
    assert_true(radius > 1.0f && radius < largest);
    image.counts.gathered = 50;
    assert_true(fabsf(render_budget_filter_radius(&r) - sqrtf(2.0f) * radius) < 1e-3f * largest);
    parallel_free(r.pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passes_grow_until_little_is_left),
        cmocka_unit_test(passes_take_what_the_options_say),
        cmocka_unit_test(first_samples_are_few),
        cmocka_unit_test(short_limits_have_fewer_light_samples),
        cmocka_unit_test(time_for_the_filter_of_noise_is_kept),
        cmocka_unit_test(noise_of_few_samples_is_not_filtered),
        cmocka_unit_test(steps_divide_what_is_usable),
        cmocka_unit_test(late_rims_do_not_take_long),
        cmocka_unit_test(filters_of_irradiance_fit),
        cmocka_unit_test(rays_at_rims_are_a_fraction_of_the_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
