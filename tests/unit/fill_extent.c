// SPDX-License-Identifier: Apache-2.0
// The bounds of a record's radius, and which of them wins: the largest in scene units, then the
// largest in pixels, then the least in pixels, then what the rays found.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fill/fill_record.h"

static const float FILL_EXTENT_PIXEL = 0.01f;

struct fill_extent_fixture {
    struct satin_scene scene;
    satin_options options;
    struct cache cache;
    struct fill fill;
};

static void fill_extent_start(struct fill_extent_fixture *f) {
    *f = (struct fill_extent_fixture){.options = satin_options_default};
    f->scene.radius = 100.0f;
    f->options.irradiance_a = f->options.radiance_a = 0.5f;
    f->options.irradiance_min_pixels = f->options.radiance_min_pixels = 3.0f;
    f->options.irradiance_max_pixels = f->options.radiance_max_pixels = 20.0f;
    f->cache = (struct cache){.scene = &f->scene, .store[CACHE_RADIANCE].order = 1};
    f->fill = (struct fill){.cache = &f->cache,
                            .side = {{.radius_fraction = 1.0f}, {.radius_fraction = 1.0f}}};
}

// Copies the options to the cache.
static void fill_extent_apply(struct fill_extent_fixture *f) {
    struct cache_options of[CACHE_KINDS];
    cache_options_of(&f->options, of);
    for (int k = 0; k < CACHE_KINDS; k++) f->cache.store[k].options = of[k];
}

// Returns a R in pixels of a record whose rays found walls at that distance. Both caches must
// agree.
static float fill_extent_pixels(struct fill_extent_fixture *f, float distance) {
    fill_extent_apply(f);
    const struct fill_site site = {.frame = frame_from_normal(v3(0, 0, 1)),
                                   .pixel = FILL_EXTENT_PIXEL};
    const struct gather_surroundings around = {.harmonic = distance, .least = distance};
    float lambda[3] = {1, 1, 1}, dx[3] = {0}, dy[3] = {0};
    struct cache_irradiance_value E = {.E = rgb_grey(1.0f)};
    struct gather_radiance L = {.lambda = lambda, .dx = dx, .dy = dy};
    const float R = fill_extent_irradiance(&f->fill, &site, &around, &E).R;
    assert_true(fill_extent_radiance(&f->fill, &site, &around, INFINITY, &L).R == R);
    return R * 0.5f / FILL_EXTENT_PIXEL;
}

static void pixels_bound_what_rays_found(void **state) {
    (void)state;
    struct fill_extent_fixture f;
    fill_extent_start(&f);
    assert_float_equal(fill_extent_pixels(&f, 0.2f), 10.0f, 1e-4f);
    assert_float_equal(fill_extent_pixels(&f, 0.001f), 3.0f, 1e-4f);
    assert_float_equal(fill_extent_pixels(&f, 5.0f), 20.0f, 1e-4f);
    for (int k = 0; k < CACHE_KINDS; k++) f.fill.side[k].radius_fraction = 0.5f;
    assert_float_equal(fill_extent_pixels(&f, 0.001f), 1.5f, 1e-4f);
}

static void largest_pixels_win_over_least(void **state) {
    (void)state;
    struct fill_extent_fixture f;
    fill_extent_start(&f);
    f.options.irradiance_max_pixels = f.options.radiance_max_pixels = 2.0f;
    assert_float_equal(fill_extent_pixels(&f, 0.001f), 2.0f, 1e-4f);
    assert_float_equal(fill_extent_pixels(&f, 5.0f), 2.0f, 1e-4f);
}

// The largest pixels of irradiance records in a cache for this film, by those of the options.
static float largest_for_film(int width, int height, float most) {
    struct satin_scene scene = {.film.width = width, .film.height = height};
    satin_options options = satin_options_default;
    options.irradiance_max_pixels = most;
    struct cache *cache = cache_new(&scene, &options, 1);
    assert_non_null(cache);
    const float pixels = cache->store[CACHE_IRRADIANCE].options.max_pixels;
    cache_free(cache);
    return pixels;
}

// A record whose rays meet nothing has no other bound.
static void film_bounds_irradiance_records(void **state) {
    (void)state;
    assert_float_equal(largest_for_film(400, 300, 100000.0f), 50.0f, 0.0f);
    assert_float_equal(largest_for_film(300, 800, 100000.0f), 100.0f, 0.0f);
    assert_float_equal(largest_for_film(400, 300, 20.0f), 20.0f, 0.0f);
    assert_float_equal(largest_for_film(16, 16, 100000.0f), 8.0f, 0.0f);
    assert_true(isinf(largest_for_film(400, 300, INFINITY)));  // of further bounces
}

static void scene_units_win_over_pixels(void **state) {
    (void)state;
    struct fill_extent_fixture f;
    fill_extent_start(&f);
    f.options.record_max_radius = 0.02f;  // one pixel
    assert_float_equal(fill_extent_pixels(&f, 0.001f), 1.0f, 1e-4f);
    assert_float_equal(fill_extent_pixels(&f, 5.0f), 1.0f, 1e-4f);
    assert_float_equal(fill_least_radius(&f.fill, CACHE_IRRADIANCE, FILL_EXTENT_PIXEL), 0.02f,
                       1e-6f);
}

// A record whose radius is larger than its rays measured has a radius ratio below 1; one whose
// radius is limited has the ratio 1.
static void the_radius_ratio_compares_with_the_wanted_radius(void **state) {
    (void)state;
    struct fill_extent_fixture f;
    fill_extent_start(&f);
    fill_extent_apply(&f);
    const struct fill_site site = {.frame = frame_from_normal(v3(0, 0, 1)),
                                   .pixel = FILL_EXTENT_PIXEL};
    struct gather_surroundings around = {.harmonic = 0.03f};
    struct cache_irradiance_value E = {.E = rgb_grey(1.0f)};
    assert_float_equal(fill_extent_irradiance(&f.fill, &site, &around, &E).radius_ratio, 0.5f,
                       1e-5f);
    around.harmonic = 5.0f;
    assert_float_equal(fill_extent_irradiance(&f.fill, &site, &around, &E).radius_ratio, 1.0f,
                       1e-5f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_bound_what_rays_found),
        cmocka_unit_test(largest_pixels_win_over_least),
        cmocka_unit_test(film_bounds_irradiance_records),
        cmocka_unit_test(scene_units_win_over_pixels),
        cmocka_unit_test(the_radius_ratio_compares_with_the_wanted_radius),
    };
    return cmocka_run_group_tests_name("fill_extent", tests, NULL, NULL);
}
